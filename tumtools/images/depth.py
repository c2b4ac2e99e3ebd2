# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Depth between integer counts and metres.

Counts use 0 for "no reading"; metres (`32FC1`) use NaN. Counts become float32 by one division in float64
and come back by rounding, which is exact for all 65 536 values at 5000 units per metre. Truncation would be
wrong for about half of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

_COUNTS = 65_536
_QUIET_NAN = np.uint32(0x7FC00000)
_TO_LOWEST_BITS = np.float32(2**23)
_BLOCK = 65_536
"""Pixels that are worked on at a time: they fit into the second cache."""
_LARGE_BLOCK = 2**19
"""The same, where each block has a fixed cost, such as to get the GIL back; more than a VGA image."""


@lru_cache(maxsize=8)
def _metre_table(units_per_metre: float) -> npt.NDArray[np.float32]:
    table = (np.arange(_COUNTS) / units_per_metre).astype(np.float32)
    table.flags.writeable = False
    return table


def divided(counts: npt.NDArray[np.uint16], units_per_metre: float) -> npt.NDArray[np.float32]:
    """Return counts / units as if divided in float64 and rounded to float32. Any shape."""
    units = np.float32(units_per_metre)
    if float(units) != units_per_metre:
        return _metre_table(units_per_metre)[counts]
    # Both operands are exact in float32, and float64 has more than twice its digits and two, so rounding
    # twice gives what rounding once does (Figueroa 1995); this is many times faster than a table.
    return np.divide(counts, units, dtype=np.float32)


def to_metres(counts: npt.NDArray[np.uint16], units_per_metre: float) -> npt.NDArray[np.float32]:
    """Return metres as float32, NaN where the count is 0. Any shape."""
    metres = divided(counts, units_per_metre)
    bits = metres.view(np.uint32)
    bits |= (counts == 0).view(np.uint8) * _QUIET_NAN  # 0.0 has no bits set; faster than a masked copy
    return metres


@lru_cache(maxsize=8)
def is_reversible(units_per_metre: float) -> bool:
    """Tell whether each of the 65 536 counts comes back from the metres that `to_metres` makes of it."""
    counts = np.arange(_COUNTS, dtype=np.uint16)
    with np.errstate(over="ignore"):
        back = exact_counts(to_metres(counts, units_per_metre), units_per_metre)
    return back is not None and np.array_equal(back, counts)


@dataclass(frozen=True, slots=True)
class Rounding:
    """What rounding to counts changed.

    Attributes:
        inexact: Pixels that were no multiple of the unit.
        clipped: Pixels outside the range of the counts (negative, or too far); they became 0, no reading.
        largest_error: Largest change of a pixel that was rounded, in metres.

    """

    inexact: int = 0
    clipped: int = 0
    largest_error: float = 0.0

    def __add__(self, other: Rounding) -> Rounding:
        return Rounding(
            self.inexact + other.inexact,
            self.clipped + other.clipped,
            max(self.largest_error, other.largest_error),
        )


EXACT = Rounding()


def to_counts(
    metres: npt.NDArray[np.float32], units_per_metre: float
) -> tuple[npt.NDArray[np.uint16], Rounding]:
    """Round metres to counts; not finite and zero become 0.

    Returns:
        The counts, and what the rounding changed: values that are not exactly the float32 of a count.

    """
    counts = exact_counts(metres, units_per_metre)
    if counts is not None:
        return counts, EXACT
    flat, rounding = np.ascontiguousarray(metres).reshape(-1), EXACT
    counts = np.empty(flat.shape, np.uint16)
    for start in range(0, flat.size, _BLOCK):  # what is in float64 takes four times the memory
        block = slice(start, start + _BLOCK)
        counts[block], one = _round(flat[block], units_per_metre)
        rounding += one
    return counts.reshape(metres.shape), rounding


