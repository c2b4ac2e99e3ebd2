# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""One task, from its source to its entry in the ledger. Runs in any process, on any machine."""

from __future__ import annotations

import platform
import socket
import time
import traceback
from dataclasses import dataclass, replace
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Final

from tumtools import __version__
from tumtools.batch.claims import Claims
from tumtools.batch.inputs import staged_source
from tumtools.batch.ledger import DONE, FAILED, SKIPPED, Contents, Entry, Ledger
from tumtools.batch.places import is_around, is_remote
from tumtools.batch.proof import prove
from tumtools.batch.stores import open_store
from tumtools.batch.tree import sha256_of
from tumtools.convert import ConvertOptions, convert
from tumtools.digest import digest
from tumtools.errors import InternalError, OutputError, TumtoolsError
from tumtools.formats.options import ReadOptions
from tumtools.sources import open_source
from tumtools.transform import parse_selection

if TYPE_CHECKING:
    from pathlib import Path

    from tumtools.batch.manifest import Policy
    from tumtools.batch.plan import Task
    from tumtools.batch.stores.store import Store
    from tumtools.batch.tree import Measure
    from tumtools.convert import Report

BUSY, KEPT, WORKED = "busy", "kept", "worked"
_MAX_FINDINGS: Final = 20
_OUT_OF_MEMORY: Final = "out of memory; give it more with --memory-limit, or less to do with fewer workers"
_NO_THREAD: Final = (
    "no thread could be started: out of memory, or of processes; give it more with --memory-limit, "
    "or less to do with fewer workers or `jobs`"
)
_LIBRARIES: Final = ("numpy", "pillow", "isal", "lz4", "zstandard")
"""What the bytes of an output may depend on."""


