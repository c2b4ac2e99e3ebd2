# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The ledger: what came of each task, one small JSON object each, below the destination."""

from __future__ import annotations

import json
import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Final

from tumtools.batch.plan import LEDGER_FOLDER
from tumtools.batch.records import build, load
from tumtools.model.sequence import Loss  # noqa: TC001 - the type of a field is looked at

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from tumtools.batch.stores.store import Store

SCHEMA_VERSION: Final = 1
DONE, FAILED, SKIPPED = "done", "failed", "skipped"
_STATES: Final = (DONE, FAILED, SKIPPED)
_READERS: Final = 16


@dataclass(frozen=True, slots=True)
class Contents:
    """A file or folder as it was.

    Attributes:
        files: How many files.
        bytes: Their size.
        sha256: Of the file, or of the folder's listing (`tree.sha256_of`).
        fingerprint: As in `stores.store.Measure`.
        digest: Content digest that does not depend on the format; empty if it was not asked for.

    """

    files: int
    bytes: int
    sha256: str
    fingerprint: str
    digest: str = ""


@dataclass(frozen=True, slots=True)
class Entry:
    """What came of a task.

    Attributes:
        task: Its id.
        state: `done`, `failed` or `skipped`.
        source: Its URI.
        output: Name below the destination.
        attempts: How often it was begun.
        started: Seconds since 1970.
        seconds: How long the last attempt took.
        host: Where.
        versions: Of tumtools and of what the bytes may depend on.
        read: The source.
        written: The output; None unless done.
        losses: What the conversion lost.
        findings: What validation found: the first few, as texts.
        reason: Why it failed or was skipped.
        bug: Whether that is a bug of tumtools.

    """

    task: str
    state: str
    source: str
    output: str
    attempts: int
    started: float
    seconds: float
    host: str
    versions: Mapping[str, str] = field(default_factory=dict)
    read: Contents | None = None
    written: Contents | None = None
    losses: tuple[Loss, ...] = ()
    findings: tuple[str, ...] = ()
    reason: str = ""
    bug: bool = False

    @property
    def finished(self) -> float:
        """Seconds since 1970."""
        return self.started + self.seconds


class Ledger:
    """The entries in a store."""

    def __init__(self, store: Store) -> None:
        self._store = store

    def read(self, task: str) -> Entry | None:
        """Return the entry of a task, or None.

        An entry that is damaged, of another task or of another version is none: the task is done again.
        """
        data = self._store.read(_name(task))
        return None if data is None else _parse(task, data)

    def read_all(self, tasks: Iterable[str]) -> Iterator[Entry | None]:
        """Yield the entries of tasks, in their order; only those that are there are asked for."""
        tasks = list(tasks)
        there = {name.rpartition("/")[2].removesuffix(".json") for name in self._store.names(_FOLDER)}
        with ThreadPoolExecutor(_READERS) as pool:
            yield from pool.map(lambda task: self.read(task) if task in there else None, tasks)

    def write(self, entry: Entry) -> None:
        """Note what came of a task, in place of what was noted before.

        Raises:
            OutputError: It cannot be written.

        """
        document = {"schema_version": SCHEMA_VERSION, **asdict(entry)}
        self._store.write(_name(entry.task), (json.dumps(document, indent=1) + "\n").encode())


_FOLDER: Final = f"{LEDGER_FOLDER}/ledger/"


def _name(task: str) -> str:
    # Two levels: folders with millions of files are slow on many file systems.
    return f"{_FOLDER}{task[:2]}/{task}.json"


def _parse(task: str, data: bytes) -> Entry | None:
    try:
        document = dict(load(data))
        if document.pop("schema_version", None) != SCHEMA_VERSION:
            return None
        entry = build(Entry, document)
    except ValueError:
        return None
    known = entry.task == task and entry.state in _STATES and math.isfinite(entry.finished)
    return entry if known else None


def document(entry: Entry) -> dict[str, object]:
    """Return an entry for JSON."""
    return asdict(entry)
