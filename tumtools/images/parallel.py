# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""An ordered parallel map with a bounded window, for work that releases the GIL."""

from __future__ import annotations

from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

Item = TypeVar("Item")
Result = TypeVar("Result")


def ordered_map(
    function: Callable[[Item], Result], items: Iterable[Item], jobs: int, window: int | None = None
) -> Iterator[Result]:
    """Yield `function(item)` for each item, in order, computed by threads.

    The items are taken from the iterable in the caller's thread. At most `window` results are waited for
    at a time, so memory does not grow with the number of items. An exception of `function` or of the
    iterable is raised at its place in the order.

    Args:
        function: Called in any thread.
        items: Read ahead by at most `window`.
        jobs: Threads; 1 computes in the caller's thread.
        window: Items under way; twice the threads unless told.

    """
    if jobs <= 1:
        yield from map(function, items)
        return
    pending: deque[Future[Result]] = deque()
    limit = window or 2 * jobs
    pool = ThreadPoolExecutor(jobs, thread_name_prefix="tumtools")
    try:
        for item in items:
            pending.append(pool.submit(function, item))
            if len(pending) >= limit:
                yield pending.popleft().result()
        while pending:
            yield pending.popleft().result()
    finally:
        for future in pending:
            future.cancel()
        pool.shutdown(wait=True)
