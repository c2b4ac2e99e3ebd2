# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The benchmark's calibrations, and which camera a name speaks of."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tumtools.model.camera import CAMERAS, CameraInfo, calibration, camera_of_name


def test_depth_is_registered_to_colour_and_shares_its_intrinsics() -> None:
    for camera in CAMERAS:
        assert calibration(camera, "depth") == calibration(camera, "rgb")


def test_infrared_has_its_own_intrinsics() -> None:
    assert calibration("fr1", "ir").k[0] == 591.1


def test_an_unknown_camera_is_refused() -> None:
    with pytest.raises(KeyError):
        calibration("fr4", "rgb")


def test_scaling_keeps_the_view() -> None:
    full = calibration("fr1", "rgb")
    half = full.scaled_to(320, 240)
    x_of_column_0 = (0 - full.k[2]) / full.k[0], (0.5 - full.k[2]) / full.k[0]
    # The first pixel of the half image covers the first two of the full one.
    assert (0 - half.k[2]) / half.k[0] == pytest.approx(
        sum((x_of_column_0[0], x_of_column_0[1])) - x_of_column_0[0]
    )
    assert half.d == full.d
    assert full.scaled_to(640, 480) is full


def test_the_projection_is_that_of_an_unrectified_camera() -> None:
    info = CameraInfo.pinhole(500.0, 501.0, 320.0, 240.0)
    assert info.p == (500.0, 0.0, 320.0, 0.0, 0.0, 501.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0)
    assert info.r == (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


@pytest.mark.parametrize(
    ("name", "camera"),
    [
        ("rgbd_dataset_freiburg1_xyz", "fr1"),
        ("RGBD_dataset_freiburg2_desk-groundtruth.txt", "fr2"),
        ("fr3/walking_xyz", "fr3"),
        ("fr1_desk", "fr1"),
        ("freiburg10_x", None),
        ("kitchen", None),
        ("", None),
        (None, None),
    ],
)
def test_the_camera_of_a_name(name: str | None, camera: str | None) -> None:
    assert camera_of_name(name) == camera


def test_cameras_with_the_same_numbers_are_equal_even_if_some_are_none() -> None:
    one, other = (replace(calibration("fr1", "rgb"), d=(float("nan"), 1.0)) for _ in range(2))
    assert one == other
    assert hash(one) == hash(other)
    assert one != replace(other, d=(1.0, float("nan")))
    assert one != replace(other, d=(float("nan"), 1.0, 0.0))
    assert one != "a camera"


def test_numbers_and_sizes_tell_what_can_be_no_camera() -> None:
    good = calibration("fr1", "rgb")
    assert good.is_plausible
    mirrored = tuple(-number for number in good.k)
    for wrong in (
        {"d": (float("nan"),)},
        {"k": (float("inf"),) * 9},
        {"k": mirrored},
        {"width": 0},
        {"height": 2**32 - 1},
    ):
        assert not replace(good, **wrong).is_plausible  # type: ignore[arg-type]  # as named
