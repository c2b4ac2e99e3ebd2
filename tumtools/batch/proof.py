# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Whether a task is done: its output exists and is what the ledger says, made from the source as it is."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tumtools.batch.inputs import measure_source, sha256_of_source
from tumtools.batch.ledger import DONE, SKIPPED
from tumtools.errors import TumtoolsError

if TYPE_CHECKING:
    from collections.abc import Callable

    from tumtools.batch.ledger import Contents, Entry
    from tumtools.batch.plan import Task
    from tumtools.batch.stores.store import Store
    from tumtools.batch.tree import Measure


def is_done(store: Store, task: Task, entry: Entry | None, *, full: bool = False) -> bool:
    """Whether the output of a task is proven.

    Names, sizes and times (or ETags) that are as noted are proof enough unless `full`; where only times
    differ the bytes are hashed.

    Args:
        store: Where the output is.
        task: The task.
        entry: What the ledger says about it.
        full: Hash the output in any case.

    Raises:
        InputError: The output is there and cannot be read.

    """
    if entry is None or entry.state != DONE or entry.written is None:
        return False
    measure = store.measure(task.output)
    return (
        measure is not None
        and _is_same(entry.written, measure, lambda: store.sha256(task.output), full=full)
        and is_source_unchanged(task, entry)
    )


def is_skipped(task: Task, entry: Entry | None) -> bool:
    """Whether a task was skipped for findings in the very source that is there."""
    return entry is not None and entry.state == SKIPPED and is_source_unchanged(task, entry)


def is_source_unchanged(task: Task, entry: Entry) -> bool:
    """Whether the source is what was read; one that is gone or out of reach makes its outputs no worse."""
    if entry.read is None:
        return True
    try:
        measure = measure_source(task.source)
        return measure is None or _is_same(
            entry.read, measure, lambda: sha256_of_source(task.source), full=False
        )
    except TumtoolsError:
        return True


def _is_same(noted: Contents, found: Measure, sha256: Callable[[], str], *, full: bool) -> bool:
    if not noted.looks_like(found):
        return False
    return (noted.fingerprint == found.fingerprint and not full) or sha256() == noted.sha256
