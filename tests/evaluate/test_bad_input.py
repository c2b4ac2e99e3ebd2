# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What cannot be measured is refused with the reason; what is left out is said; no silent numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from tests.evaluate.conftest import drifted, walk
from tumtools.errors import InputError
from tumtools.evaluate.allpairs import evaluate_rpe_all_pairs
from tumtools.evaluate.ate import evaluate_ate
from tumtools.evaluate.rpe import evaluate_rpe
from tumtools.model.signals import Trajectory

if TYPE_CHECKING:
    from collections.abc import Callable

MEASURES = {
    "ate": evaluate_ate,
    "ate interpolated": lambda *pair: evaluate_ate(*pair, max_hole=100_000_000),
    "rpe": lambda *pair: evaluate_rpe(*pair, delta=1, unit="f"),
    "rpe interpolated": lambda *pair: evaluate_rpe(*pair, delta=1, unit="f", max_hole=100_000_000),
    "all pairs": evaluate_rpe_all_pairs,
}
every_measure = pytest.mark.parametrize("measure", MEASURES.values(), ids=MEASURES)


def changed(trajectory: Trajectory, row: int, column: int, value: float) -> Trajectory:
    values = trajectory.values
    values[row, column] = value
    return Trajectory(trajectory.stamps, values[:, :3], values[:, 3:])


@every_measure
def test_no_overlap_in_time(measure: Callable[..., object]) -> None:
    other = Trajectory(walk(50).stamps + 10**12, walk(50).positions, walk(50).quaternions)
    with pytest.raises(InputError) as error:
        measure(walk(50), other)
    assert "no pose of the estimate" in str(error.value)
    assert "50 stamps from 1305031102 to 1305031102.49" in str(error.value)
    assert "999.510 s apart" in str(error.value)


@every_measure
@pytest.mark.parametrize("side", [0, 1])
def test_one_pose(measure: Callable[..., object], side: int) -> None:
    pair = [walk(50), walk(50)]
    pair[side] = pair[side].take(slice(10, 11))
    with pytest.raises(InputError, match=r"only one pose|no pose"):
        measure(*pair)


@every_measure
@pytest.mark.parametrize("side", [0, 1])
def test_no_pose_at_all(measure: Callable[..., object], side: int) -> None:
    pair = [walk(50), walk(50)]
    pair[side] = Trajectory.empty()
    with pytest.raises(InputError, match=f"the {('ground truth', 'estimate')[side]} has no pose"):
        measure(*pair)


@every_measure
def test_identical_stamps_are_one_pose(measure: Callable[..., object]) -> None:
    trajectory = walk(50)
    frozen = Trajectory(np.full(50, trajectory.stamps[20]), trajectory.positions, trajectory.quaternions)
    with pytest.raises(InputError, match=r"the estimate one stamp, 1305031102\.2") as error:
        measure(trajectory, frozen)
    assert "two poses with different stamps" in str(error.value)


@every_measure
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_rows_that_are_not_finite_are_left_out_and_counted(
    measure: Callable[..., object], value: float
) -> None:
    good = measure(walk(50), drifted(walk(50)).take(np.arange(1, 50)))
    result = measure(walk(50), changed(drifted(walk(50)), 0, 1, value))
    assert "estimate: 1 of 50 rows with NaN or infinity left out" in result.notes
    assert result.pairs == good.pairs


@every_measure
def test_a_trajectory_of_nan(measure: Callable[..., object]) -> None:
    trajectory = walk(50)
    with pytest.raises(InputError, match="50 of 50 rows with NaN"):
        measure(
            trajectory, Trajectory(trajectory.stamps, trajectory.positions * np.nan, trajectory.quaternions)
        )


def test_a_zero_quaternion_matters_only_where_rotations_do() -> None:
    trajectory = drifted(walk(50))
    trajectory.quaternions[7] = 0.0
    note = "estimate: 1 of 50 rows with a zero quaternion left out"
    assert note in evaluate_rpe(walk(50), trajectory, delta=1, unit="f").notes
    assert note in evaluate_rpe_all_pairs(walk(50), trajectory).notes
    result = evaluate_ate(walk(50), trajectory)
    assert (result.pairs, result.notes) == (50, ())
    assert result.aligned.quaternions[7].tolist() == [0.0, 0.0, 0.0, 0.0]
    assert np.isfinite(result.aligned.values).all()


def test_of_equal_stamps_the_last_row_counts() -> None:
    trajectory = walk(50)
    doubled = Trajectory(
        np.r_[trajectory.stamps[:1], trajectory.stamps],
        np.vstack([[[9e9, 9e9, 9e9]], trajectory.positions]),
        np.vstack([trajectory.quaternions[:1], trajectory.quaternions]),
    )
    result = evaluate_ate(trajectory, doubled)
    assert result.statistics.max < 1e-12
    assert result.notes == ("estimate: 1 of 51 rows whose stamp comes again left out",)


def test_rows_may_stand_in_any_order() -> None:
    groundtruth, estimate = walk(50), drifted(walk(50))
    shuffled = estimate.take(np.random.default_rng(0).permutation(50))
    assert evaluate_ate(groundtruth, shuffled).statistics == evaluate_ate(groundtruth, estimate).statistics


def test_few_partners_are_said_loudly() -> None:
    groundtruth = walk(100)
    assert evaluate_ate(groundtruth.take(slice(0, 90)), groundtruth).notes == ()
    other = Trajectory(
        groundtruth.stamps + np.where(np.arange(100) < 20, 10**12, 0),
        groundtruth.positions,
        groundtruth.quaternions,
    )
    (note,) = evaluate_ate(groundtruth, other).notes
    assert "only 80 of 100 poses (80.0 %) have a partner" in note


def test_a_straight_line_has_its_least_error_and_a_note() -> None:
    line = walk(50)
    line = Trajectory(line.stamps, np.outer(np.arange(50.0), [0.01, 0.02, 0.0]), line.quaternions)
    result = evaluate_ate(line, line)
    assert result.statistics.max < 1e-12
    assert any("rotation about a line" in note for note in result.notes)


def test_a_still_camera_has_a_note() -> None:
    still = Trajectory(walk(50).stamps, np.ones((50, 3)), walk(50).quaternions)
    result = evaluate_ate(still, still)
    assert result.statistics.max < 1e-12
    assert any("leave the rotation of" in note for note in result.notes)
