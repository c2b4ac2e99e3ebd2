# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""ROS 1 bags that we write, read by ROS itself, by Foxglove's library and by MRPT."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.interop.expected import check_messages, write
from tests.interop.programs import program, read_with_node, run, system_python
from tumtools.formats.rosbag1.compression import COMPRESSIONS
from tumtools.sources import open_source

pytestmark = [pytest.mark.interop, pytest.mark.real]

READER = Path(__file__).parent / "ros1" / "read_bag.py"
MD5_SUMS = {
    "sensor_msgs/Image": "060021388200f6f0f447d0fcd9c64743",
    "sensor_msgs/CompressedImage": "8f7a12909da2c9d3332d540a0977563f",
    "sensor_msgs/CameraInfo": "c9a58c1b0b154e0e6da7578cb991d214",
    "sensor_msgs/Imu": "6a62c6daae103f4ff57a132d6f95cec2",
    "tf2_msgs/TFMessage": "94810edda583a504dfda3829e70d7eec",
    "geometry_msgs/PoseStamped": "d3812c3cbc69362b77dc0b19b345f8f5",
    "std_msgs/String": "992ce8a1687cec8c8bd883ec73ca41d1",
}


@pytest.fixture(scope="module", params=COMPRESSIONS)
def bag(
    request: pytest.FixtureRequest, real_sequence: Path, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    target = tmp_path_factory.mktemp("bag") / f"{request.param}.bag"
    return write(real_sequence, target, "rosbag1", compression=request.param)


def read_with_ros(bag: Path) -> list[dict[str, object]]:
    python = system_python("rosbag", "sensor_msgs", "tf2_msgs")
    return [json.loads(line) for line in run(python, READER, bag).splitlines()]


def test_ros_reads_every_message(bag: Path, real_sequence: Path) -> None:
    messages = read_with_ros(bag)
    check_messages(real_sequence, messages)
    assert {str(m["type"]): m["md5sum"] for m in messages}.items() <= MD5_SUMS.items()
    assert messages[0]["topic"] == "/tumtools/sequence"
    assert all("callerid" not in str(message["header"]) for message in messages)


def test_rosbag_check_accepts_it(bag: Path) -> None:
    """It calls messages outdated whose definition has not the same comments, but must know all of them."""
    system_python("rosbag", "sensor_msgs", "tf2_msgs")
    assert "Bag is ready to be migrated" in run(program("rosbag"), "check", bag)


def test_foxglove_reads_every_message(bag: Path, real_sequence: Path) -> None:
    messages = read_with_node("rosbag1", bag)
    check_messages(real_sequence, messages)
    assert {m["type"]: m["md5sum"] for m in messages}.items() <= MD5_SUMS.items()


def test_ros_reads_png_and_poses(real_sequence: Path, tmp_path: Path) -> None:
    bag = write(real_sequence, tmp_path / "a.bag", "rosbag1", archive=True, layout="modern")
    messages = read_with_ros(bag)
    assert {str(m["type"]): m["md5sum"] for m in messages}.items() <= MD5_SUMS.items()
    kinds = {str(message["topic"]): message["type"] for message in messages}
    assert kinds["/camera/depth/image/compressed"] == "sensor_msgs/CompressedImage"
    assert kinds["/groundtruth/pose"] == "geometry_msgs/PoseStamped"


def test_mrpt_reads_the_accelerometer(bag: Path, tmp_path: Path) -> None:
    config = tmp_path / "config.yml"
    config.write_text("sensors:\n  imu:\n    type: 'CObservationIMU'\n    topic: '/imu'\n")
    rawlog = tmp_path / "out.rawlog"
    run(program("rosbag2rawlog"), "-f", "world", "-c", config, "-w", "-o", rawlog, bag)
    with open_source(bag) as ours, open_source(rawlog) as theirs:
        assert ours.accelerometer is not None
        assert theirs.accelerometer is not None
        assert theirs.accelerometer.values.tolist() == ours.accelerometer.values.tolist()
