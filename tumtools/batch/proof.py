# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Whether a task is done: its output exists and is what the ledger says, made from the source as it is."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tumtools.batch.inputs import measure_source, sha256_of_source
from tumtools.batch.ledger import DONE, SKIPPED
from tumtools.errors import InputError, TumtoolsError

if TYPE_CHECKING:
    from collections.abc import Callable

    from tumtools.batch.ledger import Contents, Entry
    from tumtools.batch.plan import Task
    from tumtools.batch.stores.store import Store
    from tumtools.batch.tree import Measure


def disproof(store: Store, task: Task, entry: Entry, *, full: bool = False) -> str:
    """Return why a task that was done or skipped must be done again; empty if it is proven.

    Names, sizes and times (or ETags) that are as noted are proof enough unless `full`; where only times
    differ the bytes are hashed.

    Args:
        store: Where the output is.
        task: The task.
        entry: What the ledger says about it.
        full: Hash the output in any case.

    """
    if entry.state == DONE and entry.written is not None:
        try:
            return _of_output(store, task, entry.written, full=full) or _of_source(task, entry)
        except InputError as error:
            return f"the output cannot be read: {error.message}"
    return _of_source(task, entry) if entry.state == SKIPPED else "it was not done"


def _of_output(store: Store, task: Task, written: Contents, *, full: bool) -> str:
    found = store.measure(task.output)
    if found is None:
        return "the output is gone"
    return _differs("output", written, found, lambda: store.sha256(task.output), full=full)


def _of_source(task: Task, entry: Entry) -> str:
    """Compare the source with what was read; one that is gone or out of reach makes its outputs no worse."""
    if entry.read is None:
        return ""
    try:
        found = measure_source(task.source)
        if found is None:
            return ""
        return _differs("source", entry.read, found, lambda: sha256_of_source(task.source), full=False)
    except TumtoolsError:
        return ""


def _differs(what: str, noted: Contents, found: Measure, sha256: Callable[[], str], *, full: bool) -> str:
    if (noted.files, noted.bytes) != (found.files, found.bytes):
        return (
            f"the {what} has {found.files} files of {found.bytes} bytes, "
            f"the ledger says {noted.files} of {noted.bytes}"
        )
    if noted.fingerprint == found.fingerprint and not full:
        return ""
    return "" if sha256() == noted.sha256 else f"the {what} has other bytes than the ledger says"
