# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Messages of small signals to columns, and calibrations."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.errors import InputError
from tumtools.formats.ros import messages
from tumtools.model.camera import CameraInfo
from tumtools.model.signals import Accelerometer, Trajectory
from tumtools.model.time import NANOSECONDS_PER_SECOND

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy.typing as npt

    from tumtools.formats.ros.codec import Columns, Message, MessageType

POSE_PATHS: Final = {
    messages.POSE_STAMPED: ("pose.position", "pose.orientation"),
    "geometry_msgs/msg/PoseWithCovarianceStamped": ("pose.pose.position", "pose.pose.orientation"),
    "geometry_msgs/msg/TransformStamped": ("transform.translation", "transform.rotation"),
    "nav_msgs/msg/Odometry": ("pose.pose.position", "pose.pose.orientation"),
}
"""Messages that hold one pose -> where."""


def accelerometer(kind: MessageType, data: Sequence[memoryview]) -> Accelerometer:
    """Decode sensor_msgs/Imu messages, in the order given.

    Raises:
        InputError: A message does not fit its definition.

    """
    stamps, values = np.empty(len(data), np.int64), np.empty((len(data), 3))
    for part in kind.columns(data):
        stamps[part.rows] = stamps_of(part, "header")
        values[part.rows] = _columns(part, "linear_acceleration", "xyz")
    return Accelerometer(stamps, values)


def poses(kind: MessageType, data: Sequence[memoryview]) -> tuple[Trajectory, str]:
    """Decode messages that hold one pose each; return the frame id of the first, too.

    Raises:
        InputError: A message does not fit its definition.

    """
    position, rotation = POSE_PATHS[kind.name]
    stamps, values = np.empty(len(data), np.int64), np.empty((len(data), 7))
    frame_id = ""
    for part in kind.columns(data):
        stamps[part.rows] = stamps_of(part, "header")
        values[part.rows, :3] = _columns(part, position, "xyz")
        values[part.rows, 3:] = _columns(part, rotation, "xyzw")
        if 0 in part.rows:
            frame_id = part.texts.get("header.frame_id", "")
    return Trajectory(stamps, values[:, :3].copy(), values[:, 3:].copy()), frame_id


def transforms(kind: MessageType, data: Sequence[memoryview], parent: str, child: str) -> Trajectory:
    """Decode the transforms from one frame to another out of tf messages, in the order given."""
    numbers: list[npt.NDArray[np.intp]] = [np.empty(0, np.intp)]
    stamps: list[npt.NDArray[np.int64]] = [np.empty(0, np.int64)]
    values: list[npt.NDArray[np.float64]] = [np.empty((0, 7))]
    for part in kind.columns(data):
        for path in (path for path in part.texts if path.endswith(".child_frame_id")):
            prefix = path.removesuffix(".child_frame_id")
            if part.texts[path] != child or part.texts.get(f"{prefix}.header.frame_id") != parent:
                continue
            numbers.append(part.rows)
            stamps.append(stamps_of(part, f"{prefix}.header"))
            translation = _columns(part, f"{prefix}.transform.translation", "xyz")
            rotation = _columns(part, f"{prefix}.transform.rotation", "xyzw")
            values.append(np.concatenate([translation, rotation], axis=1))
    order = np.argsort(np.concatenate(numbers), kind="stable")
    table = np.concatenate(values)[order]
    return Trajectory(np.concatenate(stamps)[order], table[:, :3].copy(), table[:, 3:].copy())


def stamps_of(part: Columns, header: str) -> npt.NDArray[np.int64]:
    """Return header stamps in nanoseconds, shape [n].

    Raises:
        InputError: There is no header.

    """
    try:
        seconds = part.numbers[f"{header}.stamp.sec"].astype(np.int64)
        return seconds * NANOSECONDS_PER_SECOND + part.numbers[f"{header}.stamp.nanosec"].astype(np.int64)
    except KeyError:
        raise InputError("a message without a header stamp") from None


def _columns(part: Columns, path: str, axes: str) -> npt.NDArray[np.float64]:
    try:
        return np.stack([part.numbers[f"{path}.{axis}"].astype(np.float64) for axis in axes], axis=1)
    except KeyError:
        raise InputError(f"a message without {path}") from None


def camera_info(message: Message) -> CameraInfo:
    """Return the calibration of a sensor_msgs/CameraInfo message, in either spelling of its fields.

    Raises:
        InputError: A field is missing.

    """

    def numbers(name: str) -> tuple[float, ...]:
        value = message.get(name, message.get(name.upper()))
        if not isinstance(value, np.ndarray):
            raise InputError(f"a calibration without {name}")
        return tuple(value.tolist())

    width, height = message.get("width"), message.get("height")
    if not isinstance(width, int) or not isinstance(height, int):
        raise InputError("a calibration without width and height")
    return CameraInfo(
        width=width,
        height=height,
        k=numbers("k"),
        d=numbers("d"),
        r=numbers("r"),
        p=numbers("p"),
        distortion_model=str(message.get("distortion_model", "")),
    )
