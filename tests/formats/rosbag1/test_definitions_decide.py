# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The embedded definition says how a message is read; neither its md5 sum nor the name of its type does."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from tests.formats.rosbag1.samples import START, bag_bytes
from tumtools.formats.ros import messages
from tumtools.formats.ros.codec import MessageType
from tumtools.formats.ros.recording import OutMessage
from tumtools.formats.rosbag1.structure import Connection
from tumtools.sources import open_source

if TYPE_CHECKING:
    from pathlib import Path

ZERO = {"x": 0.0, "y": 0.0, "z": 0.0}
OTHER_IMU = messages.definition(messages.IMU, "ros1").replace(
    "geometry_msgs/Vector3 linear_acceleration\n",
    "byte[3] flags\ngeometry_msgs/Vector3 linear_acceleration\n",
)
"""As a release with another layout might have it; the markers of the published bags come in three."""


@pytest.mark.parametrize(
    "md5sum", [messages.ros1_md5_sum(messages.IMU), "f10fe193d6fac1bf68fad5d31da421a7", "*"]
)
def test_a_message_of_another_release_is_read_by_its_own_definition(tmp_path: Path, md5sum: str) -> None:
    message = {
        "header": {"seq": 0, "stamp": {"sec": START // 10**9, "nanosec": START % 10**9}, "frame_id": "imu"},
        "orientation": ZERO | {"w": 1.0},
        "orientation_covariance": (0.0,) * 9,
        "angular_velocity": ZERO,
        "angular_velocity_covariance": (0.0,) * 9,
        "flags": (1, 2, 3),
        "linear_acceleration": {"x": -0.083818, "y": 7.244229, "z": -6.657506},
        "linear_acceleration_covariance": (0.0,) * 9,
    }
    data = MessageType(OTHER_IMU, messages.IMU, "ros1").encode(message)
    connection = Connection("/imu", "sensor_msgs/Imu", md5sum, OTHER_IMU, latched=False)
    path = tmp_path / "x.bag"
    path.write_bytes(bag_bytes([OutMessage(0, START, (data,))], connections=[connection]))
    with open_source(path) as sequence:
        assert sequence.accelerometer is not None
        assert sequence.accelerometer.stamps.tolist() == [START]
        assert sequence.accelerometer.values.tolist() == [[-0.083818, 7.244229, -6.657506]]
