# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Poses between the poses of a trajectory, never across holes.

Positions linearly, rotations by SLERP (Shoemake, "Animating rotation with quaternion curves", 1985)
along the shorter arc.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.evaluate.geometry import angles, conjugate, multiply, normalised
from tumtools.model.signals import Trajectory

if TYPE_CHECKING:
    import numpy.typing as npt

    from tumtools.evaluate.geometry import Array

MAX_HOLE: Final = 100_000_000
"""Holes longer than this are not bridged by default: 0.1 s, ten poses of the benchmark's 100 Hz."""


def interpolate(
    trajectory: Trajectory, stamps: npt.NDArray[np.int64], max_hole: int = MAX_HOLE
) -> tuple[Trajectory, npt.NDArray[np.bool_]]:
    """Return the poses at given stamps.

    Args:
        trajectory: Strictly ascending stamps, finite, quaternions not zero; at least one pose.
        stamps: Wanted stamps, ns, int64, shape [n].
        max_hole: A stamp between two poses that are farther apart than this (ns) has no pose. One
            that is itself a stamp of the trajectory always has.

    Returns:
        The poses at those of the stamps that have one, and which those are, bool, shape [n].

    """
    times = trajectory.stamps
    right = np.searchsorted(times, stamps)
    inside = right.clip(max=len(times) - 1)
    exact = times[inside] == stamps
    left = np.where(exact, inside, right - 1).clip(0)
    right = inside
    between = (left < right) & (times[right] - times[left] <= max_hole) & (stamps < times[right])
    known = exact | (between & (stamps >= times[0]))
    left, right = left[known], right[known]
    step = (times[right] - times[left]).astype(np.float64)
    share = np.divide(
        (stamps[known] - times[left]).astype(np.float64), step, out=np.zeros(len(step)), where=step > 0
    )
    positions = trajectory.positions[left] + share[:, None] * (
        trajectory.positions[right] - trajectory.positions[left]
    )
    rotations = normalised(trajectory.quaternions)
    return Trajectory(stamps[known], positions, slerp(rotations[left], rotations[right], share)), known


def slerp(start: Array, end: Array, share: Array) -> Array:
    """Turn unit quaternions [n, 4] by a share [n] (0 .. 1) of the way from start to end."""
    turn = multiply(conjugate(start), end)
    turn = np.where(turn[:, 3:] < 0.0, -turn, turn)
    half = angles(turn) * share / 2.0
    length = np.linalg.norm(turn[:, :3], axis=1, keepdims=True)
    axis = np.divide(turn[:, :3], length, out=np.zeros_like(turn[:, :3]), where=length > 0.0)
    return multiply(start, np.concatenate([axis * np.sin(half)[:, None], np.cos(half)[:, None]], axis=1))
