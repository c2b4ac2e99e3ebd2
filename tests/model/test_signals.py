# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Trajectories and accelerations are columns of one length."""

from __future__ import annotations

import numpy as np
import pytest

from tumtools.model.signals import Accelerometer, Trajectory

STAMPS = np.arange(3, dtype=np.int64)


def test_columns_of_different_lengths_are_refused() -> None:
    with pytest.raises(ValueError, match=r"\[n, 4\], not \(3,\), \(3, 3\), \(2, 4\)"):
        Trajectory(STAMPS, np.zeros((3, 3)), np.zeros((2, 4)))
    with pytest.raises(ValueError, match=r"not \(3,\), \(3, 4\)"):
        Accelerometer(STAMPS, np.zeros((3, 4)))


def test_rows_are_taken_in_the_order_given() -> None:
    trajectory = Trajectory(STAMPS, np.arange(9.0).reshape(3, 3), np.arange(12.0).reshape(3, 4))
    taken = trajectory.take(np.array([2, 0]))
    assert taken.stamps.tolist() == [2, 0]
    assert taken.values.tolist() == [[6, 7, 8, 8, 9, 10, 11], [0, 1, 2, 0, 1, 2, 3]]
    accelerometer = Accelerometer(STAMPS, np.arange(9.0).reshape(3, 3)).take(np.array([True, False, True]))
    assert accelerometer.values.tolist() == [[0, 1, 2], [6, 7, 8]]


def test_empty_signals_have_no_rows() -> None:
    assert len(Trajectory.empty()) == len(Accelerometer.empty()) == 0
    assert Trajectory.empty().values.shape == (0, 7)
