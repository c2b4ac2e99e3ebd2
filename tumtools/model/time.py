# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Stamps: integer nanoseconds since 1970-01-01 UTC.

Text, ROS time and MRPT ticks are converted exactly and never through a float, whose spacing at
today's epoch (238 ns) is coarser than the microseconds that the benchmark prints.
"""

from __future__ import annotations

import re
from typing import Final

import numpy as np
import numpy.typing as npt

NANOSECONDS_PER_SECOND: Final = 1_000_000_000
MAX_DECIMALS: Final = 9
"""More decimals than this are below a nanosecond."""

_MRPT_EPOCH_TICKS: Final = 116_444_736_000_000_000
"""100 ns ticks from 1601-01-01 to 1970-01-01."""
_NANOSECONDS_PER_TICK: Final = 100

_INT64_LIMIT: Final = 2**63
_MAX_EXPONENT: Final = 30
_OTHER_UNITS: Final = {
    13: ", rather milliseconds: divide by 1e3",
    16: ", rather microseconds: divide by 1e6",
    19: ", rather nanoseconds: divide by 1e9",
}
"""What a stamp of our days may be instead of seconds, by the digits before its point."""
_NUMBER = re.compile(r"([+-]?)(\d{0,40})(?:\.(\d{0,40}))?(?:[eE]([+-]?\d{1,3}))?", re.ASCII)


def parse_stamp(text: str) -> int:
    """Read seconds, as text, as nanoseconds.

    Exact for up to nine decimals, in plain and in scientific notation; further decimals are
    rounded half to even.

    Raises:
        ValueError: The text is no finite decimal number, or outside the range of int64 nanoseconds.

    """
    match = _NUMBER.fullmatch(text.strip())
    if match is None or not (match[2] or match[3]):
        msg = f"not a number of seconds: {text!r}"
        raise ValueError(msg)
    sign, whole, fraction, exponent = match[1], match[2], match[3] or "", int(match[4] or 0)
    digits = int(whole + fraction or "0")
    power = exponent - len(fraction) + MAX_DECIMALS
    if abs(exponent) > _MAX_EXPONENT:
        msg = f"exponent out of range: {text!r}"
        raise ValueError(msg)
    stamp = digits * 10**power if power >= 0 else _divide_half_even(digits, 10**-power)
    if stamp >= _INT64_LIMIT and sign == "-":
        msg = f"before the year 1678, not seconds since 1970: {text!r}"
        raise ValueError(msg)
    if stamp >= _INT64_LIMIT:
        unit = _OTHER_UNITS.get(len(whole.lstrip("0")) if not exponent else 0, "")
        msg = f"beyond the year 2262, not seconds since 1970{unit}: {text!r}"
        raise ValueError(msg)
    return -stamp if sign == "-" else stamp


def _divide_half_even(numerator: int, denominator: int) -> int:
    quotient, remainder = divmod(numerator, denominator)
    twice = 2 * remainder
    if twice > denominator or (twice == denominator and quotient % 2):
        quotient += 1
    return quotient


def parse_stamps(tokens: npt.NDArray[np.bytes_]) -> npt.NDArray[np.int64]:
    """Read many stamps at once; columns of plain decimals take no Python step per row.

    Args:
        tokens: ASCII texts, shape [n].

    Returns:
        Nanoseconds, shape [n].

    Raises:
        ValueError: As `parse_stamp`, for the first token that is wrong.

    """
    uniform = _parse_uniform(tokens)
    if uniform is not None:
        return uniform
    return np.array([parse_stamp(token.decode("ascii", "replace")) for token in tokens.tolist()], np.int64)


def _parse_uniform(tokens: npt.NDArray[np.bytes_]) -> npt.NDArray[np.int64] | None:
    """Parse when every token has the dot in the same column and digits elsewhere, else None."""
    width = tokens.dtype.itemsize
    if not len(tokens) or width > 20:  # noqa: PLR2004 - 10 + 1 + 9 characters
        return None
    characters = np.ascontiguousarray(tokens).view(np.uint8).reshape(len(tokens), width)
    dots = np.flatnonzero(characters[0] == ord("."))
    dot = int(dots[0]) if len(dots) == 1 else -1
    if dot < 1 or not (characters[:, dot] == ord(".")).all():
        return None
    digits = np.delete(characters, dot, axis=1) - np.uint8(ord("0"))
    decimals = width - 1 - dot
    if (digits > 9).any() or decimals > MAX_DECIMALS or dot > 10:  # noqa: PLR2004 - digits of int64 seconds
        return None
    if dot == 10 and int(characters[:, 0].max()) > ord("8"):  # noqa: PLR2004 - could pass int64
        return None
    powers = 10 ** np.arange(width - 2, -1, -1, dtype=np.int64) * 10 ** (MAX_DECIMALS - decimals)
    stamps: npt.NDArray[np.int64] = digits.astype(np.int64) @ powers
    return stamps


def decimals_needed(stamps: npt.NDArray[np.int64], at_least: int) -> int:
    """Return the fewest decimals, not below `at_least`, that print all stamps exactly."""
    for decimals in range(at_least, MAX_DECIMALS):
        if not (stamps % 10 ** (MAX_DECIMALS - decimals)).any():
            return decimals
    return MAX_DECIMALS


def format_stamp(stamp: int, decimals: int = 6) -> str:
    """Print nanoseconds as seconds.

    Raises:
        ValueError: The stamp needs more decimals.

    """
    unit = 10 ** (MAX_DECIMALS - decimals)
    seconds, rest = divmod(abs(stamp), NANOSECONDS_PER_SECOND)
    if rest % unit:
        msg = f"{stamp} ns needs more than {decimals} decimals"
        raise ValueError(msg)
    sign = "-" if stamp < 0 else ""
    return f"{sign}{seconds}.{rest // unit:0{decimals}d}" if decimals else f"{sign}{seconds}"


def split_stamp(stamp: int) -> tuple[int, int]:
    """Split into ROS seconds (rounded down, may be negative) and nanoseconds (0 .. 999 999 999)."""
    return divmod(stamp, NANOSECONDS_PER_SECOND)


def join_stamp(seconds: int, nanoseconds: int) -> int:
    """Join ROS seconds and nanoseconds."""
    return seconds * NANOSECONDS_PER_SECOND + nanoseconds


def stamp_to_ticks(stamp: int) -> int:
    """Convert to MRPT ticks of 100 ns since 1601, rounding down what is below a tick."""
    return stamp // _NANOSECONDS_PER_TICK + _MRPT_EPOCH_TICKS


def ticks_to_stamp(ticks: int) -> int:
    """Convert MRPT ticks of 100 ns since 1601 to nanoseconds since 1970."""
    return (ticks - _MRPT_EPOCH_TICKS) * _NANOSECONDS_PER_TICK
