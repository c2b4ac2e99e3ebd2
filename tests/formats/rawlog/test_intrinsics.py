# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Intrinsics keep their numbers and their model in MRPT's class."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tumtools.formats.rawlog.dialects import DIALECTS, camera_record
from tumtools.formats.rawlog.intrinsics import camera_of
from tumtools.model.camera import CameraInfo, calibration

PINHOLE = CameraInfo.pinhole(7.0, 7.5, 3.5, 2.5, width=8, height=6)


@pytest.mark.parametrize(
    ("model", "d", "stored"),
    [
        ("plumb_bob", (0.0,) * 5, [0.0] * 8),
        ("plumb_bob", (1.0, 2.0, 3.0, 4.0, 5.0), [1, 2, 3, 4, 5, 0, 0, 0]),
        ("rational_polynomial", (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0), [1, 2, 3, 4, 5, 6, 7, 8]),
        ("equidistant", (1.0, 2.0, 3.0, 4.0), [1, 2, 0, 0, 3, 4, 0, 0]),
    ],
)
def test_each_model_has_its_places(model: str, d: tuple[float, ...], stored: list[float]) -> None:
    camera = replace(PINHOLE, d=d, distortion_model=model)
    record = camera_record(DIALECTS["modern"], camera)
    assert record.array("distortion").tolist() == stored
    assert camera_of(record) == camera


@pytest.mark.parametrize("name", ["fr1", "fr2", "fr3", "ros-default"])
@pytest.mark.parametrize("dialect", DIALECTS)
def test_the_calibrations_of_the_benchmark_fit_into_all_dialects(name: str, dialect: str) -> None:
    camera = calibration(name, "rgb")
    record = camera_record(DIALECTS[dialect], camera)
    assert camera_of(record) == camera


@pytest.mark.parametrize("size", [(640, 480), (320, 240), (240, 320)])
@pytest.mark.parametrize("dialect", DIALECTS)
def test_rows_and_columns_are_in_their_places_in_all_dialects(size: tuple[int, int], dialect: str) -> None:
    """MRPT undoes an exchange in old files only for the depth camera, and only at 640x480."""
    width, height = size
    camera = CameraInfo.pinhole(300.0, 300.0, width / 2, height / 2, width=width, height=height)
    record = camera_record(DIALECTS[dialect], camera)
    assert (record.integer("columns"), record.integer("rows")) == size
    assert camera_of(record, swapped=True) == camera


def test_an_exchanged_size_is_undone_in_old_files_whatever_it_is() -> None:
    for width, height in ((640, 480), (320, 240)):
        camera = CameraInfo.pinhole(300.0, 300.0, width / 2, height / 2, width=width, height=height)
        written = camera_record(DIALECTS["legacy"], replace(camera, width=height, height=width))
        assert camera_of(written, swapped=True) == camera


def test_a_camera_that_was_never_set_is_none() -> None:
    record = camera_record(DIALECTS["modern"], replace(PINHOLE, k=(0.0,) * 9))
    assert camera_of(record) is None
    assert camera_of(None) is None
