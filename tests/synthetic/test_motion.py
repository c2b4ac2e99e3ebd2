# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The path is smooth, and its accelerations are the derivatives of its positions."""

from __future__ import annotations

import numpy as np

from tumtools.synthetic.motion import Motion, rotation_matrices


def test_accelerations_are_second_derivatives() -> None:
    motion = Motion.from_seed(5)
    seconds = np.linspace(0, 4, 4001)
    step = seconds[1]
    numeric = np.diff(motion.positions(seconds), 2, axis=0) / step**2
    np.testing.assert_allclose(numeric, motion.accelerations(seconds)[1:-1], atol=2e-5)


def test_quaternions_are_unit_rotations_without_sign_flips() -> None:
    quaternions = Motion.from_seed(1).quaternions(np.linspace(0, 20, 2000))
    np.testing.assert_allclose(np.linalg.norm(quaternions, axis=1), 1, atol=1e-11)
    assert (np.sum(quaternions[1:] * quaternions[:-1], axis=1) > 0.99).all()


def test_the_camera_looks_ahead_and_a_little_down() -> None:
    forward = rotation_matrices(Motion.from_seed(2).quaternions(np.linspace(0, 20, 200)))[:, :, 2]
    mean = forward.mean(axis=0)
    assert mean[1] > 0.7
    assert -0.6 < mean[2] < 0


def test_speeds_are_those_of_a_hand() -> None:
    seconds = np.linspace(0, 30, 3000)
    motion = Motion.from_seed(3)
    speed = np.linalg.norm(np.diff(motion.positions(seconds), axis=0), axis=1) / seconds[1]
    dots = np.clip(np.abs(np.sum(np.diff(motion.quaternions(seconds), axis=0) ** 2, axis=1)), 0, 1)
    turn = np.degrees(2 * np.sqrt(dots)) / seconds[1]
    assert speed.max() < 1
    assert 20 < turn.mean() < 120
