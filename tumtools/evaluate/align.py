# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Least-squares alignment of matched positions.

Rigid: Horn, "Closed-form solution of absolute orientation using orthonormal matrices" (1988).
With scale: Umeyama, "Least-squares estimation of transformation parameters between two point
patterns" (1991), equations 40 to 43.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, get_args

import numpy as np

from tumtools.errors import InputError, UsageError
from tumtools.evaluate.geometry import from_matrix, multiply, nearest_rotation, normalised
from tumtools.model.signals import Trajectory

if TYPE_CHECKING:
    import numpy.typing as npt

    from tumtools.evaluate.geometry import Array

Mode = Literal["se3", "sim3", "none"]
MODES: Final[tuple[Mode, ...]] = get_args(Mode)

_FLAT: Final = 1e-9
"""A direction counts as not spanned below this share of the largest extent (squares: eps of float64)."""


@dataclass(frozen=True, slots=True, eq=False)
class Alignment:
    """Takes a position x of the estimate to the ground truth's frame: scale * rotation @ x + translation.

    Attributes:
        rotation: Shape [3, 3], determinant +1.
        translation: Metres, shape [3].
        scale: Positive; 1 for a rigid alignment.
        freedom: What the matched positions leave undetermined: empty, `rotation about a line`, or
            `rotation`. The errors of the matched positions are the least ones all the same.

    """

    rotation: Array
    translation: Array
    scale: float = 1.0
    freedom: str = ""

    def positions(self, positions: npt.NDArray[np.float64]) -> Array:
        """Apply to positions, shape [n, 3]."""
        result: Array = self.scale * (positions @ self.rotation.T) + self.translation
        return result

    def trajectory(self, trajectory: Trajectory) -> Trajectory:
        """Apply to the poses of a trajectory; quaternions that are zero stay so."""
        turn = np.broadcast_to(from_matrix(self.rotation), (len(trajectory), 4))
        turned = multiply(turn, normalised(trajectory.quaternions))
        turned[(trajectory.quaternions == 0.0).all(axis=1)] = 0.0
        return Trajectory(trajectory.stamps, self.positions(trajectory.positions), turned)


def align(
    estimate: npt.NDArray[np.float64], groundtruth: npt.NDArray[np.float64], mode: Mode = "se3"
) -> Alignment:
    """Find the transformation of the estimate with the least sum of squared distances.

    Args:
        estimate: Positions, metres (or the estimate's own unit), shape [n, 3], n > 0.
        groundtruth: Positions that belong to them, metres, shape [n, 3].
        mode: `se3` (rotation and translation), `sim3` (and scale) or `none` (identity).

    Raises:
        InputError: `sim3` on an estimate that does not move.
        UsageError: Unknown mode.

    """
    if mode not in MODES:
        msg = f"unknown alignment {mode!r}; there are {', '.join(MODES)}"
        raise UsageError(msg)
    if mode == "none":
        return Alignment(np.eye(3), np.zeros(3))
    centre_estimate, centre_groundtruth = estimate.mean(axis=0), groundtruth.mean(axis=0)
    centred, target = estimate - centre_estimate, groundtruth - centre_groundtruth
    covariance = target.T @ centred
    rotation = nearest_rotation(covariance)
    scale = 1.0
    if mode == "sim3":
        spread = float(np.sum(centred * centred))
        if spread <= (np.finfo(np.float64).eps * float(np.abs(estimate).max())) ** 2 * len(estimate):
            raise InputError(
                "the matched positions of the estimate do not move, so that no scale can be found",
                hint="align without scale (se3)",
            )
        scale = float(np.sum(rotation * covariance)) / spread
        if scale <= 0.0:
            raise InputError(
                "the best scale is not positive: estimate and ground truth do not move together",
                hint="check that the estimate belongs to this ground truth, or align without scale (se3)",
            )
    return Alignment(
        rotation=rotation,
        translation=centre_groundtruth - scale * rotation @ centre_estimate,
        scale=scale,
        freedom=_freedom(covariance, centred, target),
    )


def _freedom(covariance: Array, estimate: Array, groundtruth: Array) -> str:
    """Name what of the rotation is arbitrary: a line can be turned about itself, a point every way."""
    size = float(np.linalg.norm(estimate) * np.linalg.norm(groundtruth))
    spread = np.linalg.svd(covariance, compute_uv=False)
    if size == 0.0 or spread[0] <= _FLAT * size:
        return "rotation"
    return "rotation about a line" if spread[1] <= _FLAT * spread[0] else ""
