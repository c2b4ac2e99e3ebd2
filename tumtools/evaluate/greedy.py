# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The scripts' greedy pairs in O(n log n) time and O(n) memory.

The scripts build all n * m differences, sort them and take them in turn. The same pairs follow from
two facts about points on a line, here the stamps of both streams merged into one sorted list:

* The pair that is taken next always consists of neighbours in the list of the points still free: a
  point between the two would be nearer to one of them.
* A pair that comes before every pair it shares a point with (in the order of difference, first,
  second) is taken whatever happens elsewhere.

So all pairs of the second kind are taken at once, in a few vectorised rounds, and what is left in
chains of conflicts (ever smaller distances) goes through a heap over neighbours in a linked list.
"""

from __future__ import annotations

import heapq
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.evaluate.seconds import rounded_seconds

if TYPE_CHECKING:
    import numpy.typing as npt

    Pairs = tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]

_WORTHWHILE: Final = 0.02
"""A vectorised round goes on being worth it while it takes this share of the open pairs."""


def greedy_pairs(
    first: npt.NDArray[np.int64], second: npt.NDArray[np.int64], max_difference: int, offset: int = 0
) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Pair as the benchmark's `associate.py`: smallest (difference, first, second) first, one to one.

    Equal differences are put in order as float64 sees them (`tumtools.evaluate.seconds`).

    Args:
        first: Strictly ascending stamps, ns, shape [n].
        second: Strictly ascending stamps, ns, shape [m], the offset added.
        max_difference: Differences must be below this, ns.
        offset: What was added to the second stamps, ns.

    Returns:
        Indices into `first` and `second`, shape [k] each, in no particular order.

    """
    times = np.concatenate([first, second])
    order = np.argsort(times, kind="stable")
    times = times[order]
    seconds = np.concatenate([rounded_seconds(first), rounded_seconds(second - offset, offset)])[order]
    taken: list[npt.NDArray[np.intp]] = []
    while True:
        left, n_open = _undisputed(times, seconds, order < len(first), max_difference)
        if not len(left):
            break
        taken.append(np.stack([order[left], order[left + 1]]))
        keep = np.ones(len(times), bool)
        keep[left] = keep[left + 1] = False
        times, seconds, order = times[keep], seconds[keep], order[keep]
        if len(left) < _WORTHWHILE * n_open:
            taken.append(_by_heap(times, seconds, order, len(first), max_difference))
            break
    ends = np.concatenate(taken, axis=1) if taken else np.empty((2, 0), np.intp)
    return ends.min(axis=0), ends.max(axis=0) - len(first)


def _undisputed(
    times: npt.NDArray[np.int64],
    seconds: npt.NDArray[np.float64],
    is_first: npt.NDArray[np.bool_],
    max_difference: int,
) -> tuple[npt.NDArray[np.intp], int]:
    """Find the neighbours that come before every other pair of theirs.

    Returns:
        Position of the left one of each such pair, and how many neighbours could be pairs at all.

    """
    if not len(times):
        return np.empty(0, np.intp), 0
    places = np.arange(len(times))
    # The nearest point of the other stream on either side of each point, -1 or n for none.
    earlier = np.where(
        is_first,
        np.maximum.accumulate(np.where(is_first, -1, places)),
        np.maximum.accumulate(np.where(is_first, places, -1)),
    )
    later = np.where(
        is_first,
        np.minimum.accumulate(np.where(is_first, len(times), places)[::-1])[::-1],
        np.minimum.accumulate(np.where(is_first, places, len(times))[::-1])[::-1],
    )
    later_there = later.clip(max=len(times) - 1)
    # Unsigned, because stamps at both ends of int64 may be neighbours.
    unsigned = times.view(np.uint64)
    none = np.uint64(np.iinfo(np.uint64).max)
    before = np.where(earlier >= 0, unsigned - unsigned[earlier], none)
    after = np.where(later < len(times), unsigned[later_there] - unsigned, none)
    rounded_before = np.abs(seconds - seconds[earlier])
    rounded_after = np.abs(seconds[later_there] - seconds)
    tie = before == after
    open_pairs = (is_first[1:] != is_first[:-1]) & (after[:-1] < max_difference)
    # Of two pairs that share a point and have one difference, the left one has the smaller stamps.
    goes_right = (after < before) | (tie & (rounded_after < rounded_before))
    goes_left = (before < after) | (tie & (rounded_before <= rounded_after))
    wins = open_pairs & goes_right[:-1] & goes_left[1:]
    return np.flatnonzero(wins), int(np.count_nonzero(open_pairs))


def _by_heap(
    times: npt.NDArray[np.int64],
    seconds: npt.NDArray[np.float64],
    order: npt.NDArray[np.intp],
    n_first: int,
    max_difference: int,
) -> npt.NDArray[np.intp]:
    """Take pairs one by one. Returns positions in the concatenated streams, shape [2, k]."""
    # Lists, because they are faster to walk than arrays.
    stamp, rounded, point = times.tolist(), seconds.tolist(), order.tolist()
    n = len(stamp)
    before, after = list(range(-1, n - 1)), list(range(1, n + 1))
    free = [True] * n

    def key(left: int, right: int) -> tuple[int, float, int, int, int] | None:
        gap = stamp[right] - stamp[left]
        if gap >= max_difference or (point[left] < n_first) == (point[right] < n_first):
            return None
        a = left if point[left] < n_first else right
        return gap, abs(rounded[right] - rounded[left]), stamp[a], left, right

    heap = [item for left in range(n - 1) if (item := key(left, left + 1))]
    heapq.heapify(heap)
    pairs: list[tuple[int, int]] = []
    while heap:
        _, _, _, left, right = heapq.heappop(heap)
        if not (free[left] and free[right]):
            continue
        free[left] = free[right] = False
        pairs.append((point[left], point[right]))
        outer_left, outer_right = before[left], after[right]
        if outer_left >= 0:
            after[outer_left] = outer_right
        if outer_right < n:
            before[outer_right] = outer_left
        if outer_left >= 0 and outer_right < n and (item := key(outer_left, outer_right)):
            heapq.heappush(heap, item)
    return np.array(pairs, np.intp).reshape(-1, 2).T
