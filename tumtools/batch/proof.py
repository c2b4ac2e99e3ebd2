# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Whether a task is done: its output exists and is what the ledger says, made from the source as it is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from tumtools.batch.inputs import measure_source, sha256_of_source
from tumtools.batch.ledger import DONE, SKIPPED
from tumtools.errors import InputError, MissingInputError, TumtoolsError

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from tumtools.batch.ledger import Contents, Entry
    from tumtools.batch.plan import Task
    from tumtools.batch.stores.store import Store
    from tumtools.batch.tree import Measure


@dataclass(frozen=True, slots=True)
class Proof:
    """What is known of a task that was done or skipped.

    Attributes:
        disproof: Why it must be done again; empty if nothing speaks against it.
        unknown: What could not be told, and why; empty if all could.

    """

    disproof: str = ""
    unknown: str = ""

    @property
    def holds(self) -> bool:
        """Whether the task is proven in all."""
        return not self.disproof and not self.unknown


def prove(
    store: Store,
    task: Task,
    entry: Entry,
    *,
    full: bool = False,
    hashes: bool = True,
    scratch: Path | None = None,
) -> Proof:
    """Look whether a task that was done or skipped still is.

    Names, sizes and times (or ETags) that are as noted are proof enough unless `full`; where only times
    differ the bytes are hashed. A source that is gone makes its output no worse.

    Args:
        store: Where the output is.
        task: The task.
        entry: What the ledger says about it.
        full: Hash the output in any case.
        hashes: Whether anything may be hashed; else what needs it is unknown.
        scratch: Folder for what is downloaded to be hashed; None for the system's.

    """
    if entry.state != SKIPPED and (entry.state != DONE or entry.written is None):
        return Proof(disproof="it was not done")
    if entry.state == DONE and entry.written is not None:
        proof = _prove_output(store, task, entry.written, full=full, hashes=hashes)
        if not proof.holds:
            return proof
    return _prove_source(task, entry.read, scratch, hashes=hashes) if entry.read is not None else Proof()


def _prove_output(store: Store, task: Task, written: Contents, *, full: bool, hashes: bool) -> Proof:
    try:
        found = store.measure(task.output)
        if found is None:
            return Proof(disproof="the output is gone")
        sha256 = (lambda: store.sha256(task.output)) if hashes else None
        return _compare("output", written, found, sha256, full=full)
    except InputError as error:
        return Proof(disproof=f"the output cannot be read: {error.message}")


def _prove_source(task: Task, read: Contents, scratch: Path | None, *, hashes: bool) -> Proof:
    try:
        found = measure_source(task.source)
        if found is None:
            return Proof()
        sha256 = (lambda: sha256_of_source(task.source, scratch)) if hashes else None
        return _compare("source", read, found, sha256, full=False)
    except MissingInputError:
        return Proof()
    except TumtoolsError as error:
        return Proof(unknown=f"the source cannot be compared: {error.message}")


def _compare(
    what: str, noted: Contents, found: Measure, sha256: Callable[[], str] | None, *, full: bool
) -> Proof:
    if (noted.files, noted.bytes) != (found.files, found.bytes):
        return Proof(
            f"the {what} has {found.files} files of {found.bytes} bytes, "
            f"the ledger says {noted.files} of {noted.bytes}"
        )
    if noted.fingerprint == found.fingerprint and not full:
        return Proof()
    if sha256 is None:
        return Proof(unknown=f"the {what} would have to be hashed")
    return Proof() if sha256() == noted.sha256 else Proof(f"the {what} has other bytes than the ledger says")
