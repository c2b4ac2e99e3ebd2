# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A hand-held camera's path: sums of sines, so that velocities and accelerations are exact."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt

    Floats = npt.NDArray[np.float64]

GRAVITY: Final = 9.81
"""m/s2, along the world's -z."""

_SWING_DEGREES: Final = (23.0, 17.0, 25.0)
"""Amplitudes of yaw, pitch and roll: enough within two seconds for the gravity check to decide."""
_SWAY_METRES: Final = (0.06, 0.05, 0.04)
_CENTRE: Final = (-0.25, -0.75, 1.42)
_PITCH_DOWN_DEGREES: Final = 15.0
_DIGITS: Final = 12
"""Angles are rounded to this, so that the last bit of a machine's sine does not matter."""


@dataclass(frozen=True, slots=True)
class _Wave:
    """One sine per axis: amplitude, frequency (Hz) and phase (rad), each of shape [3]."""

    amplitude: Floats
    frequency: Floats
    phase: Floats

    def value(self, seconds: Floats) -> Floats:
        """Return the waves at times [n], shape [n, 3]."""
        angle = 2 * math.pi * self.frequency * seconds[:, None] + self.phase
        return np.round(self.amplitude * np.sin(angle), _DIGITS)

    def second_derivative(self, seconds: Floats) -> Floats:
        """Return the accelerations at times [n], shape [n, 3]."""
        return -((2 * math.pi * self.frequency) ** 2) * self.value(seconds)


@dataclass(frozen=True, slots=True)
class Motion:
    """Pose of the camera's optical frame (x right, y down, z forward) in a world whose z is up."""

    sway: _Wave
    tremor: _Wave
    swing: _Wave

    @classmethod
    def from_seed(cls, seed: int) -> Motion:
        """Choose frequencies and phases."""
        random = np.random.Generator(np.random.PCG64([seed, 0]))

        def wave(amplitude: Floats, low: float, high: float) -> _Wave:
            return _Wave(amplitude, random.uniform(low, high, 3), random.uniform(0, 2 * math.pi, 3))

        return cls(
            sway=wave(np.array(_SWAY_METRES), 0.25, 0.5),
            tremor=wave(np.full(3, 0.0005), 2.0, 3.5),
            swing=wave(np.radians(_SWING_DEGREES), 0.45, 0.7),
        )

    def positions(self, seconds: Floats) -> Floats:
        """Return metres, shape [n, 3]."""
        return np.array(_CENTRE) + self.sway.value(seconds) + self.tremor.value(seconds)

    def accelerations(self, seconds: Floats) -> Floats:
        """Return second derivatives of the positions, m/s2 in the world, shape [n, 3]."""
        return self.sway.second_derivative(seconds) + self.tremor.second_derivative(seconds)

    def quaternions(self, seconds: Floats) -> Floats:
        """Return rotations camera -> world as x y z w, without sign flips, shape [n, 4]."""
        yaw, pitch, roll = self.swing.value(seconds).T
        level = np.full_like(yaw, -math.pi / 2 - math.radians(_PITCH_DOWN_DEGREES))
        return _multiply(
            _about(2, yaw), _multiply(_about(0, level), _multiply(_about(0, pitch), _about(2, roll)))
        )


def _about(axis: int, angles: Floats) -> Floats:
    """Return rotations about one axis, shape [n, 4]."""
    quaternions = np.zeros((len(angles), 4))
    quaternions[:, axis] = np.round(np.sin(angles / 2), _DIGITS)
    quaternions[:, 3] = np.round(np.cos(angles / 2), _DIGITS)
    return quaternions


def _multiply(first: Floats, second: Floats) -> Floats:
    """Return the Hamilton products, row by row."""
    x, y, z, w = first.T
    a, b, c, d = second.T
    return np.stack(
        [
            w * a + x * d + y * c - z * b,
            w * b - x * c + y * d + z * a,
            w * c + x * b - y * a + z * d,
            w * d - x * a - y * b - z * c,
        ],
        axis=1,
    )


def rotation_matrices(quaternions: Floats) -> Floats:
    """Return matrices, shape [n, 3, 3], of unit quaternions x y z w, shape [n, 4]."""
    x, y, z, w = quaternions.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def rotate_back(matrices: Floats, vectors: Floats) -> Floats:
    """Return `R^T v` row by row; no BLAS, whose order of summation depends on the machine."""
    products: Floats = (matrices * vectors[..., :, None]).sum(axis=-2)
    return products
