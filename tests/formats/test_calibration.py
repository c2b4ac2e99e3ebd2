# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Calibrations are read from the files that people have."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from tumtools import api
from tumtools.cli.main import run
from tumtools.errors import InputError
from tumtools.formats.calibration import read_calibration

if TYPE_CHECKING:
    from pathlib import Path

ROS = """
image_width: 64
image_height: 48
camera_name: kinect
camera_matrix: {rows: 3, cols: 3, data: [52.0, 0.0, 32.0, 0.0, 53.0, 24.0, 0.0, 0.0, 1.0]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [0.1, -0.2, 0.0, 0.0, 0.3]}
"""
ORB_SLAM = """%YAML:1.0
Camera.fx: 517.306408
Camera.fy: 516.469215
Camera.cx: 318.643040
Camera.cy: 255.313989
Camera.k1: 0.262383
Camera.k2: -0.953104
Camera.p1: -0.005358
Camera.p2: 0.002628
Camera.k3: 1.163314
Camera.width: 640
Camera.height: 480
"""


def write(folder: Path, text: str) -> Path:
    path = folder / "camera.yaml"
    path.write_text(text)
    return path


def test_the_file_of_ros(tmp_path: Path) -> None:
    camera = read_calibration(write(tmp_path, ROS))
    assert (camera.width, camera.height) == (64, 48)
    assert camera.k == (52.0, 0.0, 32.0, 0.0, 53.0, 24.0, 0.0, 0.0, 1.0)
    assert camera.d == (0.1, -0.2, 0.0, 0.0, 0.3)
    assert camera.p == (52.0, 0.0, 32.0, 0.0, 0.0, 53.0, 24.0, 0.0, 0.0, 0.0, 1.0, 0.0)


def test_the_settings_of_orb_slam(tmp_path: Path) -> None:
    camera = read_calibration(write(tmp_path, ORB_SLAM))
    assert camera.k[0] == 517.306408
    assert camera.d == (0.262383, -0.953104, -0.005358, 0.002628, 1.163314)


@pytest.mark.parametrize(
    "text", ["a: 1", "[", "camera_matrix: 3", ROS.replace("52.0, 0.0, 32.0,", "52.0,"), "\t"]
)
def test_what_is_no_calibration_is_refused(tmp_path: Path, text: str) -> None:
    with pytest.raises(InputError):
        read_calibration(write(tmp_path, text))


def test_convert_writes_it(tmp_path: Path) -> None:
    api_path = tmp_path / "seq"
    with api.synthesize(frames=1, width=64, height=48) as sequence:
        api.convert(sequence, api_path, "tum")
    target = tmp_path / "x.mcap"
    arguments = ["convert", str(api_path), str(target), "--to", "mcap", "--camera", str(write(tmp_path, ROS))]
    assert run(arguments) == 0
    with api.open(target) as result:
        assert result.cameras["rgb"].k[0] == 52.0
        assert result.cameras["depth"].k[0] == 52.0


def test_a_camera_that_is_neither_name_nor_file_is_an_error(tmp_path: Path) -> None:
    with api.synthesize(frames=1, width=64, height=48) as sequence:
        api.convert(sequence, tmp_path / "seq", "tum")
    target = tmp_path / "x.mcap"
    assert run(["convert", str(tmp_path / "seq"), str(target), "--to", "mcap", "--camera", "fr9"]) == 4
    assert not target.exists()
