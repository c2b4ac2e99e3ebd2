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
    from collections.abc import Iterator

    import numpy.typing as npt

    from tumtools.formats.ros.codec import Columns, Message

POSE_PATHS: Final = {
    messages.POSE_STAMPED: ("pose.position", "pose.orientation"),
    "geometry_msgs/msg/PoseWithCovarianceStamped": ("pose.pose.position", "pose.pose.orientation"),
    "geometry_msgs/msg/TransformStamped": ("transform.translation", "transform.rotation"),
    "nav_msgs/msg/Odometry": ("pose.pose.position", "pose.pose.orientation"),
}
"""Messages that hold one pose -> where."""


def accelerations_in(part: Columns) -> Accelerometer:
    """Return the rows of decoded sensor_msgs/Imu messages.

    Raises:
        InputError: They have no acceleration.

    """
    return Accelerometer(stamps_of(part, "header"), _columns(part, "linear_acceleration", "xyz"))


def poses_in(kind: str, part: Columns) -> Trajectory:
    """Return the rows of decoded messages of a type that holds one pose.

    Raises:
        InputError: They have no pose.

    """
    position, rotation = POSE_PATHS[kind]
    return Trajectory(
        stamps_of(part, "header"), _columns(part, position, "xyz"), _columns(part, rotation, "xyzw")
    )


def transforms_in(part: Columns) -> Iterator[tuple[str, str, Trajectory]]:
    """Yield parent frame, child frame and transforms of each place in tf messages of one layout.

    Raises:
        InputError: A message does not fit its definition.

    """
    for path in (path for path in part.texts if path.endswith(".child_frame_id")):
        prefix = path.removesuffix(".child_frame_id")
        translation = _columns(part, f"{prefix}.transform.translation", "xyz")
        rotation = _columns(part, f"{prefix}.transform.rotation", "xyzw")
        stamps = stamps_of(part, f"{prefix}.header")
        yield (
            part.texts[f"{prefix}.header.frame_id"],
            part.texts[path],
            Trajectory(stamps, translation, rotation),
        )


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
