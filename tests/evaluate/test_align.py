# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
from __future__ import annotations

import numpy as np
import pytest

from tests.evaluate.brute import matrices
from tests.evaluate.conftest import walk
from tumtools.errors import InputError, UsageError
from tumtools.evaluate.align import align
from tumtools.evaluate.geometry import angles, conjugate, from_matrix, multiply

TURN = matrices(np.array([[0.3, -0.5, 0.2, 0.7]]))[0]


@pytest.mark.parametrize(("mode", "scale"), [("se3", 1.0), ("sim3", 2.5)])
def test_a_known_motion_is_found_again(mode: str, scale: float) -> None:
    truth = walk(50).positions
    estimate = (truth - np.array([3.0, -2.0, 1.0])) @ TURN / scale
    found = align(estimate, truth, mode)
    np.testing.assert_allclose(found.rotation, TURN, atol=1e-12)
    np.testing.assert_allclose(found.translation, [3.0, -2.0, 1.0], atol=1e-12)
    assert found.scale == pytest.approx(scale)
    np.testing.assert_allclose(found.positions(estimate), truth, atol=1e-12)
    assert found.freedom == ""


def test_no_alignment_changes_nothing() -> None:
    positions = walk(5).positions
    np.testing.assert_array_equal(align(positions + 1.0, positions, "none").positions(positions), positions)


def test_a_mirrored_estimate_is_turned_and_not_mirrored_back() -> None:
    truth = walk(50).positions
    rotation = align(truth * np.array([-1.0, 1.0, 1.0]), truth).rotation
    assert np.linalg.det(rotation) == pytest.approx(1.0)


def test_poses_are_turned_with_the_positions() -> None:
    truth = walk(50)
    found = align(truth.positions @ TURN, truth.positions)
    before, after = truth, found.trajectory(truth)
    turns = multiply(after.quaternions, conjugate(before.quaternions))
    np.testing.assert_allclose(
        angles(multiply(np.tile(conjugate(from_matrix(TURN)), (50, 1)), turns)), 0.0, atol=1e-7
    )


@pytest.mark.parametrize(
    ("positions", "freedom"),
    [
        (np.outer(np.arange(10.0), [1.0, 2.0, 3.0]), "rotation about a line"),
        (np.outer(np.arange(2.0), [1.0, 2.0, 3.0]), "rotation about a line"),
        (np.tile([1.0, 2.0, 3.0], (10, 1)), "rotation"),
        (np.outer(np.arange(10.0), [1.0, 0.0, 0.0]) + np.outer(np.arange(10.0) ** 2, [0.0, 1.0, 0.0]), ""),
    ],
)
def test_what_stays_open_is_named(positions: np.ndarray, freedom: str) -> None:
    found = align(positions @ TURN + 5.0, positions)
    assert found.freedom == freedom
    assert np.linalg.det(found.rotation) == pytest.approx(1.0)
    np.testing.assert_allclose(found.positions(positions @ TURN + 5.0), positions, atol=1e-12)


def test_no_scale_can_be_told_from_a_still_estimate() -> None:
    with pytest.raises(InputError, match="do not move"):
        align(np.tile([0.1, 0.2, 0.3], (10, 1)), walk(10).positions, "sim3")


def test_an_unknown_mode_is_refused() -> None:
    with pytest.raises(UsageError, match="se3, sim3, none"):
        align(walk(5).positions, walk(5).positions, "affine")  # type: ignore[arg-type] # that is the point


@pytest.mark.parametrize(
    "quaternion", np.vstack([np.eye(4), -np.eye(4), [[0.5, 0.5, 0.5, 0.5], [0.1, 0.7, -0.1, 0.7]]])
)
def test_a_matrix_becomes_the_quaternion_that_it_came_from(quaternion: np.ndarray) -> None:
    quaternion = quaternion / np.linalg.norm(quaternion)
    found = from_matrix(matrices(quaternion[None])[0])
    assert abs(found @ quaternion) == pytest.approx(1.0)
