# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The gravity fit finds what was put in, and says nothing where the motion decides nothing."""

from __future__ import annotations

import numpy as np
import pytest

from tumtools.model.signals import Accelerometer, Trajectory
from tumtools.synthetic.motion import Motion, rotate_back, rotation_matrices
from tumtools.validate.gravity import READINGS, estimate_offset, fit_gravity, fit_readings

START = 1_305_031_102_000_000_000


def _record(
    seconds: float = 4.0, *, still: bool = False, late: float = 0.0, noise: float = 0.0
) -> tuple[Trajectory, Accelerometer]:
    """Return poses at 100 Hz and the pull of gravity at 500 Hz, in axes turned against the camera's."""
    motion = Motion.from_seed(3)

    def quaternions(
        times: np.ndarray[tuple[int], np.dtype[np.float64]],
    ) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
        return motion.quaternions(0 * times if still else times)

    poses, samples = np.arange(0, seconds, 0.01), np.arange(0, seconds, 0.002)
    up = rotate_back(rotation_matrices(quaternions(samples)), np.array([0, 0, 9.81]))
    mounting = rotation_matrices(np.array([[0.5, -0.5, 0.5, 0.5]]))
    values = rotate_back(mounting, up) + np.random.default_rng(0).normal(0, noise, up.shape)
    stamps = START + np.rint((samples + late) * 1e9).astype(np.int64)
    trajectory = Trajectory(
        START + np.rint(poses * 1e9).astype(np.int64), np.zeros((len(poses), 3)), quaternions(poses)
    )
    return trajectory, Accelerometer(stamps, values)


def test_without_noise_the_right_reading_fits_exactly() -> None:
    fit = fit_gravity(*_record())
    assert fit is not None
    assert fit.rms_degrees < 0.5  # what averaging over 0.1 s of turning leaves
    np.testing.assert_allclose(fit.up, [0, 0, 1], atol=0.01)


def test_each_written_order_is_found_again_by_its_reading() -> None:
    trajectory, accelerometer = _record()
    for reading, (order, inverse) in READINGS.items():
        written = np.empty_like(trajectory.quaternions)
        written[:, order] = trajectory.quaternions * ([-1, -1, -1, 1] if inverse else [1, 1, 1, 1])
        fits = fit_readings(Trajectory(trajectory.stamps, trajectory.positions, written), accelerometer)
        assert fits[reading].rms_degrees == min(fit.rms_degrees for fit in fits.values()) or fits[
            reading
        ].rms_degrees == pytest.approx(min(fit.rms_degrees for fit in fits.values()), abs=0.01)
        assert fits[reading].up[2] > 0.99


def test_signs_and_lengths_of_quaternions_do_not_matter() -> None:
    trajectory, accelerometer = _record()
    factors = np.random.default_rng(1).choice([-3.0, -1.0, 0.2, 1.0], (len(trajectory), 1))
    scaled = Trajectory(trajectory.stamps, trajectory.positions, trajectory.quaternions * factors)
    first, second = fit_gravity(trajectory, accelerometer), fit_gravity(scaled, accelerometer)
    assert first is not None
    assert second is not None
    assert first.rms_degrees == pytest.approx(second.rms_degrees, abs=1e-6)


def test_rows_that_are_no_poses_are_left_out() -> None:
    trajectory, accelerometer = _record()
    quaternions = trajectory.quaternions.copy()
    quaternions[5], quaternions[9], quaternions[11] = np.nan, 0, 1e300
    fit = fit_gravity(Trajectory(trajectory.stamps, trajectory.positions, quaternions), accelerometer)
    assert fit is not None
    assert fit.rms_degrees < 0.5


@pytest.mark.parametrize("late", [-0.2, -0.05, 0.0, 0.03, 0.2])
def test_an_offset_of_the_clocks_is_found(late: float) -> None:
    offset = estimate_offset(*_record(20, late=late, noise=0.05))
    assert offset is not None
    assert offset[0] == pytest.approx(-late, abs=0.005)
    assert offset[1] > 3


def test_a_camera_that_stands_still_decides_nothing() -> None:
    record = _record(still=True, noise=0.1)
    angles = [fit.rms_degrees for fit in fit_readings(*record).values()]
    assert max(angles) < 1.01 * min(angles)
    offset = estimate_offset(*record)
    assert offset is None or offset[1] < 1.5


def test_too_few_rows_give_no_answer() -> None:
    trajectory, accelerometer = _record()
    few = trajectory.take(slice(0, 20))
    assert fit_gravity(few, accelerometer) is None
    assert fit_readings(few, accelerometer) == {}
    assert estimate_offset(few, accelerometer) is None
    assert fit_gravity(trajectory, Accelerometer.empty()) is None
    assert fit_gravity(Trajectory.empty(), accelerometer) is None
