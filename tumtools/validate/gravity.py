# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Whether accelerometer and ground truth agree about where up is.

The accelerometer is fixed to the camera by an unknown rotation C. If the poses are read as they were
meant, R(q_i) C a_i points up all through a sequence; if the quaternions are in another order, or the poses
are inverse, no C makes it so. The same fit against shifted stamps gives the time offset of the two.

The fit maximises sum_i g . R_i C a_i over rotations C and unit vectors g. The sum is linear in both, so it
needs nothing of the data but the 3 x 3 x 3 numbers sum_i R_i (x) a_i; given g the best C is a Procrustes
problem, given C the best g is the mean direction, and the two alternate from several starts.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt

    from tumtools.model.signals import Accelerometer, Trajectory

    Floats = npt.NDArray[np.float64]

XYZW: Final = "x y z w"
READINGS: Final[dict[str, tuple[tuple[int, int, int, int], bool]]] = {
    XYZW: ((0, 1, 2, 3), False),
    "w x y z": ((1, 2, 3, 0), False),
    "inverse poses": ((0, 1, 2, 3), True),
    "inverse poses, w x y z": ((1, 2, 3, 0), True),
}
"""How a row's four numbers may be meant: where x, y, z and w stand, and whether the pose is inverse."""

AVERAGING_SECONDS: Final = 0.1
MIN_ROWS: Final = 30
"""Fewer poses with accelerations around them are not looked at."""
_STEPS: Final = 100
_ABSURD: Final = 1e100
"""Squares of greater numbers overflow; such numbers, and NaN, are left out."""
_TOLERANCE: Final = 1e-9
_STARTS: Final = np.array(
    [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1], [1, 1, 1], [-1, 1, -1]], np.float64
)
_SEARCH_SECONDS: Final = 0.5
_COARSE_SECONDS: Final = 0.05
_FINE_SECONDS: Final = 0.02


@dataclass(frozen=True, slots=True)
class GravityFit:
    """How well accelerations and poses agree.

    Attributes:
        rms_degrees: Angle of R C a to the common direction, root mean square.
        up: The common direction in the world, unit vector.
        rows: Poses that took part.

    """

    rms_degrees: float
    up: tuple[float, float, float]
    rows: int


def fit_gravity(
    groundtruth: Trajectory, accelerometer: Accelerometer, reading: str = XYZW, shift_seconds: float = 0.0
) -> GravityFit | None:
    """Fit the accelerometer's mounting and the direction of gravity.

    Args:
        groundtruth: Poses, quaternions as they stand in the file.
        accelerometer: Accelerations.
        reading: How the quaternions are meant, a key of `READINGS`.
        shift_seconds: Added to the accelerometer's stamps.

    Returns:
        The best fit, or None if fewer than `MIN_ROWS` poses have a valid quaternion and accelerations
        around them.

    """
    problem = _pose(groundtruth, accelerometer, shift_seconds)
    return None if problem is None else _solve([problem.read_as(reading)], _STARTS)[0]


def fit_readings(groundtruth: Trajectory, accelerometer: Accelerometer) -> dict[str, GravityFit]:
    """Return the fit of each of `READINGS`; empty if there are too few rows."""
    problem = _pose(groundtruth, accelerometer, 0.0)
    if problem is None:
        return {}
    fits = _solve([problem.read_as(reading) for reading in READINGS], _STARTS)
    return dict(zip(READINGS, fits, strict=True))


def estimate_offset(groundtruth: Trajectory, accelerometer: Accelerometer) -> tuple[float, float] | None:
    """Estimate by how much the accelerometer's stamps are early.

    Returns:
        Seconds to add to the accelerometer's stamps so that it fits best, from a parabola through the
        smallest of the mean squared angles (within 0.5 s), and by how much the fit is worse at the
        middling shift, as a ratio of rms angles: near 1, the motion decides nothing. None if there
        are too few rows or the best fit is at the end of the search.

    """
    unshifted = fit_gravity(groundtruth, accelerometer)
    if unshifted is None:
        return None
    start = np.array([unshifted.up])

    def squares(shifts: Floats) -> Floats:
        problems = [_pose(groundtruth, accelerometer, shift) for shift in shifts.tolist()]
        fits = iter(_solve([problem for problem in problems if problem is not None], start))
        return np.array([np.inf if problem is None else next(fits).rms_degrees ** 2 for problem in problems])

    coarse = np.arange(-_SEARCH_SECONDS, _SEARCH_SECONDS + _COARSE_SECONDS / 2, _COARSE_SECONDS)
    rough = squares(coarse)
    best = int(np.argmin(rough))
    if not 0 < best < len(coarse) - 1:
        return None
    fine = coarse[best] + _FINE_SECONDS * np.arange(-3, 4)
    near = squares(fine)
    middle = int(np.clip(np.argmin(near), 1, len(near) - 2))
    before, at, after = near[middle - 1 : middle + 2]
    curvature = before - 2 * at + after
    if not np.isfinite(curvature):
        return None
    vertex = 0.5 * (before - after) / curvature if curvature > 0 else 0.0
    contrast = float(np.sqrt(np.median(rough) / at)) if at > 0 else float("inf")
    return float(fine[middle] + vertex * _FINE_SECONDS), contrast


