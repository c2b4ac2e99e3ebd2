# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Fetch several sequences side by side; one that fails does not stop the others."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING

from tumtools.errors import TumtoolsError
from tumtools.fetch.download import CancelledError
from tumtools.fetch.job import fetch
from tumtools.fetch.options import Event, Fetched, FetchOptions, silent

if TYPE_CHECKING:
    from collections.abc import Iterable

    from tumtools.catalogue import Entry
    from tumtools.fetch.options import Report


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of one sequence: either `fetched` or `error` is there."""

    entry: Entry
    fetched: Fetched | None = None
    error: TumtoolsError | None = None


def fetch_all(
    entries: Iterable[Entry], options: FetchOptions | None = None, report: Report = silent
) -> list[Outcome]:
    """Fetch sequences, `options.jobs` of them side by side.

    Args:
        entries: The sequences; one that is named twice is fetched once.
        options: How.
        report: Told what happens, from several threads.

    Returns:
        An outcome for each sequence, in the order given.

    Raises:
        KeyboardInterrupt: What has come stays, and is resumed next time.

    """
    options = options or FetchOptions()
    unique = list({entry.name: entry for entry in entries}.values())
    pool = _Pool(unique, options, report)
    pool.run(max(1, min(options.jobs, len(unique))))
    return [pool.outcomes[entry.name] for entry in unique]


class _Pool:
    """Threads that take sequences from a queue.

    They are daemons: one that waits for a dead connection must not hold up Ctrl-C, and a download can be
    lost at any moment.
    """

    def __init__(self, entries: list[Entry], options: FetchOptions, report: Report) -> None:
        self._todo: SimpleQueue[Entry] = SimpleQueue()
        for entry in entries:
            self._todo.put(entry)
        self._options = options
        self._report = report
        self._cancelled = threading.Event()
        self._crashes: list[BaseException] = []
        self.outcomes: dict[str, Outcome] = {}

    def run(self, count: int) -> None:
        threads = [
            threading.Thread(target=self._work, name=f"fetch {number}", daemon=True)
            for number in range(count)
        ]
        for thread in threads:
            thread.start()
        try:
            for thread in threads:
                thread.join()
        except KeyboardInterrupt:
            self._cancelled.set()
            for thread in threads:
                thread.join(1.0)
            raise
        if self._crashes:
            raise self._crashes[0]

    def _work(self) -> None:
        try:
            while not self._cancelled.is_set():
                entry = self._todo.get_nowait()
                self.outcomes[entry.name] = self._one(entry)
        except (Empty, CancelledError):
            return
        except BaseException as error:  # noqa: BLE001 - raised again by `run`, in the thread that asked
            self._crashes.append(error)
            self._cancelled.set()

    def _one(self, entry: Entry) -> Outcome:
        try:
            fetched = fetch(entry, self._options, self._report, self._cancelled)
        except TumtoolsError as error:
            self._report(Event(entry.label, "failed", message=error.message))
            return Outcome(entry, error=error)
        self._report(Event(entry.label, "done", fetched.bytes, fetched.bytes))
        return Outcome(entry, fetched)
