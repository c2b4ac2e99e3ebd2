# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What messages say and a sequence has no place for."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.formats.ros.layouts import TF_STATIC_TOPIC, TF_TOPIC
from tumtools.formats.ros.qos import beyond_ours
from tumtools.model.sequence import Loss
from tumtools.model.time import NANOSECONDS_PER_SECOND

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator

    import numpy.typing as npt

    from tumtools.formats.ros.codec import Columns, Message
    from tumtools.formats.ros.gather import Gathered
    from tumtools.formats.ros.recording import Channel, Recording
    from tumtools.formats.ros.topics import Resolution
    from tumtools.model.signals import Trajectory

_INERTIAL: Final = "inertial values besides acceleration"
_COVARIANCES: Final = "covariances"
_VELOCITIES: Final = "velocities"
_CHILD_FRAMES: Final = "child frame ids"
TRANSFORMS: Final = "transforms not carried over"
_WHY: Final = {
    _INERTIAL: "a sequence has no stream for it",
    _COVARIANCES: "a sequence has no place for uncertainties",
    _VELOCITIES: "a sequence has no stream for it",
    TRANSFORMS: "a sequence has one trajectory; these are of other frames",
    _CHILD_FRAMES: "the poses of a sequence are those of its colour camera",
}
_UNKNOWN: Final = -1.0
"""First number of a covariance whose values are not there (sensor_msgs/Imu)."""
_NO_ROTATION: Final = (0.0, 0.0, 0.0, 1.0)
_SHOWN: Final = 3
"""Profiles of a topic."""


def beside_the_streams(found: Gathered) -> Iterator[Loss]:
    """Yield what the messages of a recording say beside the streams that were read from them."""
    why = "a sequence has one coordinate frame for each stream, that of its first message"
    for stream, count in found.other_frames.items():
        if count:
            yield Loss(stream, "frame ids of single messages", count, why)
    why = "a sequence has one calibration for each image stream, that of its first message"
    for stream, count in found.other_cameras.items():
        yield Loss(stream, "calibrations that differ from the first", count, why)
    for (topic, what), count in found.besides.items():
        yield Loss(topic, what, count, _WHY[what])
    for stream, late in found.late.items():
        yield from late_losses(stream, late)


@dataclass(frozen=True, slots=True)
class Lateness:
    """How messages were logged at other times than their stamps say.

    Attributes:
        count: Messages that were.
        largest: By how many nanoseconds at most.

    """

    count: int = 0
    largest: int = 0

    def __add__(self, other: Lateness) -> Lateness:
        return Lateness(self.count + other.count, max(self.largest, other.largest))


def added_transforms(
    recording: Recording, used: Collection[Channel], groundtruth: Trajectory | None
) -> Iterator[Loss]:
    """Yield transforms that a recording of ours has besides those of its poses, which we wrote as well."""
    poses = 0 if groundtruth is None else len(groundtruth)
    for channel in recording.channels:
        if channel.topic == TF_TOPIC and channel not in used and (channel.count or 0) > poses:
            yield Loss(channel.topic, TRANSFORMS, (channel.count or 0) - poses, _WHY[TRANSFORMS])


def offers(resolution: Resolution, *, composed: bool) -> Iterator[Loss]:
    """Yield how the topics that were read were offered, where it is not how we write them.

    Args:
        resolution: Which channel is what.
        composed: Whether the ground truth was composed from the transforms.

    """
    read = [*resolution.channels.items(), *resolution.infos.items()]
    read += [("groundtruth", channel) for channel in resolution.transforms if composed]
    for stream, channel in dict.fromkeys(read):
        if channel.count == 0:
            continue
        # Transforms that do not change are latched in all of ROS, and say nothing by it.
        static = channel.topic.strip("/") == TF_STATIC_TOPIC.strip("/")
        if found := beyond_ours(channel.qos, latched=static):
            more = f" and {len(found) - _SHOWN} more profiles" if len(found) > _SHOWN else ""
            how = "; with ".join(found[:_SHOWN])
            why = f"{channel.topic} was offered with {how}{more}, and a sequence has no place for that"
            yield Loss(stream, "QoS profile not kept", len(found), why)
        if channel.encoding == "ros1" and channel.latched and not static:
            why = f"{channel.topic} was latched, and a sequence has no place for that"
            yield Loss(stream, "latching not kept", 1, why)


