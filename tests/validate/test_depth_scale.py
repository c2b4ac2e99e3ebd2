# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The depth factor is found whatever it is, and not claimed where there is no grid."""

from __future__ import annotations

import numpy as np
import pytest

from tumtools.validate.depth_scale import DISPARITY_STEP, DepthScale, measure_depth_scale

RANDOM = np.random.default_rng(0)


def _values(units_per_metre: float, share: float = 1.0) -> np.ndarray[tuple[int], np.dtype[np.uint16]]:
    """Return the counts of depths on the sensor's grid, 0.8 to 5 m, a share of them chosen at random."""
    metres = 1 / (DISPARITY_STEP * np.arange(70, 436))
    chosen = metres[RANDOM.uniform(size=len(metres)) < share]
    return np.unique(np.floor(units_per_metre * chosen)).astype(np.uint16)


def _measure(values: np.ndarray[tuple[int], np.dtype[np.uint16]]) -> DepthScale:
    scale = measure_depth_scale(values)
    assert scale is not None
    return scale


@pytest.mark.parametrize("factor", [500.0, 1000.0, 2500.0, 4000.0, 5000.0, 5175.0, 6553.5, 10_000.0])
def test_the_factor_is_found(factor: float) -> None:
    scale = _measure(_values(factor))
    assert scale.is_quantised
    assert scale.units_per_metre == pytest.approx(factor, rel=0.03)


def test_values_that_do_not_occur_change_little() -> None:
    assert _measure(_values(5000, share=0.8)).units_per_metre == pytest.approx(5000, rel=0.05)


@pytest.mark.parametrize(
    "values",
    [
        np.arange(4000, 25_000),
        np.unique(RANDOM.integers(4000, 25_000, 3000)),
        np.unique((5000 * np.linspace(0.8, 5, 400)).astype(int)),
        np.arange(256, 65_536, 256),
    ],
    ids=["every count", "random counts", "even steps of depth", "high bytes"],
)
def test_where_there_is_no_grid_nothing_is_claimed(
    values: np.ndarray[tuple[int], np.dtype[np.int64]],
) -> None:
    assert not _measure(values.astype(np.uint16)).is_quantised


def test_zeros_do_not_count_and_few_values_say_nothing() -> None:
    values = _values(5000)
    with_zero = np.concatenate([[0], values]).astype(np.uint16)
    assert _measure(with_zero) == _measure(values)
    assert measure_depth_scale(values[:30]) is None
    assert measure_depth_scale(np.empty(0, np.uint16)) is None
