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
_STEPS: Final = 60
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
    groundtruth: Trajectory,
    accelerometer: Accelerometer,
    reading: str = XYZW,
    shift_seconds: float = 0.0,
    start: tuple[float, float, float] | None = None,
) -> GravityFit | None:
    """Fit the accelerometer's mounting and the direction of gravity.

    Args:
        groundtruth: Poses, quaternions as they stand in the file.
        accelerometer: Accelerations.
        reading: How the quaternions are meant, a key of `READINGS`.
        shift_seconds: Added to the accelerometer's stamps.
        start: Direction to start from, where it is known roughly; several are tried otherwise.

    Returns:
        The best fit, or None if fewer than `MIN_ROWS` poses have a valid quaternion and accelerations
        around them.

    """
    prepared = _prepare(groundtruth, accelerometer, shift_seconds)
    if prepared is None:
        return None
    quaternions, directions = prepared
    order, inverse = READINGS[reading]
    starts = _STARTS if start is None else np.array([start])
    return _fit(_matrices(quaternions[:, order], inverse), directions, starts)


def fit_readings(groundtruth: Trajectory, accelerometer: Accelerometer) -> dict[str, GravityFit]:
    """Return the fit of each of `READINGS`; empty if there are too few rows."""
    fits = {reading: fit_gravity(groundtruth, accelerometer, reading) for reading in READINGS}
    return {reading: fit for reading, fit in fits.items() if fit is not None}


def estimate_offset(groundtruth: Trajectory, accelerometer: Accelerometer) -> tuple[float, float] | None:
    """Estimate by how much the accelerometer's stamps are early.

    Returns:
        Seconds to add to the accelerometer's stamps so that it fits best, from a parabola through the
        smallest of the mean squared angles (within 0.5 s), and by how much the fit is worse at the
        ends of the search, as a ratio of rms angles: near 1, the motion decides nothing. None if there
        are too few rows or the best fit is at the end of the search.

    """
    unshifted = fit_gravity(groundtruth, accelerometer)
    if unshifted is None:
        return None

    def squares(shifts: Floats) -> Floats:
        fits = [
            fit_gravity(groundtruth, accelerometer, shift_seconds=shift, start=unshifted.up)
            for shift in shifts.tolist()
        ]
        return np.array([np.inf if fit is None else fit.rms_degrees**2 for fit in fits])

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
    contrast = float(np.sqrt(min(rough[0], rough[-1]) / at)) if at > 0 else float("inf")
    return float(fine[middle] + vertex * _FINE_SECONDS), contrast


def _prepare(
    groundtruth: Trajectory, accelerometer: Accelerometer, shift_seconds: float
) -> tuple[Floats, Floats] | None:
    """Return the usable quaternions, normalised, and the mean acceleration around each as unit vectors."""
    order = np.argsort(accelerometer.stamps, kind="stable")
    stamps = accelerometer.stamps[order] + round(shift_seconds * 1e9)
    values = accelerometer.values[order]
    sums = np.concatenate([np.zeros((1, 3)), np.cumsum(np.nan_to_num(values), axis=0)])
    half = round(AVERAGING_SECONDS * 1e9 / 2)
    first = np.searchsorted(stamps, groundtruth.stamps - half)
    last = np.searchsorted(stamps, groundtruth.stamps + half, side="right")
    count = last - first
    means = (sums[last] - sums[first]) / np.maximum(count, 1)[:, None]
    norms = np.linalg.norm(means, axis=1)
    lengths = np.linalg.norm(groundtruth.quaternions, axis=1)
    # Half of the window must be there: one-sided means at the ends of the recording would be early or late.
    typical = np.median(count[count > 0]) if (count > 0).any() else 0
    with np.errstate(invalid="ignore"):
        usable = (count > 0.5 * typical) & (norms > 0) & np.isfinite(lengths) & (lengths > 0)
    if int(usable.sum()) < MIN_ROWS:
        return None
    return (
        groundtruth.quaternions[usable] / lengths[usable, None],
        means[usable] / norms[usable, None],
    )


def _matrices(quaternions: Floats, inverse: bool) -> Floats:
    """Return rotation matrices [n, 3, 3] of unit quaternions x y z w."""
    x, y, z, w = quaternions.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.array(rows).transpose((2, 1, 0) if inverse else (2, 0, 1))


def _fit(matrices: Floats, directions: Floats, starts: Floats) -> GravityFit:
    moment = np.einsum("ijk,il->jkl", matrices, directions)
    best_value, best_mounting, best_up = -np.inf, np.eye(3), starts[0]
    for start in starts:
        up = start / np.linalg.norm(start)
        value = -np.inf
        for _ in range(_STEPS):
            mounting = _procrustes(np.einsum("j,jkl->kl", up, moment))
            pull = np.einsum("jkl,kl->j", moment, mounting)
            before, value = value, float(np.linalg.norm(pull))
            up = pull / max(value, 1e-300)
            if value - before < _TOLERANCE * len(directions):
                break
        if value > best_value:
            best_value, best_mounting, best_up = value, mounting, up
    in_world = np.einsum("ijk,ik->ij", matrices, directions @ best_mounting.T)
    cosines = np.clip(in_world @ best_up, -1, 1)
    rms = float(np.degrees(np.sqrt(np.mean(np.arccos(cosines) ** 2))))
    x, y, z = (float(value) for value in best_up)
    return GravityFit(rms, (x, y, z), len(directions))


def _procrustes(moment: Floats) -> Floats:
    """Return the rotation C that maximises sum(C * moment)."""
    left, _, right = np.linalg.svd(moment)
    flip = np.array([1.0, 1.0, np.sign(np.linalg.det(left) * np.linalg.det(right))])
    rotation: Floats = (left * flip) @ right
    return rotation
