# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Bags as the benchmark publishes them, written with somebody else's library.

bz2 chunks; frame ids with a slash; ground truth as a chain of transforms at 100 Hz with OpenNI's broadcasters
at 10 Hz; depth as 32FC1 with NaN; one camera_info more than images; raw markers of the motion capture.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from rosbags.rosbag1 import Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

MS = 1_000_000
START = 1_311_868_164_363_181_123
WIDTH, HEIGHT = 32, 24


STORE = get_typestore(Stores.ROS1_NOETIC)
STORE.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms\n", "tf/msg/tfMessage"))
T = STORE.types
Random = np.random.Generator


@dataclass
class Published:
    """What is in the bag."""

    rgb: dict[int, np.ndarray] = field(default_factory=dict)
    depth: dict[int, np.ndarray] = field(default_factory=dict)
    imu: dict[int, tuple[float, ...]] = field(default_factory=dict)
    poses: dict[int, np.ndarray] = field(default_factory=dict)


def header(stamp: int, frame: str, seq: int = 0) -> object:
    time = T["builtin_interfaces/msg/Time"](stamp // 10**9, stamp % 10**9)
    return T["std_msgs/msg/Header"](seq, time, frame)


def _rotation(vector: np.ndarray) -> np.ndarray:
    """Return the quaternion x y z w of a rotation vector."""
    angle = float(np.linalg.norm(vector))
    return np.append(np.sin(angle / 2) * vector / angle, np.cos(angle / 2))


def matrix(position: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Return the 4x4 matrix of a pose."""
    x, y, z, w = q / np.linalg.norm(q)
    result = np.eye(4)
    result[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    result[:3, 3] = position
    return result


def _transform(stamp: int, parent: str, child: str, position: np.ndarray, q: np.ndarray) -> object:
    return T["geometry_msgs/msg/TransformStamped"](
        header(stamp, parent),
        child,
        T["geometry_msgs/msg/Transform"](
            T["geometry_msgs/msg/Vector3"](*position), T["geometry_msgs/msg/Quaternion"](*q)
        ),
    )


CALIBRATION = (np.array([-0.012, 0.031, 0.009]), _rotation(np.array([0.02, -0.01, 0.03])))
RGB_FRAME = (np.array([0.0, -0.045, 0.0]), np.array([0.0, 0.0, 0.0, 1.0]))
OPTICAL = (np.zeros(3), np.array([0.5, -0.5, 0.5, -0.5]))
DEPTH_FRAME = (np.array([0.0, -0.02, 0.0]), np.array([0.0, 0.0, 0.0, 1.0]))


def _pose(number: int) -> tuple[np.ndarray, np.ndarray]:
    phase = number / 20
    position = np.array([1.3 + np.cos(phase), -0.6 * np.sin(phase), 1.5 + 0.1 * phase])
    return position, _rotation(np.array([0.3 * np.sin(phase), 0.8 * phase, 0.2]))


def write_published(path: Path, encoding: str = "rgb8", frames: int = 12) -> Published:
    """Write a bag; return what is in it."""
    content = Published()
    random = np.random.default_rng(0)
    duration = frames * 33 * MS
    messages = [
        *_images(content, random, encoding, frames),
        *_imu(content, random, duration),
        *_motion_capture(content, duration),
        *_broadcasters(duration),
    ]
    write_messages(path, messages)
    return content


Message = tuple[int, str, str, object]
"""Stamp, topic, type, message."""


def _images(content: Published, random: np.random.Generator, encoding: str, frames: int) -> Iterator[Message]:
    frame, kind = "/openni_rgb_optical_frame", "sensor_msgs/msg/Image"
    for i in range(frames + 1):
        stamp, later = START + i * 33_300_017, START + i * 33_300_017 + 11 * MS
        yield stamp, "/camera/rgb/camera_info", "sensor_msgs/msg/CameraInfo", _info(stamp, frame)
        yield later, "/camera/depth/camera_info", "sensor_msgs/msg/CameraInfo", _info(later, frame)
        if i == frames:
            return
        pixels = random.integers(0, 256, (HEIGHT, WIDTH, 3), np.uint8)
        content.rgb[stamp] = pixels
        data = np.ascontiguousarray(pixels if encoding == "rgb8" else pixels[:, :, ::-1])
        image = _image(stamp, frame, encoding, data)
        yield stamp, "/camera/rgb/image_color", kind, image
        counts = random.integers(0, 65536, (HEIGHT, WIDTH), np.uint16)
        counts[random.random(counts.shape) < 0.2] = 0
        content.depth[later] = counts
        metres = (counts / 5000.0).astype(np.float32)
        metres[counts == 0] = np.nan
        yield later, "/camera/depth/image", kind, _image(later, frame, "32FC1", metres)


def _image(stamp: int, frame: str, encoding: str, data: np.ndarray) -> object:
    raw = data.reshape(-1).view(np.uint8)
    step = len(raw) // HEIGHT
    return T["sensor_msgs/msg/Image"](header(stamp, frame), HEIGHT, WIDTH, encoding, 0, step, raw)


def _info(stamp: int, frame: str) -> object:
    k = np.array([525.0, 0, 319.5, 0, 525.0, 239.5, 0, 0, 1])
    p = np.array([525.0, 0, 319.5, 0, 0, 525.0, 239.5, 0, 0, 0, 1, 0])
    roi = T["sensor_msgs/msg/RegionOfInterest"](0, 0, 0, 0, False)
    return T["sensor_msgs/msg/CameraInfo"](
        header(stamp, frame), HEIGHT, WIDTH, "plumb_bob", np.zeros(5), k, np.eye(3).ravel(), p, 0, 0, roi
    )


def _imu(content: Published, random: Random, duration: int) -> Iterator[Message]:
    vector, none = T["geometry_msgs/msg/Vector3"], np.zeros(9)
    nobody = T["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 0.0)
    for i in range(duration // (2 * MS)):
        stamp, values = START + i * 2 * MS + 345, tuple(random.normal(0, 3, 3).tolist())
        content.imu[stamp] = values
        message = T["sensor_msgs/msg/Imu"](
            header(stamp, "/imu"), nobody, none, vector(0.0, 0.0, 0.0), none, vector(*values), none
        )
        yield stamp, "/imu", "sensor_msgs/msg/Imu", message


def _tf(stamp: int, *transforms: object) -> Message:
    return stamp, "/tf", "tf/msg/tfMessage", T["tf/msg/tfMessage"](list(transforms))


def _motion_capture(content: Published, duration: int) -> Iterator[Message]:
    chain = matrix(*CALIBRATION) @ matrix(*RGB_FRAME) @ matrix(*OPTICAL)
    for i in range(duration // (10 * MS)):
        stamp = START + i * 10 * MS + 777
        transforms = [_transform(stamp, "/kinect", "/openni_camera", *CALIBRATION)]
        if i % 7 != 3:  # else fewer than three markers are seen, and there is no pose
            transforms.append(_transform(stamp, "/world", "/kinect", *_pose(i)))
            content.poses[stamp] = matrix(*_pose(i)) @ chain
        yield _tf(stamp, *transforms)
        yield stamp, "/cortex_marker_array", "visualization_msgs/msg/MarkerArray", _markers(stamp)


def _broadcasters(duration: int) -> Iterator[Message]:
    edges = (
        ("/openni_camera", "/openni_rgb_frame", RGB_FRAME),
        ("/openni_rgb_frame", "/openni_rgb_optical_frame", OPTICAL),
        ("/openni_camera", "/openni_depth_frame", DEPTH_FRAME),
        ("/openni_depth_frame", "/openni_depth_optical_frame", OPTICAL),
    )
    for i in range(duration // (100 * MS) + 1):
        for j, (parent, child, pose) in enumerate(edges):
            stamp = START + i * 100 * MS + 5 * MS + j * 13
            yield _tf(stamp, _transform(stamp, parent, child, *pose))


def _markers(stamp: int) -> object:
    point, quaternion = T["geometry_msgs/msg/Point"], T["geometry_msgs/msg/Quaternion"]
    white = T["std_msgs/msg/ColorRGBA"](1.0, 1.0, 1.0, 1.0)
    pose = T["geometry_msgs/msg/Pose"](point(0.0, 0.0, 0.0), quaternion(0.0, 0.0, 0.0, 1.0))
    scale, lifetime = (
        T["geometry_msgs/msg/Vector3"](0.05, 0.05, 0.05),
        T["builtin_interfaces/msg/Duration"](0, 0),
    )
    unseen = [point(float("nan"), float("nan"), float("nan"))]
    kind, head = T["visualization_msgs/msg/Marker"], header(stamp, "/mocap")
    marker = kind(head, "Kinect", 0, 7, 0, pose, scale, white, lifetime, False, unseen, [], "", "", False)
    return T["visualization_msgs/msg/MarkerArray"]([marker])


def write_messages(path: Path, messages: list[Message]) -> None:
    """Write in order of (stamp, topic), as the benchmark's own script does."""
    with_options = Writer(path)
    with_options.set_compression(Writer.CompressionFormat.BZ2)
    with with_options as writer:
        connections = {}
        for stamp, topic, kind, message in sorted(messages, key=lambda entry: entry[:2]):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=STORE)
            writer.write(connections[topic], stamp, STORE.serialize_ros1(message, kind))
