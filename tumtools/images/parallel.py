# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Threads with bounded windows, for work that releases the GIL: an ordered map, and reading ahead."""

from __future__ import annotations

import queue
from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from threading import Event, Thread
from typing import TYPE_CHECKING, TypeVar

from tumtools.images.memory import keep_freed_memory

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterable

Item = TypeVar("Item")
Result = TypeVar("Result")


def ordered_map(
    function: Callable[[Item], Result],
    items: Iterable[Item],
    jobs: int,
    window: int | None = None,
    *,
    join: bool = False,
) -> Generator[Result, None, None]:
    """Yield `function(item)` for each item, in order, computed by threads.

    The items are taken from the iterable in the caller's thread. At most `window` results are waited for
    at a time, so memory does not grow with the number of items. An exception of `function` or of the
    iterable is raised at its place in the order.

    Args:
        function: Called in any thread.
        items: Read ahead by at most `window`.
        jobs: Threads; 1 computes in the caller's thread.
        window: Items under way; twice the threads unless told.
        join: Wait for the threads when the generator ends early, so that `function` has no effect after
            that. The caller must then close the generator itself and not leave that to the collector.

    """
    keep_freed_memory()
    if jobs <= 1:
        yield from map(function, items)
        return
    pending: deque[Future[Result]] = deque()
    limit = window or 2 * jobs
    pool = ThreadPoolExecutor(jobs, thread_name_prefix="tumtools")
    failure: Exception | None = None
    iterator = iter(items)
    try:
        while True:
            try:
                item = next(iterator)
            except StopIteration:
                break
            except Exception as error:  # noqa: BLE001 - its turn comes after what is under way
                failure = error
                break
            pending.append(pool.submit(function, item))
            if len(pending) >= limit:
                yield pending.popleft().result()
        while pending:
            yield pending.popleft().result()
        if failure is not None:
            raise failure
    finally:
        # No waiting unless told: the garbage collector may be what ends us, inside any lock of this or
        # another pool.
        pool.shutdown(wait=join, cancel_futures=True)


def read_ahead(items: Iterable[Item], window: int) -> Generator[Item, None, None]:
    """Yield the items, taken from the iterable by a thread of its own.

    Args:
        items: An exception of it is raised at its place.
        window: How many items may wait.

    """
    waiting: queue.Queue[tuple[list[Item], BaseException | None]] = queue.Queue(window)
    stop = Event()
    thread = Thread(target=_feed, args=(items, waiting, stop), name="tumtools-read-ahead", daemon=True)
    thread.start()
    try:
        while True:
            item, error = waiting.get()
            if error is not None:
                raise error
            if not item:
                return
            yield item[0]
    finally:
        # Not joined, for the reason given in `ordered_map`; room in the queue lets the thread see the end.
        stop.set()
        with suppress(queue.Empty):
            while True:
                waiting.get_nowait()


def _feed(
    items: Iterable[Item], waiting: queue.Queue[tuple[list[Item], BaseException | None]], stop: Event
) -> None:
    """Put the items into the queue, then an empty entry or the exception, until told to stop."""
    last: tuple[list[Item], BaseException | None] = ([], None)
    try:
        for item in items:
            waiting.put(([item], None))
            if stop.is_set():
                return
    except BaseException as error:  # noqa: BLE001 - it is raised in the caller's thread
        last = ([], error)
    if not stop.is_set():
        waiting.put(last)
