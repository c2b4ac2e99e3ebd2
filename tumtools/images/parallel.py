# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Threads with bounded windows, for work that releases the GIL: an ordered map, and reading ahead."""

from __future__ import annotations

import queue
from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from itertools import islice
from threading import Condition, Event, Thread, local
from typing import TYPE_CHECKING, Final, Generic, TypeAlias, TypeVar

from tumtools.images.memory import keep_freed_memory

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterable, Iterator

    from tumtools.model.sequence import Sequence

ROOM_BYTES: Final = 64 * 2**20
"""Of decoded images under way at a time: some eighty of the benchmark's; a larger one goes alone."""

_BATCH: Final = 4
"""Images to hand over together where they take a millisecond or so: each handing over wakes two threads."""
_BATCH_BYTES: Final = 8 * 2**20
"""Of pixels; several megapixels are handed over alone, since a frame may hold what it is read from."""
_BYTES_PER_PIXEL: Final = 4
_WINDOW: Final = 4
"""Items for each thread. With two, a thread often waits for the caller to come and give it another one."""
_WINDOW_OF_BATCHES: Final = 2

Item = TypeVar("Item")
Result = TypeVar("Result")
_Done: TypeAlias = tuple[list[Result], Exception | None]
"""What a thread has made of a batch, and what ended that early."""


class _Room:
    """Shares out the memory for images among the items of one `ordered_map`.

    The item whose result is waited for always gets what it wants, so the others can wait until enough is
    free: no order of waiting can be a circle.
    """

    def __init__(self) -> None:
        self._changed = Condition()
        self._taken: dict[int, int] = {}
        self._due = -1
        self._closed = False

    def take(self, number: int, nbytes: int) -> None:
        with self._changed:
            while not (
                self._closed or number <= self._due or sum(self._taken.values()) + nbytes <= ROOM_BYTES
            ):
                self._changed.wait()
            self._taken[number] = self._taken.get(number, 0) + nbytes

    def wait_for(self, number: int) -> None:
        """Tell that the results before an item have been used, and that this one is wanted next."""
        with self._changed:
            self._due = number
            for past in [one for one in self._taken if one < number]:
                del self._taken[past]
            self._changed.notify_all()

    def give_back(self, number: int) -> bool:
        """Give back what an item has taken before its result is used; tell whether anybody wants that."""
        with self._changed:
            if self._taken.pop(number, 0):
                self._changed.notify_all()
            return not self._closed

    def close(self) -> None:
        """Let everybody go on: nobody waits for results any more."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()


class _Place(local):
    """Which item of which `ordered_map` a thread works on."""

    room: _Room | None = None
    number: int = 0


_PLACE: Final = _Place()


def take_room(nbytes: int) -> None:
    """Wait until there is room for an image of so many bytes; called before it is decoded.

    It is given back when the result of the item has been used. Outside of `ordered_map` one image is
    worked on at a time, and there is nothing to wait for.
    """
    if _PLACE.room is not None:
        _PLACE.room.take(_PLACE.number, nbytes)


def batch_of(sequence: Sequence) -> int:
    """Return how many images of a sequence to hand to a thread together: one if they are large or unknown."""
    streams = [stream for stream in sequence.info.images.values() if stream.count]
    largest = max((stream.width * stream.height for stream in streams), default=0)
    known = all(stream.width for stream in streams)
    return max(1, min(_BATCH, _BATCH_BYTES // (_BYTES_PER_PIXEL * largest))) if known and largest else 1


def ordered_map(
    function: Callable[[Item], Result],
    items: Iterable[Item],
    jobs: int,
    window: int | None = None,
    *,
    batch: int = 1,
    join: bool = False,
) -> Generator[Result, None, None]:
    """Yield `function(item)` for each item, in order, computed by threads.

    The items are taken from the iterable in the caller's thread. At most `window` results are waited for
    at a time, and fewer if they are of large images (`take_room`), so memory does not grow with the number
    of items. An exception of `function` or of the iterable is raised at its place in the order.

    Args:
        function: Called in any thread.
        items: Read ahead by at most `window`.
        jobs: Threads; 1 computes in the caller's thread.
        window: Batches under way; twice the threads unless told, four times if they are of one item. Fewer
            for what takes much memory.
        batch: Items that are handed to a thread together. More than one (`batch_of`) saves time where
            results hold no image: what an item takes of the room is given back as soon as it is done.
        join: Wait for the threads when the generator ends early, so that `function` has no effect after
            that. The caller must then close the generator itself and not leave that to the collector.

    """
    keep_freed_memory()
    if jobs <= 1:
        yield from map(function, items)
        return
    pending: deque[Future[_Done[Result]]] = deque()
    limit = window or jobs * (_WINDOW if batch == 1 else _WINDOW_OF_BATCHES)
    pool = ThreadPoolExecutor(jobs, thread_name_prefix="tumtools")
    room = _Room()
    batches = _Batches(items, batch)
    given = 0

    def done() -> Iterator[Result]:
        room.wait_for(given - len(pending))
        results, error = pending.popleft().result()
        yield from results
        if error is not None:
            raise error

    try:
        for taken in batches:
            pending.append(pool.submit(_work, function, taken, room, given))
            given += 1
            if len(pending) >= limit:
                yield from done()
        while pending:
            yield from done()
        if batches.failure is not None:
            raise batches.failure
    finally:
        room.close()
        # No waiting unless told: the garbage collector may be what ends us, inside any lock of this or
        # another pool.
        pool.shutdown(wait=join, cancel_futures=True)


def _work(function: Callable[[Item], Result], taken: list[Item], room: _Room, number: int) -> _Done[Result]:
    """Work on a batch, until it is done, something is raised, or nobody wants the results any more."""
    _PLACE.room, _PLACE.number = room, number
    results: list[Result] = []
    try:
        for item in taken:
            results.append(function(item))
            if len(taken) > 1 and not room.give_back(number):
                break
    except Exception as error:  # noqa: BLE001 - its turn comes after the results before it
        return results, error
    finally:
        _PLACE.room = None
    return results, None


class _Batches(Generic[Item]):
    """Takes items a few at a time; what the iterable raises ends it and is kept."""

    def __init__(self, items: Iterable[Item], size: int) -> None:
        self._items = iter(items)
        self._size = size
        self.failure: Exception | None = None

    def __iter__(self) -> Iterator[list[Item]]:
        while self.failure is None and (taken := self._take()):
            yield taken

    def _take(self) -> list[Item]:
        taken: list[Item] = []
        try:
            for item in islice(self._items, self._size):
                taken.append(item)  # noqa: PERF402 - what was taken before an exception counts
        except Exception as error:  # noqa: BLE001 - its turn comes after what was taken
            self.failure = error
        return taken


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
