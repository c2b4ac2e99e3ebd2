# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Threads keep the order, a bounded window, and leave nothing behind."""

from __future__ import annotations

import gc
import threading
import time
from types import SimpleNamespace
from typing import TYPE_CHECKING

import pytest

from tumtools.images.parallel import ROOM_BYTES, batch_of, ordered_map, read_ahead, take_room
from tumtools.model.sequence import ImageStreamInfo, SequenceInfo

if TYPE_CHECKING:
    from collections.abc import Iterator


def _ours() -> list[threading.Thread]:
    return [thread for thread in threading.enumerate() if thread.name.startswith("tumtools")]


@pytest.fixture(autouse=True)
def _no_threads_are_left() -> Iterator[None]:
    yield
    for thread in _ours():
        thread.join(5)
    assert _ours() == []


def _items(taken: list[int], count: int = 100, fail_at: int | None = None) -> Iterator[int]:
    for number in range(count):
        if number == fail_at:
            raise KeyError(number)
        taken.append(number)
        yield number


@pytest.mark.parametrize("batch", [1, 4])
@pytest.mark.parametrize("jobs", [1, 2, 8])
def test_results_come_in_order(jobs: int, batch: int) -> None:
    def slow_first(number: int) -> int:
        time.sleep(0.002 * (number % 3 == 0))
        return -number

    assert list(ordered_map(slow_first, range(50), jobs, batch=batch)) == [-number for number in range(50)]


@pytest.mark.parametrize(
    ("jobs", "window", "batch", "ahead"),
    [(2, None, 1, 8), (2, 3, 1, 3), (4, 1, 1, 1), (1, None, 1, 1), (2, None, 4, 16), (2, 1, 4, 4)],
)
def test_items_are_taken_within_the_window(jobs: int, window: int | None, batch: int, ahead: int) -> None:
    taken: list[int] = []
    for done, _ in enumerate(ordered_map(str, _items(taken), jobs, window, batch=batch)):
        assert len(taken) - done <= ahead
    assert len(taken) == 100


