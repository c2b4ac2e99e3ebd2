# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
from __future__ import annotations

import numpy as np
import pytest

from tests.evaluate.conftest import drifted, walk
from tumtools.evaluate.ate import evaluate_ate
from tumtools.evaluate.interpolate import interpolate
from tumtools.evaluate.rpe import evaluate_rpe
from tumtools.model.signals import Trajectory


def turning(angles: list[float], stamps: list[int]) -> Trajectory:
    half = np.array(angles) / 2.0
    zero = np.zeros_like(half)
    positions = np.stack([np.array(stamps, float), zero, zero], axis=1)
    return Trajectory(np.array(stamps), positions, np.stack([zero, zero, np.sin(half), np.cos(half)], axis=1))


def angle(trajectory: Trajectory) -> list[float]:
    return (2.0 * np.arctan2(trajectory.quaternions[:, 2], trajectory.quaternions[:, 3])).round(9).tolist()


def test_positions_go_straight_and_rotations_at_even_speed() -> None:
    poses, known = interpolate(turning([0.0, 1.2], [0, 100]), np.array([0, 25, 50, 100]))
    assert known.all()
    assert poses.positions[:, 0].tolist() == [0.0, 25.0, 50.0, 100.0]
    assert angle(poses) == [0.0, 0.3, 0.6, 1.2]


def test_the_shorter_way_round_is_taken() -> None:
    trajectory = turning([0.2, 0.6], [0, 10])
    flipped = Trajectory(
        trajectory.stamps, trajectory.positions, trajectory.quaternions * np.array([[1.0], [-1.0]])
    )
    assert angle(interpolate(flipped, np.array([5]))[0]) == [0.4]


def test_nothing_outside_and_nothing_across_a_hole() -> None:
    trajectory = turning([0.0, 0.1, 0.2], [0, 10, 1000])
    wanted = np.array([-1, 0, 5, 10, 11, 999, 1000, 1001])
    _, known = interpolate(trajectory, wanted, max_hole=10)
    assert known.tolist() == [False, True, True, True, False, False, True, False]
    _, known = interpolate(trajectory, wanted, max_hole=990)
    assert known.tolist() == [False, True, True, True, True, True, True, False]


def test_one_pose_is_known_at_its_own_stamp_only() -> None:
    poses, known = interpolate(turning([0.1], [7]), np.array([6, 7, 8]))
    assert known.tolist() == [False, True, False]
    assert angle(poses) == [0.1]


def test_equal_rotations_stay() -> None:
    assert angle(interpolate(turning([0.5, 0.5], [0, 10]), np.array([3]))[0]) == [0.5]


def test_errors_against_interpolated_ground_truth() -> None:
    """Every tenth true pose is left, on a path so smooth that the others can be interpolated."""
    time = np.linspace(0.0, 10.0, 1001)
    circle = np.stack([np.cos(time), np.sin(time), 0.0 * time], axis=1)
    half = time / 2.0
    turns = np.stack([0.0 * half, 0.0 * half, np.sin(half), np.cos(half)], axis=1)
    dense = Trajectory(np.arange(1001) * 10_000_000, circle, turns)
    sparse = dense.take(slice(None, None, 10))
    near = evaluate_ate(sparse, dense, max_difference=60_000_000, method="nearest")
    between = evaluate_ate(sparse, dense, max_hole=100_000_000)
    assert between.pairs == 1001
    assert between.statistics.rmse < 0.002
    assert near.statistics.max < 1e-9  # only the sparse poses themselves take part
    assert evaluate_rpe(sparse, dense, max_hole=100_000_000).translation.max < 0.005
    assert evaluate_rpe(sparse, dense, max_hole=100_000_000).rotation.max < 1e-6


@pytest.mark.parametrize("step", [2, 3])
def test_relative_error_with_interpolation_counts_the_poses_in_holes_as_unmatched(step: int) -> None:
    whole = walk(300)
    holed = whole.take(np.r_[0:100, 200:300])
    result = evaluate_rpe(
        holed, drifted(whole).take(slice(None, None, step)), delta=3, unit="f", max_hole=50_000_000
    )
    assert result.estimate_matched == len(range(0, 100, step)) + len(
        [k for k in range(0, 300, step) if k >= 200]
    )
    assert any("have a partner" in note for note in result.notes)
