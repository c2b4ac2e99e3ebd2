# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Read small signals, and the stamps of large ones, in a single pass over a recording.

Messages are copied and decoded in batches: a view would keep a whole chunk of the recording in memory.
"""

from __future__ import annotations

import struct
from collections import Counter
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.errors import InputError
from tumtools.formats.ros import signals
from tumtools.formats.ros.besides import Lateness, beside_accelerations, beside_poses, lateness
from tumtools.formats.ros.layouts import TF_STATIC_TOPIC
from tumtools.formats.ros.tf import TransformTree
from tumtools.model.sequence import IMAGE_STREAMS
from tumtools.model.signals import Accelerometer, Trajectory
from tumtools.model.time import join_stamp

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from contextlib import AbstractContextManager

    import numpy.typing as npt

    from tumtools.formats.ros.codec import Columns, MessageType
    from tumtools.formats.ros.recording import Channel, RawMessage, Recording
    from tumtools.formats.ros.topics import Resolution

_BATCH: Final = 2048
_STAMP_OFFSET: Final = 4
"""Of the header's stamp: behind the representation in CDR, behind the sequence number in ROS 1."""
_BEHIND_STAMP: Final = _STAMP_OFFSET + 8
_STAMPS: Final = {"cdr": struct.Struct("<iI"), "ros1": struct.Struct("<II")}
_BIG_ENDIAN_STAMP: Final = struct.Struct(">iI")


class Collector:
    """Takes the messages of one channel in order of log time.

    Args:
        kind: Decodes them.
        take: Called with decoded messages; their `rows` count all messages of the channel.

    Attributes:
        frame_id: Coordinate frame of the first message.
        frames: How many messages name each coordinate frame.
        besides: What messages say beside what is collected, and how many do.
        late: How messages were logged at other times than their stamps say.

    """

    def __init__(self, kind: MessageType, take: Callable[[Columns], None]) -> None:
        self._kind = kind
        self._take = take
        self._waiting: list[memoryview] = []
        self._logged: list[int] = []
        self._done = 0
        self._first = -1
        self.frame_id = ""
        self.frames: Counter[str] = Counter()
        self.besides: Counter[str] = Counter()
        self.late = Lateness()

    def add(self, message: RawMessage) -> None:
        """Take a message."""
        self._waiting.append(memoryview(bytes(message.data)))
        self._logged.append(message.log_time)
        if len(self._waiting) >= _BATCH:
            self.flush()

    def flush(self) -> None:
        """Decode what waits.

        Raises:
            InputError: A message does not fit its definition.

        """
        logged = np.array(self._logged, np.int64)
        for part in self._kind.columns(self._waiting):
            if (stamps := signals.first_stamps(part)) is not None:
                self.late += lateness(logged[part.rows], stamps)
            self._take(replace(part, rows=part.rows + self._done))
        self._done += len(self._waiting)
        self._waiting.clear()
        self._logged.clear()

    def _note_frame(self, part: Columns, frame_id: str) -> None:
        self.frames[frame_id] += len(part.rows)
        if self._first < 0 or part.rows[0] < self._first:
            self._first, self.frame_id = int(part.rows[0]), frame_id

    @property
    def other_frames(self) -> int:
        """Messages whose coordinate frame is not that of the first."""
        return self.frames.total() - self.frames[self.frame_id]


class AccelerometerCollector(Collector):
    """Collects accelerations."""

    def __init__(self, kind: MessageType) -> None:
        super().__init__(kind, self._add)
        self._parts: list[tuple[npt.NDArray[np.intp], Accelerometer]] = []

    def _add(self, part: Columns) -> None:
        self._parts.append((part.rows, signals.accelerations_in(part)))
        self._note_frame(part, part.texts.get("header.frame_id", ""))
        self.besides += beside_accelerations(part)

    def result(self) -> Accelerometer:
        """Return all rows."""
        self.flush()
        order = _order([rows for rows, _ in self._parts])
        parts = [Accelerometer.empty(), *(part for _, part in self._parts)]
        stamps, values = (np.concatenate([getattr(p, name) for p in parts]) for name in ("stamps", "values"))
        return Accelerometer(stamps, values).take(order)