@dataclass(frozen=True, slots=True, eq=False)
class _Problem:
    """Unit quaternions [n, 4] and, as unit vectors, the mean acceleration around each [n, 3]."""

    quaternions: Floats
    directions: Floats
    inverse: bool = False

    def read_as(self, reading: str) -> _Problem:
        """Return the problem for another reading of the quaternions."""
        order, inverse = READINGS[reading]
        return _Problem(self.quaternions[:, order], self.directions, inverse)

    @property
    def matrices(self) -> Floats:
        """Rotation matrices, shape [n, 3, 3]."""
        x, y, z, w = self.quaternions.T
        rows = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
        return np.array(rows).transpose((2, 1, 0) if self.inverse else (2, 0, 1))


def _pose(groundtruth: Trajectory, accelerometer: Accelerometer, shift_seconds: float) -> _Problem | None:
    """Return what is usable of the rows; None if that is too little."""
    order = np.argsort(accelerometer.stamps, kind="stable")
    stamps = accelerometer.stamps[order] + round(shift_seconds * 1e9)
    values = np.where(np.abs(accelerometer.values[order]) < _ABSURD, accelerometer.values[order], 0)
    sums = np.concatenate([np.zeros((1, 3)), np.cumsum(values, axis=0)])
    half = round(AVERAGING_SECONDS * 1e9 / 2)
    first = np.searchsorted(stamps, groundtruth.stamps - half)
    last = np.searchsorted(stamps, groundtruth.stamps + half, side="right")
    count = last - first
    means = (sums[last] - sums[first]) / np.maximum(count, 1)[:, None]
    norms = np.linalg.norm(means, axis=1)
    quaternions = np.where(np.abs(groundtruth.quaternions) < _ABSURD, groundtruth.quaternions, 0)
    lengths = np.linalg.norm(quaternions, axis=1)
    # Half of the window must be there: one-sided means at the ends of the recording would be early or late.
    typical = np.median(count[count > 0]) if (count > 0).any() else 0
    usable = (count > 0.5 * typical) & (norms > 0) & (lengths > 0)
    if int(usable.sum()) < MIN_ROWS:
        return None
    return _Problem(quaternions[usable] / lengths[usable, None], means[usable] / norms[usable, None])


def _solve(problems: list[_Problem], starts: Floats) -> list[GravityFit]:
    """Solve several problems at once, each from all starts, shape [s, 3]."""
    if not problems:
        return []
    matrices = [problem.matrices for problem in problems]
    pairs = zip(matrices, problems, strict=True)
    moments = np.stack([np.einsum("ijk,il->jkl", matrix, one.directions) for matrix, one in pairs])
    rows = max(len(problem.directions) for problem in problems)
    ups = np.broadcast_to(
        starts / np.linalg.norm(starts, axis=1, keepdims=True), (len(problems), *starts.shape)
    )
    values = np.zeros(ups.shape[:2])
    for _ in range(_STEPS):
        mountings = _procrustes(np.einsum("psj,pjkl->pskl", ups, moments))
        pulls = np.einsum("pjkl,pskl->psj", moments, mountings)
        before, values = values, np.linalg.norm(pulls, axis=2)
        ups = pulls / np.maximum(values, 1e-300)[..., None]
        if float((values - before).max()) < _TOLERANCE * rows:
            break
    best = np.argmax(values, axis=1)
    return [
        _judge(matrix, one.directions, mountings[number, start], ups[number, start])
        for number, (matrix, one, start) in enumerate(zip(matrices, problems, best.tolist(), strict=True))
    ]


def _judge(matrices: Floats, directions: Floats, mounting: Floats, up: Floats) -> GravityFit:
    in_world = np.einsum("ijk,ik->ij", matrices, directions @ mounting.T)
    angles = np.arccos(np.clip(in_world @ up, -1, 1))
    x, y, z = (float(value) for value in up)
    return GravityFit(float(np.degrees(np.sqrt(np.mean(angles**2)))), (x, y, z), len(directions))


def _procrustes(moments: Floats) -> Floats:
    """Return the rotations C that maximise sum(C * moment), for each of the last two axes."""
    left, _, right = np.linalg.svd(moments)
    flip = np.ones(moments.shape[:-1])
    flip[..., 2] = np.sign(np.linalg.det(left) * np.linalg.det(right))
    rotations: Floats = (left * flip[..., None, :]) @ right
    return rotations
