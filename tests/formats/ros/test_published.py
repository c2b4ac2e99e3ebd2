# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A bag in the published layout becomes the files that the benchmark publishes beside it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from PIL import Image

from tests.formats.ros.published import matrix, write_published
from tumtools.convert import convert
from tumtools.errors import UsageError
from tumtools.formats.options import ReadOptions
from tumtools.model.time import parse_stamp
from tumtools.sources import open_source

if TYPE_CHECKING:
    from pathlib import Path


def rows(path: Path) -> dict[int, list[str]]:
    lines = [line.split() for line in path.read_text().splitlines() if not line.startswith("#")]
    return {parse_stamp(fields[0]): fields[1:] for fields in lines}


@pytest.mark.parametrize("encoding", ["rgb8", "bgr8"])
def test_published_bag_becomes_the_right_folder(tmp_path: Path, encoding: str) -> None:
    bag = tmp_path / "rgbd_dataset_freiburg1_desk.bag"
    content = write_published(bag, encoding)
    with open_source(bag) as sequence:
        assert sequence.info.camera == "fr1"
        report = convert(sequence, tmp_path / "out", "tum")

    out = tmp_path / "out"
    for stream, images in (("rgb", content.rgb), ("depth", content.depth)):
        listed = rows(out / f"{stream}.txt")
        assert list(listed) == list(images)
        for (name,), pixels in zip(listed.values(), images.values(), strict=True):
            with Image.open(out / name) as picture:
                assert np.array_equal(np.asarray(picture), pixels)
    imu = rows(out / "accelerometer.txt")
    assert list(imu) == list(content.imu)
    assert [tuple(map(float, row)) for row in imu.values()] == list(content.imu.values())
    assert {(loss.stream, loss.what, loss.count) for loss in report.losses} == {
        ("/cortex_marker_array", "messages not carried over", 39),
        ("groundtruth", "transforms not carried over", 8),  # to the frames of depth
        ("rgb", "calibration", 1),
        ("depth", "calibration", 1),
    }


def test_ground_truth_is_the_composed_chain(tmp_path: Path) -> None:
    content = write_published(tmp_path / "a.bag", frames=30)
    with open_source(tmp_path / "a.bag") as sequence:
        convert(sequence, tmp_path / "out", "tum")

    found = rows(tmp_path / "out" / "groundtruth.txt")
    assert list(found) == list(content.poses)
    values = np.array([list(map(float, row)) for row in found.values()])
    matrices = np.array([matrix(row[:3], row[3:]) for row in values])
    assert np.abs(matrices - np.array(list(content.poses.values()))).max() < 1e-6
    assert np.abs(np.linalg.norm(values[:, 3:], axis=1) - 1).max() < 1e-9


def test_frames_of_the_ground_truth_can_be_chosen(tmp_path: Path) -> None:
    write_published(tmp_path / "a.bag")
    options = ReadOptions(topics={"groundtruth": "/tf:/world.kinect"})
    with open_source(tmp_path / "a.bag", options) as sequence:
        assert sequence.groundtruth is not None
        assert sequence.groundtruth.positions[0].tolist() == [2.3, 0.0, 1.5]

    with pytest.raises(UsageError, match="no transforms lead") as error:
        open_source(tmp_path / "a.bag", ReadOptions(topics={"groundtruth": "/tf:world.robot"}))
    assert "openni_rgb_optical_frame" in str(error.value)


def test_bag_goes_through_every_container_unchanged(tmp_path: Path) -> None:
    bag = tmp_path / "rgbd_dataset_freiburg1_desk.bag"
    write_published(bag)
    source = bag
    for target in ("rosbag2", "mcap", "rosbag1", "tum"):
        path = tmp_path / target
        with open_source(source) as sequence:
            report = convert(sequence, path, target)
        if target != "tum":
            assert {loss.stream for loss in report.losses} <= {"/cortex_marker_array", "groundtruth"}
        source = path
    with open_source(bag) as sequence:
        convert(sequence, tmp_path / "direct", "tum")
    for file in sorted((tmp_path / "direct").rglob("*.*")):
        other = tmp_path / "tum" / file.relative_to(tmp_path / "direct")
        assert file.read_bytes() == other.read_bytes()
