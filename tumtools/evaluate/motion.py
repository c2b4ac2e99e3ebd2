# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""How a camera moves: the numbers of the paper's Table I and of the benchmark's page.

The page's "trajectory length" is no path length. It is made of the displacements over one second, so
that it smooths short motion (7.11 m for fr1/xyz, whose path has 9.16 m) and counts the way across
holes many times. Both are given here, each under its own name.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.evaluate.associate import closest
from tumtools.evaluate.geometry import angles, conjugate, multiply, normalised
from tumtools.evaluate.seconds import rounded_seconds
from tumtools.evaluate.trajectories import clean
from tumtools.model.time import NANOSECONDS_PER_SECOND

if TYPE_CHECKING:
    from tumtools.evaluate.geometry import Array
    from tumtools.model.signals import Trajectory

LONG_GAP: Final = NANOSECONDS_PER_SECOND // 2
"""Gaps longer than this are counted as holes: half a second."""


@dataclass(frozen=True, slots=True)
class Motion:
    """Statistics of a trajectory.

    Attributes:
        rows: Rows of the file.
        repeated_rows: Rows whose stamp comes again.
        first: First stamp, ns.
        last: Last stamp, ns.
        duration: Last minus first stamp, seconds.
        duration_with_poses: Median step times poses, seconds; less than the duration where poses
            are missing ("duration with ground truth" of the page).
        median_rate: Poses per second, from the median step.
        translational_velocity: Mean displacement over one second, m/s; None below one second.
        rotational_velocity: Mean angle over one second, deg/s; None below one second.
        dimensions: Largest minus smallest x, y, z, metres.
        page_length: "Trajectory length" of the benchmark's page: sum of the displacements over one
            second divided by the mean rate, metres; None below one second.
        path_length: Length of the polyline through all poses, metres.
        long_gaps: Steps longer than `LONG_GAP`.
        wide_gaps: Steps longer than twice the median, as the floats of the benchmark's programs have
            it (`tumtools.evaluate.seconds`): of steps of exactly twice the median some are counted.
        largest_gap: Longest step, seconds.
        smallest_step: Shortest step between different stamps, seconds.
        notes: Rows that were left out.

    """

    rows: int
    repeated_rows: int
    first: int
    last: int
    duration: float
    duration_with_poses: float
    median_rate: float | None
    translational_velocity: float | None
    rotational_velocity: float | None
    dimensions: tuple[float, float, float]
    page_length: float | None
    path_length: float
    long_gaps: int
    wide_gaps: int
    largest_gap: float
    smallest_step: float
    notes: tuple[str, ...]


def motion(trajectory: Trajectory, who: str = "ground truth") -> Motion:
    """Sum up a trajectory with the formulas of the benchmark's page.

    Args:
        trajectory: Poses in any order.
        who: What to call it in messages.

    Raises:
        InputError: No row can be used.

    """
    cleaned = clean(trajectory, who, rotations=True)
    poses = cleaned.trajectory
    stamps, positions = poses.stamps, poses.positions
    steps = np.diff(stamps)
    median = float(np.median(steps)) if len(steps) else 0.0
    duration = (int(stamps[-1]) - int(stamps[0])) / NANOSECONDS_PER_SECOND
    moved, turned = _over_one_second(poses)
    extent = np.ptp(positions, axis=0)
    return Motion(
        rows=len(trajectory),
        repeated_rows=len(trajectory) - len(np.unique(trajectory.stamps)),
        first=int(stamps[0]),
        last=int(stamps[-1]),
        duration=duration,
        duration_with_poses=median * len(poses) / NANOSECONDS_PER_SECOND,
        median_rate=NANOSECONDS_PER_SECOND / median if median else None,
        translational_velocity=float(np.mean(moved)) if len(moved) else None,
        rotational_velocity=float(np.mean(turned)) if len(turned) else None,
        dimensions=(float(extent[0]), float(extent[1]), float(extent[2])),
        page_length=float(np.sum(moved)) * duration / len(steps) if len(moved) else None,
        path_length=float(np.sum(np.linalg.norm(np.diff(positions, axis=0), axis=1))),
        long_gaps=int(np.count_nonzero(steps > LONG_GAP)),
        wide_gaps=_wide_gaps(poses),
        largest_gap=int(steps.max()) / NANOSECONDS_PER_SECOND if len(steps) else 0.0,
        smallest_step=int(steps.min()) / NANOSECONDS_PER_SECOND if len(steps) else 0.0,
        notes=cleaned.notes,
    )


def _wide_gaps(poses: Trajectory) -> int:
    steps = np.diff(rounded_seconds(poses.stamps))
    return int(np.count_nonzero(steps > 2.0 * np.median(steps))) if len(steps) else 0


def _over_one_second(poses: Trajectory) -> tuple[Array, Array]:
    """Return displacement (m) and angle (deg) from each pose to the one nearest to a second later.

    Only for poses with a second left in the file. Nearest as the floats of the benchmark's own
    programs have it (`tumtools.evaluate.seconds`), of two as near the earlier.
    """
    first = np.flatnonzero(poses.stamps <= poses.stamps[-1] - NANOSECONDS_PER_SECOND)
    seconds = rounded_seconds(poses.stamps)
    second = closest(seconds, seconds[first] + 1.0)
    turns = normalised(poses.quaternions)
    moved = np.linalg.norm(poses.positions[second] - poses.positions[first], axis=1)
    turned: Array = np.degrees(angles(multiply(conjugate(turns[first]), turns[second])))
    return moved, turned