class PoseCollector(Collector):
    """Collects poses of messages with one pose each, or of the transforms to some frames."""

    def __init__(self, kind: MessageType, bodies: frozenset[str] = frozenset()) -> None:
        super().__init__(kind, self._add)
        self._bodies = bodies
        self._parts: list[tuple[npt.NDArray[np.intp], Trajectory]] = []

    def _add(self, part: Columns) -> None:
        if self._kind.name in signals.POSE_PATHS:
            found = [(part.texts.get("header.frame_id", ""), signals.poses_in(self._kind.name, part))]
            self.besides += beside_poses(part)
        else:
            triples = signals.transforms_in(part)
            found = [(parent, poses) for parent, child, poses in triples if child in self._bodies]
        for frame_id, poses in found:
            self._note_frame(part, frame_id)
            self._parts.append((part.rows, poses))

    def result(self) -> Trajectory:
        """Return all rows."""
        self.flush()
        order = _order([rows for rows, _ in self._parts])
        parts = [Trajectory.empty(), *(part for _, part in self._parts)]
        names = ("stamps", "positions", "quaternions")
        return Trajectory(*(np.concatenate([getattr(part, name) for part in parts]) for name in names)).take(
            order
        )


def _order(rows: list[npt.NDArray[np.intp]]) -> npt.NDArray[np.intp]:
    """Return in which order the rows of all parts came."""
    return np.argsort(np.concatenate([np.empty(0, np.intp), *rows]), kind="stable")


class TransformCollector(Collector):
    """Collects transforms into a tree that several channels may share."""

    def __init__(self, kind: MessageType, tree: TransformTree) -> None:
        super().__init__(kind, tree.add)


Times = tuple["npt.NDArray[np.int64]", "npt.NDArray[np.int64]"]
"""Log times and header stamps of the messages of an image stream, in order of log time."""


@dataclass(slots=True)
class Gathered:
    """What one pass over a recording gives.

    Attributes:
        accelerometer: None if there is no channel for it.
        poses: Ground truth of a channel with poses, or of our own transforms; None if there is none.
        frame_ids: Signal -> coordinate frame of its first message.
        tree: Transforms that the ground truth of a foreign recording is composed from.
        times: Image stream -> log times and header stamps, of foreign recordings.
        other_frames: Stream -> messages whose frame id is not that of the first.
        late: Stream, or topic of transforms -> messages logged at other times than their stamps say.
        other_cameras: Image stream -> messages of CameraInfo that differ from the first, if there are any.
        besides: Topic and what its messages say beside the stream -> how many do.

    """

    accelerometer: Accelerometer | None = None
    poses: Trajectory | None = None
    frame_ids: dict[str, str] = field(default_factory=dict)
    tree: TransformTree = field(default_factory=TransformTree)
    times: dict[str, Times] = field(default_factory=dict)
    other_frames: dict[str, int] = field(default_factory=dict)
    late: dict[str, Lateness] = field(default_factory=dict)
    other_cameras: dict[str, int] = field(default_factory=dict)
    besides: Counter[tuple[str, str]] = field(default_factory=Counter)


class _StampCollector:
    """Collects log times and header stamps.

    Attributes:
        other_frames: Messages whose frame id is not that of the first.

    """

    def __init__(self) -> None:
        self._found: list[tuple[int, int]] = []
        self._frame: bytes | None = None
        self.other_frames = 0

    def add(self, message: RawMessage) -> None:
        self._found.append((message.log_time, header_stamp(message)))
        frame = _frame_id(message)
        self._frame = frame if self._frame is None else self._frame
        self.other_frames += frame != self._frame

    def flush(self) -> None:
        """Do nothing: nothing waits."""

    def result(self) -> Times:
        table = np.array(self._found, np.int64).reshape(-1, 2)
        return table[:, 0].copy(), table[:, 1].copy()


class _ConstantCollector:
    """Counts messages that differ from the first in more than their stamp.

    Attributes:
        others: How many do.

    """

    def __init__(self) -> None:
        self._first: bytes | None = None
        self.others = 0

    def add(self, message: RawMessage) -> None:
        rest = message.data[_BEHIND_STAMP:]
        if self._first is None:
            self._first = bytes(rest)
        self.others += rest != self._first

    def flush(self) -> None:
        """Do nothing: nothing waits."""


_AnyCollector = Collector | _StampCollector | _ConstantCollector


