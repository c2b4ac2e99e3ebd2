# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Depth between counts and metres is exact, or the rounding is told."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from tumtools.images.depth import (
    EXACT,
    Rounding,
    divided,
    is_reversible,
    rescale_counts,
    to_counts,
    to_metres,
)

ALL = np.arange(65_536, dtype=np.uint16).reshape(256, 256)


@pytest.mark.parametrize("units", [5000.0, 1000.0, 1.0, 65_535.0, 4999.5])
def test_all_counts_survive_the_way_through_metres(units: float) -> None:
    metres = to_metres(ALL, units)
    assert metres.dtype == np.float32
    counts, rounding = to_counts(metres, units)
    assert np.array_equal(counts, ALL)
    assert rounding == EXACT


def test_no_reading_is_nan_in_metres() -> None:
    assert np.isnan(to_metres(ALL, 5000.0)).sum() == 1
    assert np.isnan(to_metres(ALL, 5000.0)[0, 0])


def test_a_metre_has_5000_counts() -> None:
    assert to_metres(np.array([5000, 1], np.uint16), 5000.0).tolist() == [1.0, np.float32(0.0002)]


def test_what_is_out_of_range_becomes_no_reading_and_is_counted() -> None:
    metres = np.array([-1, np.inf, -np.inf, 13.1072, 1e30, np.nan, 0, -0.0, 1], np.float32)
    counts, rounding = to_counts(metres, 5000.0)
    assert counts.tolist() == [0, 0, 0, 0, 0, 0, 0, 0, 5000]
    assert (rounding.clipped, rounding.inexact) == (5, 0)


def test_a_reading_below_half_a_unit_is_an_error_of_its_own_size() -> None:
    counts, rounding = to_counts(np.array([0.00005], np.float32), 5000.0)
    assert counts.tolist() == [0]
    assert rounding.inexact == 1
    assert rounding.largest_error == pytest.approx(0.00005)


@given(hnp.arrays(np.float32, st.integers(0, 20), elements=st.floats(0, 14, width=32)))
def test_rounding_is_to_the_nearest_count_and_its_error_is_told(metres: np.ndarray) -> None:
    counts, rounding = to_counts(metres, 5000.0)
    exact = metres.astype(np.float64) * 5000
    inside = np.rint(exact) < 65_536
    assert (np.abs(counts - exact)[inside] <= 0.5).all()
    assert rounding.clipped == np.count_nonzero(~inside)
    assert rounding.largest_error <= 0.5 / 5000 + 1e-6
    assert (rounding.inexact == 0) == (rounding.largest_error == 0)


COUNTED = st.builds(lambda count: np.float32(count / 5000), st.integers(0, 65_535))
ODD = st.sampled_from([np.nan, -np.nan, np.inf, -np.inf, -0.0, -0.0002, 13.1072, 1e-45, 3.4e38, -3.4e38])


@given(hnp.arrays(np.float32, st.tuples(st.integers(1, 3), st.integers(1, 20)), elements=COUNTED | ODD))
def test_readings_that_are_counts_come_back_whatever_is_beside_them(metres: np.ndarray) -> None:
    counts, rounding = to_counts(metres, 5000.0)
    with np.errstate(invalid="ignore"):
        expected = np.rint(metres.astype(np.float64) * 5000)
        inside = (expected >= 0) & (expected < 65_536)
    assert np.array_equal(counts, np.where(inside, expected, 0))
    assert rounding.clipped == np.count_nonzero(~inside & ~np.isnan(metres))
    assert rounding.inexact == np.count_nonzero(metres == np.float32(1e-45))
    assert np.array_equal(to_counts(metres[:, ::-1], 5000.0)[0], counts[:, ::-1])


def test_multiples_are_rescaled_without_loss() -> None:
    millimetres = np.arange(0, 13_108, dtype=np.uint16)
    counts, rounding = rescale_counts(millimetres, 1000.0, 5000.0)
    assert np.array_equal(counts, (5 * millimetres.astype(int)).astype(np.uint16))
    assert rounding == EXACT


def test_rounding_to_millimetres_is_counted_with_its_largest_error() -> None:
    counts, rounding = rescale_counts(np.array([[5, 6, 7, 65_535, 0]], np.uint16), 5000.0, 1000.0)
    assert counts.tolist() == [[1, 1, 1, 13_107, 0]]
    assert rounding.inexact == 2
    assert rounding.largest_error == pytest.approx(0.0004)


def test_counts_that_overflow_are_clipped() -> None:
    counts, rounding = rescale_counts(np.array([13_107, 13_108], np.uint16), 1000.0, 5000.0)
    assert counts.tolist() == [65_535, 0]
    assert rounding == Rounding(inexact=0, clipped=1, largest_error=0.0)


def test_roundings_add_up() -> None:
    assert Rounding(1, 2, 0.5) + Rounding(3, 4, 0.25) == Rounding(4, 6, 0.5)


@pytest.mark.parametrize("units", [5000.0, 1000.0, 1.0, 100.0, 4096.0, 999.0, 0.5, 6553.5, 0.1, 1 / 3])
def test_scaling_is_one_division_in_float64_for_every_count(units: float) -> None:
    """Division in float32 is used where it is the same."""
    counts = np.arange(65_536, dtype=np.uint16)
    wanted = (counts.astype(np.float64) / units).astype(np.float32)
    assert np.array_equal(divided(counts, units), wanted)
    assert np.array_equal(to_metres(counts, units)[1:], wanted[1:])
    assert np.isnan(to_metres(counts, units)[0])


def test_a_reading_that_becomes_none_is_a_change_however_small_it_was() -> None:
    counts, rounding = rescale_counts(np.array([[0, 1, 65535]], np.uint16), 1e38, 1000.0)
    assert counts.tolist() == [[0, 0, 0]]
    assert rounding.inexact == 2


@pytest.mark.parametrize(("units", "expected"), [(5000.0, True), (1000.0, True), (1.5, True), (1e42, False)])
def test_metres_are_reversible_if_every_count_comes_back(units: float, expected: bool) -> None:
    assert is_reversible(units) is expected
