# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Rotations as arrays of unit quaternions, x y z w as in the benchmark's files."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


def normalised(quaternions: Array) -> Array:
    """Return quaternions of norm one, shape [n, 4]; those of norm zero become NaN."""
    with np.errstate(invalid="ignore", divide="ignore"):
        result: Array = quaternions / np.linalg.norm(quaternions, axis=-1, keepdims=True)
    return result


def conjugate(quaternions: Array) -> Array:
    """Return the inverse rotations of unit quaternions, shape [..., 4]."""
    result: Array = quaternions * np.array([-1.0, -1.0, -1.0, 1.0])
    return result


def multiply(left: Array, right: Array) -> Array:
    """Return the Hamilton products left * right (first `right`, then `left`), shape [..., 4]."""
    lx, ly, lz, lw = np.moveaxis(left, -1, 0)
    rx, ry, rz, rw = np.moveaxis(right, -1, 0)
    return np.stack(
        [
            lw * rx + lx * rw + ly * rz - lz * ry,
            lw * ry - lx * rz + ly * rw + lz * rx,
            lw * rz + lx * ry - ly * rx + lz * rw,
            lw * rw - lx * rx - ly * ry - lz * rz,
        ],
        axis=-1,
    )


def rotate(quaternions: Array, vectors: Array) -> Array:
    """Rotate vectors [..., 3] by unit quaternions [..., 4]."""
    axis, w = quaternions[..., :3], quaternions[..., 3:]
    twice = 2.0 * np.cross(axis, vectors)
    result: Array = vectors + w * twice + np.cross(axis, twice)
    return result


def angles(quaternions: Array) -> Array:
    """Return how far unit quaternions turn, radians in 0 .. pi, shape [...].

    From sine and cosine both, so that small angles keep their digits; the trace formula of the
    benchmark's scripts agrees with it to about 1e-8 rad.
    """
    result: Array = 2.0 * np.arctan2(
        np.linalg.norm(quaternions[..., :3], axis=-1), np.abs(quaternions[..., 3])
    )
    return result


def matrices(quaternions: Array) -> Array:
    """Return the rotation matrices of unit quaternions [n, 4], shape [n, 3, 3]."""
    x, y, z, w = np.moveaxis(quaternions, -1, 0)
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def from_matrix(matrix: Array) -> Array:
    """Return the unit quaternion of a rotation matrix [3, 3], shape [4], w not negative.

    The column of q q^T with the largest diagonal element is used, which is never near zero.
    """
    m = matrix
    products = np.array(
        [
            [1.0 + m[0, 0] - m[1, 1] - m[2, 2], m[0, 1] + m[1, 0], m[0, 2] + m[2, 0], m[2, 1] - m[1, 2]],
            [m[0, 1] + m[1, 0], 1.0 - m[0, 0] + m[1, 1] - m[2, 2], m[1, 2] + m[2, 1], m[0, 2] - m[2, 0]],
            [m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], 1.0 - m[0, 0] - m[1, 1] + m[2, 2], m[1, 0] - m[0, 1]],
            [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], 1.0 + np.trace(m)],
        ]
    )
    column = products[int(np.argmax(np.diag(products)))]
    quaternion: Array = column / np.linalg.norm(column)
    return -quaternion if quaternion[3] < 0.0 else quaternion


def nearest_rotation(matrix: Array) -> Array:
    """Return the rotation matrix [3, 3] that maximises trace(R^T matrix) (Horn 1988, Umeyama 1991)."""
    left, _, right = np.linalg.svd(matrix)
    sign = np.ones(3)
    if np.linalg.det(left) * np.linalg.det(right) < 0.0:
        sign[2] = -1.0
    result: Array = (left * sign) @ right
    return result
