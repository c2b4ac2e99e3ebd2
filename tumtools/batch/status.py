# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Where the tasks of a plan stand."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from tumtools.batch.claims import Claim, Claims
from tumtools.batch.ledger import DONE, SKIPPED, Entry, Ledger
from tumtools.batch.proof import prove
from tumtools.batch.stores import open_store
from tumtools.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from tumtools.batch.plan import Plan, Task
    from tumtools.batch.stores.store import Store

STATES: Final = ("done", "skipped", "failed", "running", "interrupted", "changed", "unknown", "pending")
"""`interrupted`: begun by a process that is gone; `changed`: done once, but the output or the source is no
longer what the ledger says; `unknown`: that could not be told of the source."""
_THREADS: Final = 8


@dataclass(frozen=True, slots=True)
class Standing:
    """Where a task stands.

    Attributes:
        task: The task.
        state: One of `STATES`.
        entry: What the ledger says, if anything.
        claim: Who works on it, if anybody.
        changed: Why it must be done again although it was done; else empty.
        unknown: Why that cannot be told; else empty.
        stale: Whether something is there under the name of the output although the task failed or was
            skipped: it is older.

    """

    task: Task
    state: str
    entry: Entry | None = None
    claim: Claim | None = None
    changed: str = ""
    unknown: str = ""
    stale: bool = False


def status(plan: Plan, *, full: bool = False, scratch: Path | None = None) -> Iterator[Standing]:
    """Yield where each task stands, in the order of the plan.

    Args:
        plan: The plan.
        full: Hash all outputs, instead of looking at sizes and times.
        scratch: Folder for what is downloaded to be hashed; None for the system's.

    Raises:
        InputError: The ledger cannot be read.

    """
    store = open_store(plan.destination, scratch)
    claims = {claim.task: claim for claim in Claims(store).all()}
    entries = Ledger(store).read_all(task.id for task in plan.tasks)

    def stand(task: Task, entry: Entry | None) -> Standing:
        claim = claims.get(task.id)
        working = claim is not None and not claim.has_expired()
        if working and (entry is None or entry.state != DONE):
            return Standing(task, "running", entry, claim)
        if entry is None:
            return Standing(task, "pending" if claim is None else "interrupted", None, claim)
        if entry.state not in {DONE, SKIPPED}:
            return Standing(task, entry.state, entry, stale=_is_there(store, task))
        proof = prove(store, task, entry, full=full, scratch=scratch)
        state = entry.state
        if proof.disproof:
            state = "running" if working else "changed"
        elif proof.unknown:
            state = "unknown"
        stale = state == SKIPPED and _is_there(store, task)
        return Standing(task, state, entry, claim, proof.disproof, proof.unknown, stale)

    with ThreadPoolExecutor(_THREADS) as pool:
        yield from pool.map(stand, plan.tasks, entries)


def _is_there(store: Store, task: Task) -> bool:
    try:
        return store.measure(task.output) is not None
    except InputError:
        return True  # and cannot be looked at
