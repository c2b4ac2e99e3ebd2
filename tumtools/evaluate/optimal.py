# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The most pairs, and among those the least sum of differences.

On a line, two pairs that cross can be swapped into two that do not, and neither their sum nor their
larger difference grows. So only pairings in order need be looked at, which a dynamic programme over
the rows does; row i looks only at the partners within the limit (its band).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.errors import UsageError

if TYPE_CHECKING:
    import numpy.typing as npt

_MAX_CANDIDATES: Final = 50_000_000
"""Two bytes each are kept."""


def optimal_pairs(
    first: npt.NDArray[np.int64], second: npt.NDArray[np.int64], max_difference: int
) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Pair one to one: most pairs, then least sum of differences.

    Takes O(n * k) time and n * k bytes of memory for k candidates a row.

    Args:
        first: Strictly ascending stamps, ns, shape [n].
        second: Strictly ascending stamps, ns, shape [m].
        max_difference: Differences must be below this, ns.

    Returns:
        Indices into `first` and `second`, shape [k] each, ascending.

    Raises:
        UsageError: The limit is so wide that the costs do not fit into int64, or the memory.

    """
    if len(first) > len(second):
        rows_second, rows_first = optimal_pairs(second, first, max_difference)
        return rows_first, rows_second
    # One pair more must outweigh all differences together.
    bonus = len(first) * max_difference + 1
    if bonus * (len(first) + 1) >= np.iinfo(np.int64).max:
        msg = f"a largest difference of {max_difference / 1e9:g} s is too wide for the method 'optimal'"
        raise UsageError(msg, hint="give a smaller one, or use the method 'tum'")
    low = np.searchsorted(second, first - max_difference, side="right")
    high = np.searchsorted(second, first + max_difference, side="left")
    candidates = int(np.sum(high - low))
    if candidates > _MAX_CANDIDATES:
        msg = f"{candidates} pairs differ by less than {max_difference / 1e9:g} s, too many for 'optimal'"
        raise UsageError(msg, hint="give a smaller difference, or use the method 'tum'")
    # best[j]: best score of the rows so far with partners among second[:j]; does not fall with j.
    best = np.zeros(len(second) + 1, np.int64)
    reach = 0
    used: list[npt.NDArray[np.bool_]] = []
    fresh: list[npt.NDArray[np.bool_]] = []
    for stamp, start, stop in zip(first.tolist(), low.tolist(), high.tolist(), strict=True):
        best[reach + 1 : stop + 1] = best[reach]
        reach = max(reach, stop)
        paired = best[start:stop] + (bonus - np.abs(second[start:stop] - stamp))
        running = np.maximum.accumulate(paired)
        without = best[start + 1 : stop + 1]
        used.append(running > without)
        fresh.append(np.diff(running, prepend=-1) > 0)
        best[start + 1 : stop + 1] = np.maximum(running, without)
    return _trace_back(low, high, used, fresh)


def _trace_back(
    low: npt.NDArray[np.intp],
    high: npt.NDArray[np.intp],
    used: list[npt.NDArray[np.bool_]],
    fresh: list[npt.NDArray[np.bool_]],
) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Read the pairs off the choices: where a row's best pair was used, its partner is the last fresh one."""
    pairs: list[tuple[int, int]] = []
    open_end = int(high[-1]) if len(high) else 0
    for row in range(len(low) - 1, -1, -1):
        start = int(low[row])
        column = min(open_end, int(high[row])) - start - 1
        if column >= 0 and used[row][column]:
            open_end = start + int(np.flatnonzero(fresh[row][: column + 1])[-1])
            pairs.append((row, open_end))
    one, two = np.array(pairs[::-1], np.intp).reshape(-1, 2).T
    return one, two