@pytest.mark.parametrize("jobs", [1, 2, 8])
def test_large_images_are_worked_on_one_at_a_time_and_small_ones_together(jobs: int) -> None:
    lock = threading.Lock()
    held = {"now": 0, "most": 0}

    def decode(nbytes: int) -> int:
        take_room(nbytes)
        with lock:
            held["now"] += nbytes
            held["most"] = max(held["most"], held["now"])
        time.sleep(0.001)
        return nbytes

    sizes = [ROOM_BYTES // 4] * 12 + [ROOM_BYTES, 10, 2 * ROOM_BYTES] * 5
    done = []
    for nbytes in ordered_map(decode, sizes, jobs):
        done.append(nbytes)
        time.sleep(0.001)
        with lock:
            held["now"] -= nbytes
    assert done == sizes
    # The one that is waited for is let in while the one before it is still in use.
    assert held["most"] <= 3 * ROOM_BYTES + 10 * jobs


@pytest.mark.parametrize("batch", [1, 4])
@pytest.mark.parametrize("join", [True, False])
def test_who_waits_for_room_goes_home_when_nobody_wants_the_results(join: bool, batch: int) -> None:
    results = ordered_map(take_room, [2 * ROOM_BYTES] * 20, 4, batch=batch, join=join)
    next(results)
    results.close()


def test_an_item_of_a_batch_gives_its_room_back_when_it_is_done() -> None:
    """Else two threads with two large images each would wait for each other's batches."""
    together = threading.Barrier(2, timeout=10)

    def work(number: int) -> None:
        take_room(ROOM_BYTES // 2)
        if number in {3, 7}:  # the last items of the first two batches
            together.wait()

    assert list(ordered_map(work, range(8), 2, batch=4)) == [None] * 8


@pytest.mark.parametrize(
    ("sizes", "batch"),
    [
        ([(640, 480), (640, 480)], 4),
        ([(640, 480), (1280, 720)], 2),
        ([(4000, 3000)], 1),
        ([(640, 480), (0, 0)], 1),
        ([], 1),
    ],
)
def test_large_images_are_handed_over_alone(sizes: list[tuple[int, int]], batch: int) -> None:
    """Frames of raw images hold what they were read from, which no room is taken for."""
    streams = {str(row): ImageStreamInfo(9, width=w, height=h) for row, (w, h) in enumerate(sizes)}
    none = {"none": ImageStreamInfo(0)}
    assert batch_of(SimpleNamespace(info=SequenceInfo("x", "tum", images=streams | none))) == batch


def test_a_batch_ends_early_when_nobody_wants_its_results() -> None:
    done: list[int] = []
    begun, go = threading.Event(), threading.Event()

    def work(number: int) -> None:
        if number == 2:
            begun.set()
            go.wait(10)
        done.append(number)

    results = ordered_map(work, range(4), 2, window=2, batch=2)
    next(results)
    begun.wait(10)
    results.close()
    go.set()
    for thread in _ours():
        thread.join(10)
    assert sorted(done) == [0, 1, 2]


def test_an_error_lets_those_who_wait_for_room_go(caplog: pytest.LogCaptureFixture) -> None:
    def fail(number: int) -> None:
        take_room(2 * ROOM_BYTES)
        if number == 2:
            raise KeyError(number)

    with pytest.raises(KeyError):
        list(ordered_map(fail, range(20), 4, join=True))
    assert not caplog.records


def test_the_function_runs_in_the_threads_and_the_iterable_in_the_callers() -> None:
    def items() -> Iterator[threading.Thread]:
        for _ in range(5):
            yield threading.current_thread()

    pairs = list(ordered_map(lambda caller: (caller, threading.current_thread()), items(), 2))
    assert all(caller is threading.main_thread() and worker is not caller for caller, worker in pairs)


@pytest.mark.parametrize("batch", [1, 4])
@pytest.mark.parametrize("jobs", [1, 2, 8])
def test_an_exception_of_the_function_comes_at_its_place(jobs: int, batch: int) -> None:
    results = ordered_map(lambda number: 1 // (7 - number), range(100), jobs, batch=batch)
    assert [next(results) for _ in range(7)] == [1 // (7 - number) for number in range(7)]
    with pytest.raises(ZeroDivisionError):
        next(results)


@pytest.mark.parametrize("batch", [1, 4])
@pytest.mark.parametrize("jobs", [1, 2, 8])
def test_an_exception_of_the_iterable_comes_at_its_place(jobs: int, batch: int) -> None:
    results = ordered_map(str, _items([], fail_at=7), jobs, batch=batch)
    assert [next(results) for _ in range(7)] == list("0123456")
    with pytest.raises(KeyError):
        next(results)


def test_what_is_abandoned_leaves_no_threads() -> None:
    results = ordered_map(str, _items([]), 4)
    assert next(results) == "0"
    results.close()


def test_read_ahead_gives_the_items_in_order_and_no_more_than_the_window_early() -> None:
    taken: list[int] = []
    for done, number in enumerate(read_ahead(_items(taken), 3)):
        assert number == done
        # In the queue, and one in the hands of the thread on either side.
        assert len(taken) - done <= 3 + 2
    assert len(taken) == 100


def test_read_ahead_passes_on_an_exception_at_its_place() -> None:
    items = read_ahead(_items([], fail_at=5), 2)
    assert [next(items) for _ in range(5)] == [0, 1, 2, 3, 4]
    with pytest.raises(KeyError):
        next(items)


@pytest.mark.parametrize("taken", [0, 1, 50])
def test_read_ahead_that_is_abandoned_leaves_no_thread(taken: int) -> None:
    items = read_ahead(iter(range(10**9)), 2)
    for _ in range(taken):
        next(items)
    del items
    gc.collect()


def test_items_may_be_none_or_empty() -> None:
    assert list(read_ahead([None, [], 0], 1)) == [None, [], 0]
    assert list(ordered_map(bool, [None, [], 0], 2)) == [False, False, False]
    assert list(read_ahead([], 1)) == list(ordered_map(str, [], 2)) == []