@dataclass(frozen=True, slots=True)
class Job:
    """All that a worker needs; small, and nothing in it is bound to a machine.

    Attributes:
        task: What to do.
        destination: Where to.
        policy: What holds for all tasks.
        lease: Seconds that a claim lasts.
        scratch: Folder for what is staged; None for the system's.
        since: A task that failed after this (seconds since 1970) is not begun again.
        full: Hash the output of a task that is done, instead of looking at size and time.

    """

    task: Task
    destination: str
    policy: Policy
    lease: float
    scratch: Path | None
    since: float
    full: bool = False


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of a job.

    Attributes:
        task: Id of the task.
        how: `worked`; `kept`: there was nothing to do; `busy`: somebody else works on it.
        entry: What the ledger says now; None if busy.

    """

    task: str
    how: str
    entry: Entry | None


def execute(job: Job) -> Outcome:
    """Do a task unless it is done, and note what came of it.

    Whatever is wrong with the task is in the entry.

    Raises:
        TumtoolsError: The ledger cannot be read or written.

    """
    store = open_store(job.destination, job.scratch)
    ledger, task = Ledger(store), job.task
    entry = ledger.read(task.id)
    if _is_settled(store, job, entry):
        return Outcome(task.id, KEPT, entry)
    with Claims(store, job.lease).hold(task.id, entry.attempts if entry else 0) as claim:
        if claim is None:
            return Outcome(task.id, BUSY, None)
        entry = ledger.read(task.id)  # somebody may have done it just before the claim
        if _is_settled(store, job, entry):
            return Outcome(task.id, KEPT, entry)
        entry = _Attempt(store, job, claim.attempt).run()
        if not claim.renew():
            return Outcome(task.id, BUSY, None)  # taken over; the other one has the word
        ledger.write(entry)
    return Outcome(task.id, WORKED, entry)


def failure(job: Job, attempts: int, reason: str, started: float) -> Entry:
    """Return the entry of a task that could not write one itself."""
    return replace(_blank(job, attempts, started), seconds=time.time() - started, state=FAILED, reason=reason)


def _is_settled(store: Store, job: Job, entry: Entry | None) -> bool:
    if entry is None:
        return False
    if entry.state == FAILED:
        return entry.finished >= job.since
    full = job.full and entry.finished < job.since
    # A source that is out of reach cannot be converted anew either.
    return not prove(store, job.task, entry, full=full, scratch=job.scratch).disproof


def _blank(job: Job, attempts: int, started: float) -> Entry:
    return Entry(
        task=job.task.id,
        state="",
        source=job.task.source.uri,
        output=job.task.output,
        attempts=attempts,
        started=started,
        seconds=0.0,
        host=socket.gethostname(),
        versions=_versions(),
    )


@cache
def _versions() -> dict[str, str]:
    found = {"tumtools": __version__, "python": platform.python_version()}
    for name in _LIBRARIES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue  # installed in a way that leaves no metadata
    return found


class _Attempt:
    """One attempt at a task."""

    def __init__(self, store: Store, job: Job, attempt: int) -> None:
        self._store = store
        self._job = job
        self._task = job.task
        self._path: Path | None = None
        self._entry = _blank(job, attempt, time.time())

    def run(self) -> Entry:
        try:
            with staged_source(self._task.source, self._job.scratch) as staged:
                path = self._path = staged.path
                self._refuse_source(path)
                self._read(path, staged.measure)
                self._entry = self._convert(path) if self._validate(path) else self._entry
        except TumtoolsError as error:
            self._fail(self._told(str(error)), bug=isinstance(error, InternalError))
        except MemoryError:
            self._fail(_OUT_OF_MEMORY)
        except RuntimeError as error:
            # Threads need memory for their stacks; a limit on processes has the same words.
            no_thread = is_out_of_threads(error)
            self._fail(_NO_THREAD if no_thread else _trace(error), bug=not no_thread)
        except Exception as error:  # noqa: BLE001 - one task with a bug must not stop the others
            self._fail(_trace(error), bug=True)
        return replace(self._entry, seconds=time.time() - self._entry.started)

    def _fail(self, reason: str, *, bug: bool = False) -> None:
        self._entry = replace(self._entry, state=FAILED, reason=reason, bug=bug, written=None)

    def _told(self, text: str) -> str:
        """Name the source in a text, and not the copy that was staged of it."""
        return text if self._path is None else text.replace(str(self._path), self._task.source.uri)

    def _refuse_source(self, path: Path) -> None:
        """Refuse to write over a source: links may have been made after the plan was."""
        output = f"{self._job.destination}/{self._task.output}"
        source = self._task.source.uri if is_remote(self._task.source.uri) else str(path)
        if is_around(output, source) or is_around(source, output):
            raise OutputError(
                "the output would be in the way of its source", path=output, hint="change the destination"
            )

    def _read(self, path: Path, found: Measure) -> None:
        read = Contents(found.files, found.bytes, sha256_of(path), found.fingerprint)
        self._entry = replace(self._entry, read=read)

    def _validate(self, path: Path) -> bool:
        """Check the source; return whether to go on."""
        policy = self._job.policy
        if policy.validate == "off":
            return True
        from tumtools.validate.engine import validate  # noqa: PLC0415 - many imports
        from tumtools.validate.finding import Severity  # noqa: PLC0415

        options = self._read_options()
        result = validate(path, full=policy.validate == "full", options=options, jobs=policy.jobs)
        least = Severity.of_word(policy.fail_on)
        found = [finding for finding in result.findings if finding.severity >= least]
        texts = tuple(
            self._told(f"{finding.place}: {finding.code} {finding.message}")
            for finding in found[:_MAX_FINDINGS]
        )
        self._entry = replace(self._entry, findings=texts)
        if not found or policy.on_findings == "warn":
            return True
        state = SKIPPED if policy.on_findings == "skip" else FAILED
        more = f", and {len(found) - 1} more" if len(found) > 1 else ""
        self._entry = replace(self._entry, state=state, reason=f"validation: {texts[0]}{more}")
        return False

    def _convert(self, path: Path) -> Entry:
        task, policy = self._task, self._job.policy
        with self._store.output(task.output) as place:
            report = self._write(path, place)
            sha256, content = sha256_of(place), _digest(place, policy) if policy.digest else ""
        found = self._store.measure(task.output)
        if found is None:
            raise InternalError(f"the output {task.output} is not there after it was written")
        return replace(
            self._entry,
            state=DONE,
            written=Contents(found.files, found.bytes, sha256, found.fingerprint, content),
            losses=report.losses,
        )

    def _write(self, path: Path, place: Path) -> Report:
        target = self._task.target
        options = target.write_options(self._job.policy.jobs)
        with open_source(path, self._read_options()) as sequence:
            selection = parse_selection(sequence, target.start, target.end, target.every, target.streams)
            how = ConvertOptions(selection, target.strict, target.verify, force=True)
            return convert(sequence, place, target.to, options, how)

    def _read_options(self) -> ReadOptions:
        return ReadOptions(self._task.source.topics, self._task.source.salvage)


def is_out_of_threads(error: Exception) -> bool:
    """Whether an error says that the system gave no thread."""
    return isinstance(error, RuntimeError) and "start new thread" in str(error)


def _trace(error: Exception) -> str:
    return f"{type(error).__name__}: {error}\n{traceback.format_exc()}"


def _digest(path: Path, policy: Policy) -> str:
    with open_source(path) as sequence:
        return digest(sequence, jobs=policy.jobs).value