def _round(
    metres: npt.NDArray[np.float32], units_per_metre: float
) -> tuple[npt.NDArray[np.uint16], Rounding]:
    with np.errstate(invalid="ignore"):
        scaled = np.rint(metres.astype(np.float64) * units_per_metre)
        valid = np.isfinite(metres) & (metres != 0)
        inside = valid & (scaled >= 0) & (scaled < _COUNTS)
        counts = np.where(inside, scaled, 0).astype(np.uint16)
    back = to_metres(counts, units_per_metre)
    changed = inside & (back != metres)
    # A reading that rounds to 0 has become "no reading"; its error is its own size.
    back = np.where(counts == 0, np.float32(0), back)
    inexact = int(np.count_nonzero(changed))
    error = float(np.max(np.abs(back[changed].astype(np.float64) - metres[changed]))) if inexact else 0.0
    clipped = int(np.count_nonzero(valid & ~inside)) + int(np.count_nonzero(np.isinf(metres)))
    return counts, Rounding(inexact, clipped, error)


def count_levels(counts: npt.NDArray[np.uint16]) -> npt.NDArray[np.int64]:
    """Return how often each count occurs, shape [65536]; in blocks, as numpy makes int64 of all of them."""
    flat = counts.reshape(-1)
    found = np.zeros(_COUNTS, np.int64)
    for start in range(0, flat.size, _LARGE_BLOCK):
        found += np.bincount(flat[start : start + _LARGE_BLOCK], minlength=_COUNTS)
    return found


def nearest_counts(metres: npt.NDArray[np.float32], units_per_metre: float) -> npt.NDArray[np.uint16]:
    """Return the nearest count of each value that is that of a count, 0 for our NaN, and anything for others.

    The product in float32 is off by less than 0.01. The sum with 2^23 rounds to the nearest whole number and
    leaves it in the lowest bits (IEEE 754), whatever the processor. Any shape, C-contiguous.
    """
    with np.errstate(invalid="ignore", over="ignore"):
        rounded = np.multiply(metres, np.float32(units_per_metre))
        rounded += _TO_LOWEST_BITS
    return rounded.view(np.uint32).astype(np.uint16)  # the lower half of the bits


def exact_counts(
    metres: npt.NDArray[np.float32], units_per_metre: float, *, nan: bool = True
) -> npt.NDArray[np.uint16] | None:
    """Return the counts if each value is exactly that of a count, or NaN if that may stand for 0; else None.

    Whether the nearest count is the right one is told by going back. Done in blocks, to take little memory.
    """
    flat = np.ascontiguousarray(metres).reshape(-1)
    counts = np.empty(flat.shape, np.uint16)
    for start in range(0, flat.size, _LARGE_BLOCK):
        values, found = flat[start : start + _LARGE_BLOCK], counts[start : start + _LARGE_BLOCK]
        found[:] = nearest_counts(values, units_per_metre)
        exact = divided(found, units_per_metre) == values
        if not exact.all():
            if not nan:
                return None
            missing = np.isnan(values)
            found *= ~missing  # a NaN may have any lowest bits; thirty times as fast as with a mask
            exact |= missing
            if not exact.all():
                return None
    return counts.reshape(metres.shape)


def rescale_counts(
    counts: npt.NDArray[np.uint16], units_per_metre: float, wanted_units_per_metre: float
) -> tuple[npt.NDArray[np.uint16], Rounding]:
    """Rescale counts from one unit to another, rounding half to even; `largest_error` is in metres."""
    levels = np.arange(_COUNTS)
    scaled = np.rint(levels * (wanted_units_per_metre / units_per_metre))
    clipped_levels = scaled >= _COUNTS
    table = np.where(clipped_levels, 0, scaled)
    errors = np.where(clipped_levels, 0, np.abs(table / wanted_units_per_metre - levels / units_per_metre))
    errors[errors < 1e-12] = 0.0  # noqa: PLR2004 - float noise of exact multiples, far below any unit
    used = count_levels(counts)
    lost = (table == 0) & (levels > 0) & ~clipped_levels  # "no reading" now, however near it was
    inexact = ((errors > 0) | lost) & (used > 0)
    rounding = Rounding(
        int(used[inexact].sum()),
        int(used[clipped_levels].sum()),
        float(errors[inexact].max()) if inexact.any() else 0.0,
    )
    return table.astype(np.uint16)[counts], rounding
