# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Cast the rays of a pinhole camera with lens distortion into the room."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.synthetic.motion import rotate_back

if TYPE_CHECKING:
    import numpy.typing as npt

    from tumtools.model.camera import CameraInfo
    from tumtools.synthetic.bake import Scene

    Plane = npt.NDArray[np.float32]

_NEAR: Final = 0.05
"""Metres; nothing nearer is drawn."""
_UNDISTORT_STEPS: Final = 30
_LEAST_GROWTH: Final = 0.4
"""Least slope of the distorted radius over the undistorted one."""
_MARGIN: Final = 0.04
"""How much further the box around a surface reaches than its corners (at depth 1), because lenses bend
straight lines outwards."""


@dataclass(frozen=True, slots=True, eq=False)
class Rays:
    """The direction (x, y, 1) that each pixel looks in, float32, each of shape [height, width]."""

    x: Plane
    y: Plane


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """What each pixel sees.

    Attributes:
        depth: Metres along the optical axis, float32, shape [height, width].
        surface: Number of the surface.
        u: Metres along the surface's first edge.
        v: Metres along its second edge.
        slope: Cosine of the angle between ray and normal, 0 .. 1.

    """

    depth: Plane
    surface: npt.NDArray[np.int16]
    u: Plane
    v: Plane
    slope: Plane


def camera_rays(camera: CameraInfo) -> Rays:
    """Invert the lens model (k1 k2 p1 p2 k3) for every pixel, by fixed-point iteration.

    Beyond `model_limit` the distortion stays what it is there.
    """
    fx, cx, fy, cy = camera.k[0], camera.k[2], camera.k[4], camera.k[5]
    k1, k2, p1, p2, k3 = camera.d
    goal_x = (np.arange(camera.width)[None, :] - cx) / fx + np.zeros((camera.height, 1))
    goal_y = (np.arange(camera.height)[:, None] - cy) / fy + np.zeros((1, camera.width))
    limit = model_limit(camera)
    x, y = goal_x, goal_y
    for _ in range(_UNDISTORT_STEPS):
        r2 = np.minimum(x * x + y * y, limit)
        radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
        shift_x = 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
        shift_y = p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
        x, y = (goal_x - shift_x) / radial, (goal_y - shift_y) / radial
    return Rays(x.astype(np.float32), y.astype(np.float32))


def model_limit(camera: CameraInfo) -> float:
    """Return the squared radius (at depth 1) up to which the lens model can be inverted.

    A polynomial fitted to the middle of the image may fold over in its corners, as that of the fr2
    infrared camera does.
    """
    k1, k2, _, _, k3 = camera.d
    r2 = np.linspace(0, 2, 2001)
    growth = 1 + r2 * (3 * k1 + r2 * (5 * k2 + r2 * 7 * k3))
    folds = np.flatnonzero(growth < _LEAST_GROWTH)
    return float(r2[folds[0]] if len(folds) else r2[-1])


