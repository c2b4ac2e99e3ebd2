# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Rays meet the surface that is nearest, at the depth that geometry demands."""

from __future__ import annotations

import numpy as np
import pytest

from tumtools.model.camera import CAMERAS, CameraInfo, calibration
from tumtools.synthetic.bake import Scene, bake
from tumtools.synthetic.render import camera_rays, cast, model_limit, shade


@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize("sensor", ["rgb", "ir"])
def test_rays_undo_the_lens(camera: str, sensor: str) -> None:
    info = calibration(camera, sensor)
    rays = camera_rays(info)
    x, y = rays.x.astype(np.float64), rays.y.astype(np.float64)
    k1, k2, p1, p2, k3 = info.d
    r2 = x * x + y * y
    radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
    column = info.k[0] * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + info.k[2]
    row = info.k[4] * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + info.k[5]
    valid = r2 < model_limit(info)
    assert valid.mean() > (0.85 if (camera, sensor) == ("fr2", "ir") else 0.999)  # that model folds over
    np.testing.assert_allclose((column - np.arange(640)[None])[valid], 0, atol=0.02)
    np.testing.assert_allclose((row - np.arange(480)[:, None])[valid], 0, atol=0.02)
    assert (np.diff(rays.x, axis=1) > 0).all()


@pytest.fixture(scope="module")
def scene() -> Scene:
    return bake(0, 0.025)


def test_the_room_is_closed(scene: Scene) -> None:
    rays = camera_rays(CameraInfo.pinhole(20, 20, 19.5, 14.5, width=40, height=30))
    turn = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])  # looks along +y
    about_z = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    for _ in range(4):
        view = cast(scene, rays, np.array([-0.25, -0.75, 1.42]), turn)
        assert (view.surface >= 0).all()
        assert np.isfinite(view.depth).all()
        turn = about_z @ turn


def test_depth_is_along_the_optical_axis(scene: Scene) -> None:
    rays = camera_rays(CameraInfo.pinhole(100, 100, 19.5, 14.5, width=40, height=30))
    down = np.array([[1.0, 0, 0], [0, -1, 0], [0, 0, -1]])
    view = cast(scene, rays, np.array([-0.6, -1.6, 1.5]), down)  # a bare piece of the floor
    np.testing.assert_allclose(view.depth, 1.5, atol=1e-5)
    assert (shade(scene, view, 100) > 5).all()


def test_what_is_nearer_hides_what_is_behind(scene: Scene) -> None:
    rays = camera_rays(CameraInfo.pinhole(400, 400, 19.5, 14.5, width=40, height=30))
    ahead = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
    view = cast(scene, rays, np.array([-0.28, 0.0, 1.0]), ahead)  # a monitor at y = 1.87 before a wall at 2.3
    assert (view.depth < 1.95).all()
