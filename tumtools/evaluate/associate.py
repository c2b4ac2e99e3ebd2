# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Which rows of two streams belong together, told by their stamps alone.

Three rules, all on integer nanoseconds:

* `tum`: the benchmark's `associate.py`. Of all pairs closer than the limit (strictly), the one with
  the smallest (difference, first stamp, second stamp) is taken, then the next whose rows are both
  still free, and so on.
* `nearest`: evo's rule. Each row of the shorter stream takes the nearest of the longer one, if that
  is not farther than the limit. A row of the longer stream may be taken twice.
* `optimal`: as many pairs as possible, and among those choices the least sum of differences.

Of rows with the same stamp only the last counts, as in the dictionaries of the scripts.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, TypeVar, get_args

import numpy as np

from tumtools.errors import UsageError
from tumtools.evaluate.greedy import greedy_pairs
from tumtools.evaluate.optimal import optimal_pairs
from tumtools.evaluate.seconds import rounded_seconds

if TYPE_CHECKING:
    import numpy.typing as npt

Method = Literal["tum", "nearest", "optimal"]
METHODS: Final[tuple[Method, ...]] = get_args(Method)

MAX_DIFFERENCE: Final = 20_000_000
"""The limit that the benchmark's scripts use by default: 20 ms."""


@dataclass(frozen=True, slots=True, eq=False)
class Association:
    """Pairs of rows, in order of the first stream's stamps.

    Attributes:
        first: Rows of the first stream, shape [k].
        second: Rows of the second stream, shape [k].
        differences: First stamp - (second stamp + offset), ns, int64, shape [k].
        first_count: Distinct stamps of the first stream.
        second_count: Distinct stamps of the second stream.

    """

    first: npt.NDArray[np.intp]
    second: npt.NDArray[np.intp]
    differences: npt.NDArray[np.int64]
    first_count: int
    second_count: int

    def __len__(self) -> int:
        return len(self.first)

    @property
    def unmatched_first(self) -> int:
        """Distinct stamps of the first stream without a partner."""
        return self.first_count - len(np.unique(self.first))

    @property
    def unmatched_second(self) -> int:
        """Distinct stamps of the second stream without a partner."""
        return self.second_count - len(np.unique(self.second))

    @property
    def largest_difference(self) -> int:
        """Largest distance in time of a pair, ns; 0 without pairs."""
        return int(np.abs(self.differences).max()) if len(self) else 0


def last_rows(stamps: npt.NDArray[np.int64]) -> npt.NDArray[np.intp]:
    """Return the rows in order of their stamps, of equal stamps only the last row, shape [k <= n]."""
    order = np.argsort(stamps, kind="stable")
    ordered = stamps[order]
    last = np.ones(len(stamps), bool)
    np.not_equal(ordered[1:], ordered[:-1], out=last[:-1])
    return order[last]


def nearest_pairs(
    first: npt.NDArray[np.int64], second: npt.NDArray[np.int64], max_difference: int, offset: int = 0
) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Pair each of the shorter list with the nearest of the longer.

    The nearest as float64 sees it, as in evo (`tumtools.evaluate.seconds`); of two as near, the earlier.

    Args:
        first: Strictly ascending stamps, ns, shape [n].
        second: Strictly ascending stamps, ns, shape [m], the offset added.
        max_difference: Largest difference allowed, ns.
        offset: What was added to the second stamps, ns.

    """
    seconds = rounded_seconds(first), rounded_seconds(second - offset, offset)
    if len(first) > len(second):
        rows = closest(*seconds)
        near = np.abs(first[rows] - second) <= max_difference
        return rows[near], np.flatnonzero(near)
    rows = closest(*reversed(seconds))
    near = np.abs(second[rows] - first) <= max_difference
    return np.flatnonzero(near), rows[near]


Times = TypeVar("Times", "npt.NDArray[np.int64]", "npt.NDArray[np.float64]")


def closest(stamps: Times, wanted: Times) -> npt.NDArray[np.intp]:
    """Return the index of the nearest of ascending `stamps` for each of `wanted`; ties to the earlier."""
    if not len(stamps):
        return np.empty(0, np.intp)
    after = np.searchsorted(stamps, wanted).clip(1, max(len(stamps) - 1, 1))
    before = after - 1
    after = after.clip(0, len(stamps) - 1)
    return np.where(np.abs(stamps[after] - wanted) < np.abs(wanted - stamps[before]), after, before)


def associate(
    first: npt.NDArray[np.int64],
    second: npt.NDArray[np.int64],
    *,
    max_difference: int = MAX_DIFFERENCE,
    offset: int = 0,
    method: Method = "tum",
) -> Association:
    """Pair the rows of two streams by their stamps.

    Args:
        first: Stamps, ns, int64, shape [n], in any order.
        second: Stamps, ns, int64, shape [m], in any order.
        max_difference: Limit of the difference in time, ns; pairs of `nearest` may reach it, those of
            the other methods must stay below.
        offset: Added to the second stamps, ns.
        method: One of `METHODS`.

    Raises:
        UsageError: Unknown method, a limit that is not positive, or numbers beyond int64.

    """
    if method not in METHODS:
        msg = f"unknown method {method!r}; there are {', '.join(METHODS)}"
        raise UsageError(msg)
    if max_difference <= 0:
        msg = f"the largest difference must be positive, not {max_difference} ns"
        raise UsageError(msg)
    rows_first, rows_second = last_rows(first), last_rows(second)
    times_first, times_second = first[rows_first], _shifted(second[rows_second], offset)
    # Beyond this span of time no pair can be: keeps what follows clear of int64's ends.
    max_difference = min(max_difference, 2**61)
    if method == "optimal":
        one, two = optimal_pairs(times_first, times_second, max_difference)
    else:
        pairs_of = greedy_pairs if method == "tum" else nearest_pairs
        one, two = pairs_of(times_first, times_second, max_difference, offset)
    order = np.argsort(times_first[one], kind="stable")
    one, two = one[order], two[order]
    return Association(
        first=rows_first[one],
        second=rows_second[two],
        differences=times_first[one] - times_second[two],
        first_count=len(rows_first),
        second_count=len(rows_second),
    )


def _shifted(stamps: npt.NDArray[np.int64], offset: int) -> npt.NDArray[np.int64]:
    """Add the offset; refuses what int64 cannot hold."""
    limits = np.iinfo(np.int64)
    ends = [int(stamps[0]) + offset, int(stamps[-1]) + offset] if len(stamps) else [offset]
    if min(ends) < limits.min or max(ends) > limits.max:
        msg = f"an offset of {offset} ns takes the stamps out of range"
        raise UsageError(msg)
    return stamps + offset
