# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Stamps are integer nanoseconds; text, ROS time and MRPT ticks are converted exactly."""

from __future__ import annotations

from decimal import ROUND_HALF_EVEN, Decimal
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tumtools.model.time import (
    decimals_needed,
    format_stamp,
    join_stamp,
    parse_stamp,
    parse_stamps,
    split_stamp,
    stamp_to_ticks,
    ticks_to_stamp,
)

if TYPE_CHECKING:
    from collections.abc import Callable

STAMPS = st.integers(-(2**63) + 1, 2**63 - 1)
SECONDS = st.decimals(-9_000_000_000, 9_000_000_000, allow_nan=False, places=12)


def _exactly(number: Decimal) -> int:
    """Return the nanoseconds of a number of seconds, by decimal arithmetic."""
    return int((number * 10**9).to_integral_value(rounding=ROUND_HALF_EVEN))


def test_the_example_of_the_benchmark_is_exact_where_a_float_is_not() -> None:
    assert parse_stamp("1305031102.175304") == 1305031102175304000
    assert int(float("1305031102.175304") * 1e9) != 1305031102175304000


@given(STAMPS)
def test_printing_with_nine_decimals_and_reading_gives_the_stamp(stamp: int) -> None:
    assert parse_stamp(format_stamp(stamp, 9)) == stamp


@given(STAMPS, st.integers(0, 9))
def test_a_stamp_is_printed_exactly_or_not_at_all(stamp: int, decimals: int) -> None:
    if stamp % 10 ** (9 - decimals):
        with pytest.raises(ValueError, match="needs more than"):
            format_stamp(stamp, decimals)
    else:
        assert parse_stamp(format_stamp(stamp, decimals)) == stamp


@given(SECONDS)
def test_any_number_of_decimals_is_rounded_half_to_even(number: Decimal) -> None:
    assert parse_stamp(f"{number:f}") == _exactly(number)


@given(SECONDS, st.integers(0, 11), st.sampled_from("eE"))
def test_scientific_notation_is_exact(number: Decimal, digits: int, letter: str) -> None:
    text = f"{number:.{digits}e}"
    assert parse_stamp(text.replace("e", letter)) == _exactly(Decimal(text))


@pytest.mark.parametrize(
    ("text", "stamp"),
    [
        ("0", 0),
        ("-0.0", 0),
        ("+1", 10**9),
        ("1.", 10**9),
        (".5", 5 * 10**8),
        (" 1.5 ", 15 * 10**8),
        ("0001.5", 15 * 10**8),
        ("-1.5", -15 * 10**8),
        ("0.0000000005", 0),
        ("0.0000000015", 2),
        ("0.00000000050001", 1),
        ("1.305031102175304e+09", 1305031102175304000),
        ("9223372036.854775807", 2**63 - 1),
    ],
)
def test_forms_of_a_stamp(text: str, stamp: int) -> None:
    assert parse_stamp(text) == stamp


@pytest.mark.parametrize(
    "text",
    [
        *[
            "",
            ".",
            "-",
            "e5",
            "nan",
            "inf",
            "1,5",
            "1_000",
            "0x10",
            "1.5.2",
            "1e",
            "1e31",
            "1e999",
            "१२",
            "1 2",
        ],
        *["9223372036.854775808", "1305031102175304000", "1" * 41],
    ],
)
def test_what_is_no_stamp_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"seconds|exponent"):
        parse_stamp(text)


@given(st.lists(STAMPS, min_size=1), st.integers(0, 9))
def test_columns_are_read_as_the_single_texts_are(stamps: list[int], decimals: int) -> None:
    unit = 10 ** (9 - decimals)
    texts = [format_stamp(stamp // unit * unit if stamp > 0 else 0, decimals).encode() for stamp in stamps]
    assert parse_stamps(np.array(texts)).tolist() == [parse_stamp(text.decode()) for text in texts]


@given(
    st.lists(
        st.from_regex(r"\A[+-]?[0-9]{1,11}(\.[0-9]{0,12})?(e[+-][0-9])?\Z"),
        min_size=1,
        max_size=5,
    )
)
def test_awkward_columns_are_read_as_the_single_texts_are(texts: list[str]) -> None:
    tokens = np.array([text.encode() for text in texts])
    assert _outcome(lambda: parse_stamps(tokens).tolist()) == _outcome(lambda: list(map(parse_stamp, texts)))


def _outcome(work: Callable[[], list[int]]) -> list[int] | str:
    try:
        return work()
    except ValueError as error:
        return str(error)


def test_no_stamps_are_read_as_none() -> None:
    assert parse_stamps(np.array([], "S1")).shape == (0,)


@given(st.lists(STAMPS), st.integers(0, 9))
def test_the_fewest_decimals_that_print_all_stamps(stamps: list[int], at_least: int) -> None:
    column = np.array(stamps, np.int64)
    decimals = decimals_needed(column, at_least)
    assert at_least <= decimals <= 9
    assert [parse_stamp(format_stamp(stamp, decimals)) for stamp in stamps] == stamps
    if decimals > at_least:
        assert (column % 10 ** (10 - decimals)).any()


@given(STAMPS)
def test_ros_time_rounds_seconds_down_and_joins_to_the_same(stamp: int) -> None:
    seconds, nanoseconds = split_stamp(stamp)
    assert 0 <= nanoseconds < 10**9
    assert join_stamp(seconds, nanoseconds) == stamp


@given(STAMPS)
def test_mrpt_ticks_keep_100_nanoseconds(stamp: int) -> None:
    assert 0 <= stamp - ticks_to_stamp(stamp_to_ticks(stamp)) < 100


def test_mrpt_ticks_count_from_1601() -> None:
    assert stamp_to_ticks(0) == 134774 * 86400 * 10**7