def _frame_id(message: RawMessage) -> bytes:
    """Return the header's frame id, which follows its stamp in both encodings, without decoding the rest."""
    start = _BEHIND_STAMP
    order = ">" if message.channel.encoding == "cdr" and not message.data[1] & 1 else "<"
    if len(message.data) < start + 4:
        return b""
    (length,) = struct.unpack_from(order + "I", message.data, start)
    return bytes(message.data[start + 4 : start + 4 + length])


def gather(
    recording: Recording,
    resolution: Resolution,
    type_of: Callable[[Channel], MessageType],
    named: Callable[[Channel, int | None], AbstractContextManager[None]],
    *,
    bodies: frozenset[str],
    stamps: bool,
) -> Gathered:
    """Read the signals, and of images the header stamps and the constancy of their CameraInfo if wanted.

    Args:
        recording: Is read once.
        resolution: Which channel is what.
        type_of: Gives the codec of a channel.
        named: Puts the channel and the log time into errors.
        bodies: Frames whose own transforms are the ground truth.
        stamps: Whether header stamps and calibrations of images are looked at.

    Raises:
        InputError: A message does not fit its definition.

    """
    result = Gathered()
    collectors = _collectors(resolution, type_of, result.tree, bodies)
    if stamps:
        images = {resolution.channels[stream] for stream in IMAGE_STREAMS if stream in resolution.channels}
        collectors |= {channel.id: _StampCollector() for channel in images}
        collectors |= {channel.id: _ConstantCollector() for channel in resolution.infos.values()}
    wanted = [channel for channel in recording.channels if channel.id in collectors]
    for message in recording.messages(wanted):
        try:
            collectors[message.channel.id].add(message)
        except InputError:
            with named(message.channel, message.log_time):
                raise
    for channel in wanted:
        with named(channel, None):
            collectors[channel.id].flush()
    _take_results(result, resolution, collectors)
    return result


def _take_results(result: Gathered, resolution: Resolution, collectors: Mapping[int, _AnyCollector]) -> None:
    for stream, channel in resolution.channels.items():
        collector = collectors.get(channel.id)
        if isinstance(collector, _StampCollector):
            result.times[stream] = collector.result()
            result.late[stream] = lateness(*result.times[stream])
            result.other_frames[stream] = collector.other_frames
        elif isinstance(collector, AccelerometerCollector):
            result.accelerometer = collector.result()
        elif isinstance(collector, PoseCollector):
            result.poses = collector.result()
        if isinstance(collector, (AccelerometerCollector, PoseCollector)):
            result.frame_ids[stream] = collector.frame_id
            result.other_frames[stream] = collector.other_frames
            result.late[stream] = collector.late
            result.besides.update({(channel.topic, what): n for what, n in collector.besides.items()})
    for channel in resolution.transforms:
        collector = collectors.get(channel.id)
        if isinstance(collector, TransformCollector) and channel.topic != TF_STATIC_TOPIC:
            result.late[channel.topic] = collector.late  # stamps of what is static say nothing
    for stream, channel in resolution.infos.items():
        collector = collectors.get(channel.id)
        if isinstance(collector, _ConstantCollector) and collector.others:
            result.other_cameras[stream] = collector.others


def _collectors(
    resolution: Resolution,
    type_of: Callable[[Channel], MessageType],
    tree: TransformTree,
    bodies: frozenset[str],
) -> dict[int, _AnyCollector]:
    """Return what takes the messages of the signals, by channel."""
    channels = resolution.channels
    result: dict[int, _AnyCollector] = {
        channel.id: TransformCollector(type_of(channel), tree) for channel in resolution.transforms
    }
    if "accelerometer" in channels:
        result[channels["accelerometer"].id] = AccelerometerCollector(type_of(channels["accelerometer"]))
    if "groundtruth" in channels and not resolution.transforms:
        result[channels["groundtruth"].id] = PoseCollector(type_of(channels["groundtruth"]), bodies)
    return result


def header_stamp(message: RawMessage) -> int:
    """Read the header's stamp without decoding the message.

    Raises:
        InputError: The message is too short.

    """
    data = message.data
    if len(data) < _BEHIND_STAMP:
        raise InputError("a message that is too short for a header")
    kind = _STAMPS[message.channel.encoding]
    if message.channel.encoding == "cdr" and not data[1] & 1:
        kind = _BIG_ENDIAN_STAMP
    return join_stamp(*kind.unpack_from(data, _STAMP_OFFSET))