def late_losses(stream: str, late: Lateness) -> Iterator[Loss]:
    """Yield what is lost of the times at which messages were logged, if that is anything."""
    if late.count:
        why = "a sequence has the stamps of the headers, when something was measured"
        yield Loss(stream, "times of recording", late.count, why, late.largest / NANOSECONDS_PER_SECOND, "s")


def lateness(log_times: npt.NDArray[np.int64], stamps: npt.NDArray[np.int64]) -> Lateness:
    """Compare log times and header stamps, in nanoseconds; shape [n] each."""
    # A log time may be any number of 64 bits, so a difference may take 64 bits without a sign.
    apart = np.maximum(log_times, stamps).view(np.uint64) - np.minimum(log_times, stamps).view(np.uint64)
    return Lateness(int(np.count_nonzero(apart)), int(apart.max(initial=0)))


def beside_accelerations(part: Columns) -> Counter[str]:
    """Count the messages of sensor_msgs/Imu that say more than an acceleration."""
    turned = _known(part, "orientation_covariance") & _turned(part, "orientation")
    turning = _known(part, "angular_velocity_covariance") & _some(part, "angular_velocity", "xyz")
    names = ("orientation", "angular_velocity", "linear_acceleration")
    covariances = [_says(part, f"{name}_covariance") for name in names]
    return _counted({_INERTIAL: turned | turning, _COVARIANCES: np.logical_or.reduce(covariances)})


def beside_poses(part: Columns) -> Counter[str]:
    """Count the messages with one pose that say more than it."""
    moving = _some(part, "twist.twist.linear", "xyz") | _some(part, "twist.twist.angular", "xyz")
    return _counted(
        {
            _COVARIANCES: _says(part, "pose.covariance") | _says(part, "twist.covariance"),
            _VELOCITIES: moving,
            _CHILD_FRAMES: np.full(len(part.rows), bool(part.texts.get("child_frame_id"))),
        }
    )


def has_window(message: Message) -> bool:
    """Tell whether a sensor_msgs/CameraInfo is of a part of the sensor, of joined pixels, or rectified."""
    region = message.get("roi")
    part = region if isinstance(region, dict) else {}
    names = ("height", "width")
    size = tuple(part.get(name, 0) for name in names)
    whole = {(0, 0), tuple(message.get(name, 0) for name in names)}
    return (
        any(message.get(name, 0) not in {0, 1} for name in ("binning_x", "binning_y"))
        or any(part.get(name) for name in ("x_offset", "y_offset", "do_rectify"))
        or size not in whole
    )


def _counted(found: dict[str, npt.NDArray[np.bool_]]) -> Counter[str]:
    return Counter({what: count for what, rows in found.items() if (count := int(np.count_nonzero(rows)))})


def _known(part: Columns, covariance: str) -> npt.NDArray[np.bool_]:
    """Tell in which rows the values that a covariance belongs to are there."""
    numbers = part.numbers.get(covariance)
    known = np.ones(len(part.rows), bool)
    return known if numbers is None or numbers.ndim == 1 else numbers[:, 0] != _UNKNOWN


def _says(part: Columns, covariance: str) -> npt.NDArray[np.bool_]:
    """Tell in which rows a covariance says something."""
    numbers = part.numbers.get(covariance)
    if numbers is None or numbers.ndim == 1:
        return np.zeros(len(part.rows), bool)
    found: npt.NDArray[np.bool_] = _known(part, covariance) & _is_something(numbers).any(axis=1)
    return found


def _some(part: Columns, path: str, axes: str) -> npt.NDArray[np.bool_]:
    """Tell in which rows any of some numbers says something."""
    columns = [part.numbers[name] for axis in axes if (name := f"{path}.{axis}") in part.numbers]
    if not columns:
        return np.zeros(len(part.rows), bool)
    found: npt.NDArray[np.bool_] = np.logical_or.reduce([_is_something(column) for column in columns])
    return found


def _turned(part: Columns, path: str) -> npt.NDArray[np.bool_]:
    """Tell in which rows a rotation is neither empty nor none."""
    none = np.ones(len(part.rows), bool)
    for axis, value in zip("xyzw", _NO_ROTATION, strict=True):
        column = part.numbers.get(f"{path}.{axis}")
        none &= True if column is None else column == value
    return _some(part, path, "xyzw") & ~none


def _is_something(numbers: npt.NDArray[np.generic]) -> npt.NDArray[np.bool_]:
    """Tell which numbers are not 0; what is no number says nothing."""
    found: npt.NDArray[np.bool_] = (numbers != 0) & ~np.isnan(numbers.astype(np.float64, copy=False))
    return found
