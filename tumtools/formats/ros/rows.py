# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Signals to messages: all rows of a signal are messages of the same length, made many at a time."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.formats.ros import messages, serialise
from tumtools.formats.ros.recording import OutMessage
from tumtools.model.time import NANOSECONDS_PER_SECOND

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    import numpy.typing as npt

    from tumtools.formats.ros.codec import MessageType
    from tumtools.formats.ros.style import Style
    from tumtools.model.sequence import Sequence

    Columns = dict[str, npt.NDArray[np.generic]]

_ABSENT: Final = (-1.0,) + (0.0,) * 8
"""Covariance of what is not measured (`sensor_msgs/Imu`)."""
_BLOCK: Final = 4096
"""Rows that are serialised at a time."""
_ZERO: Final = {"x": 0.0, "y": 0.0, "z": 0.0}


@dataclass(frozen=True, slots=True, eq=False)
class Rows:
    """The messages of a signal, in order of their stamps.

    Attributes:
        channel: Index into the list of channels.
        stamps: int64[n], sorted.
        length: Of each message, in bytes.

    """

    channel: int
    stamps: npt.NDArray[np.int64]
    length: int
    _kind: MessageType = field(repr=False)
    _template: serialise.Message = field(repr=False)
    _columns: Columns = field(repr=False)

    def table(self, start: int, end: int) -> npt.NDArray[np.uint8]:
        """Serialise the rows from `start` to before `end`, shape [end - start, length]."""
        columns = {path: column[start:end] for path, column in self._columns.items()}
        return self._kind.encode_columns(self._template, columns)

    def messages(self) -> Iterator[OutMessage]:
        """Yield all rows."""
        for start in range(0, len(self.stamps), _BLOCK):
            stamps = self.stamps[start : start + _BLOCK].tolist()
            data = memoryview(self.table(start, start + len(stamps)).tobytes())
            for number, stamp in enumerate(stamps):
                part = data[number * self.length : (number + 1) * self.length]
                yield OutMessage(self.channel, stamp, (part,))


def signal_rows(sequence: Sequence, style: Style, numbers: Mapping[str, int]) -> Iterator[Rows]:
    """Yield the messages of each signal, in their order at equal stamps.

    Args:
        sequence: Whose signals.
        style: How to write.
        numbers: Index of the channel of each signal that is written.

    """
    if sequence.accelerometer is not None:
        stamps, values = sequence.accelerometer.stamps, sequence.accelerometer.values
        template = _imu(serialise.header(style.encoding, style.frame_id(sequence, "accelerometer")))
        columns = _xyz("linear_acceleration", values)
        yield _rows(style, numbers["accelerometer"], messages.IMU, template, stamps, columns)
    if sequence.groundtruth is not None:
        stamps, values = sequence.groundtruth.stamps, sequence.groundtruth.values
        layout = style.layout
        world = style.options.frame_ids.get("groundtruth") or sequence.info.frame_ids.get("groundtruth")
        header = serialise.header(style.encoding, world or layout.world)
        if "tf" in numbers:
            inner = {"translation": _ZERO, "rotation": _ZERO | {"w": 1.0}}
            template = {"transforms": [{"header": header, "child_frame_id": layout.body, "transform": inner}]}
            columns = _pose("transforms.0.transform.translation", "transforms.0.transform.rotation", values)
            yield _rows(style, numbers["tf"], messages.TF_MESSAGE, template, stamps, columns)
        if "groundtruth" in numbers:
            template = {"header": header, "pose": {"position": _ZERO, "orientation": _ZERO | {"w": 1.0}}}
            columns = _pose("pose.position", "pose.orientation", values)
            yield _rows(style, numbers["groundtruth"], messages.POSE_STAMPED, template, stamps, columns)


def _imu(header: serialise.Message) -> serialise.Message:
    return {
        "header": header,
        "orientation": _ZERO | {"w": 1.0},
        "orientation_covariance": _ABSENT,
        "angular_velocity": _ZERO,
        "angular_velocity_covariance": _ABSENT,
        "linear_acceleration": _ZERO,
        "linear_acceleration_covariance": (0.0,) * 9,
    }


def _xyz(path: str, values: npt.NDArray[np.float64]) -> Columns:
    return {f"{path}.{axis}": values[:, column] for column, axis in enumerate("xyz")}


def _pose(position: str, rotation: str, values: npt.NDArray[np.float64]) -> Columns:
    columns = _xyz(position, values)
    return columns | {f"{rotation}.{axis}": values[:, 3 + column] for column, axis in enumerate("xyzw")}


def _rows(
    style: Style,
    channel: int,
    kind: str,
    template: serialise.Message,
    stamps: npt.NDArray[np.int64],
    columns: Columns,
) -> Rows:
    seconds, nanoseconds = np.divmod(stamps, NANOSECONDS_PER_SECOND)
    path = "transforms.0.header" if kind == messages.TF_MESSAGE else "header"
    columns = columns | {f"{path}.stamp.sec": seconds, f"{path}.stamp.nanosec": nanoseconds}
    if style.encoding == "ros1":
        columns[f"{path}.seq"] = np.arange(len(stamps)) % 2**32
    order = np.argsort(stamps, kind="stable")
    columns = {name: column[order] for name, column in columns.items()}
    codec = messages.message_type(kind, style.encoding)
    return Rows(channel, stamps[order], len(codec.encode(template)), codec, template, columns)