def cast(
    scene: Scene, rays: Rays, position: npt.NDArray[np.float64], rotation: npt.NDArray[np.float64]
) -> View:
    """Return what the camera sees.

    Args:
        scene: The room.
        rays: Of the camera.
        position: Of the optical centre, metres, shape [3].
        rotation: Camera to world, shape [3, 3].

    """
    shape = rays.x.shape
    view = View(
        np.full(shape, np.inf, np.float32),
        np.full(shape, -1, np.int16),
        *(np.zeros(shape, np.float32) for _ in range(3)),
    )
    column_x, row_y = rays.x[shape[0] // 2], rays.y[:, shape[1] // 2]
    frames = _in_camera(scene, position, rotation)
    facing = (frames[:, 0] * frames[:, 3]).sum(axis=1) < 0
    corners = _corners(scene, frames)
    for number in np.flatnonzero(facing & (corners[:, :, 2] > _NEAR).any(axis=1)).tolist():
        window = _window(corners[number], column_x, row_y)
        if window is not None:
            _draw(view, rays, window, number, scene.sizes[number], frames[number].astype(np.float32))
    return view


def _in_camera(
    scene: Scene, position: npt.NDArray[np.float64], rotation: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Return origin, first edge, second edge and normal of all surfaces, in the camera's axes, [n, 4, 3]."""
    vectors = scene.frames.copy()
    vectors[:, 0] -= position
    return rotate_back(np.broadcast_to(rotation, (*vectors.shape[:2], 3, 3)), vectors)


def _corners(scene: Scene, frames: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return the corners of all surfaces, in the camera's axes, shape [n, 4, 3]."""
    right = frames[:, 1] * scene.sizes[:, :1]
    down = frames[:, 2] * scene.sizes[:, 1:]
    origin = frames[:, 0]
    return np.stack([origin, origin + right, origin + down, origin + right + down], axis=1)


def _window(corners: npt.NDArray[np.float64], column_x: Plane, row_y: Plane) -> tuple[slice, slice] | None:
    """Return the rows and columns that can see a surface with these corners, None if there are none."""
    x, y, z = corners.T
    if (z <= _NEAR).any():
        return slice(0, len(row_y)), slice(0, len(column_x))
    columns = np.searchsorted(column_x, [(x / z).min() - _MARGIN, (x / z).max() + _MARGIN])
    rows = np.searchsorted(row_y, [(y / z).min() - _MARGIN, (y / z).max() + _MARGIN])
    if columns[0] == columns[1] or rows[0] == rows[1]:
        return None
    return slice(int(rows[0]), int(rows[1])), slice(int(columns[0]), int(columns[1]))


def _draw(
    view: View,
    rays: Rays,
    window: tuple[slice, slice],
    number: int,
    size: npt.NDArray[np.float64],
    frame: npt.NDArray[np.float32],
) -> None:
    """Enter a surface where it is nearer than what is there."""
    x, y = rays.x[window], rays.y[window]
    origin, right, down, normal = frame
    facing = normal[0] * x + normal[1] * y + normal[2]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        depth = (normal * origin).sum() / facing
        u = (right[0] * x + right[1] * y + right[2]) * depth - (right * origin).sum()
        v = (down[0] * x + down[1] * y + down[2]) * depth - (down * origin).sum()
        seen = (depth > _NEAR) & (depth < view.depth[window]) & (facing < 0)
        seen &= (u >= 0) & (u <= size[0]) & (v >= 0) & (v <= size[1])
    if not seen.any():
        return
    np.copyto(view.depth[window], depth, where=seen)
    np.copyto(view.surface[window], np.int16(number), where=seen)
    np.copyto(view.u[window], u, where=seen)
    np.copyto(view.v[window], v, where=seen)
    np.copyto(view.slope[window], -facing / np.sqrt(x * x + y * y + 1), where=seen)


def shade(scene: Scene, view: View, focal_length: float) -> npt.NDArray[np.float32]:
    """Look the texels up, bilinearly, at the size that fits a pixel; shape [height, width, 3], 0 .. 255.

    Args:
        scene: The room.
        view: What each pixel sees.
        focal_length: Pixels.

    """
    surface = np.maximum(view.surface, 0)
    footprint = view.depth / np.float32(focal_length * scene.texel) / np.sqrt(np.maximum(view.slope, 0.1))
    level = np.clip(np.rint(np.log2(np.maximum(footprint, 1e-3))), 0, len(scene.first) - 1).astype(np.intp)
    sizes = scene.sizes.astype(np.float32)
    first, rows, columns = (
        scene.first[level, surface],
        scene.rows[level, surface],
        scene.columns[level, surface],
    )
    left, right_share = _neighbours(view.u / sizes[surface, 0], columns)
    top, down_share = _neighbours(view.v / sizes[surface, 1], rows)
    corner = first + top * columns + left
    upper = _mix(scene.texels[corner], scene.texels[corner + 1], right_share)
    corner += columns
    lower = _mix(scene.texels[corner], scene.texels[corner + 1], right_share)
    return upper + (lower - upper) * down_share[..., None]


def _neighbours(fraction: Plane, count: npt.NDArray[np.intp]) -> tuple[npt.NDArray[np.intp], Plane]:
    """Return the texel before a place, and how far it is to the next."""
    place = np.clip(fraction * count - np.float32(0.5), 0, count - 1.001).astype(np.float32)
    before = np.minimum(place.astype(np.intp), count - 2)
    return before, (place - before).astype(np.float32)


def _mix(
    first: npt.NDArray[np.uint8], second: npt.NDArray[np.uint8], share: Plane
) -> npt.NDArray[np.float32]:
    start = first.astype(np.float32)
    return start + (second.astype(np.float32) - start) * share[..., None]
