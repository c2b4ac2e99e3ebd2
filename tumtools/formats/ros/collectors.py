# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Take messages of one channel: the rows of signals as columns, of large messages their stamps alone.

Messages are copied and decoded many at a time: a view would keep a whole chunk of the recording in memory.
"""

from __future__ import annotations

import struct
from abc import ABC, abstractmethod
from collections import Counter
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.errors import InputError
from tumtools.formats.ros import signals
from tumtools.formats.ros.batches import BATCH, BATCH_BYTES, Copies, tables
from tumtools.formats.ros.besides import TRANSFORMS, Lateness, beside_accelerations, beside_poses, lateness
from tumtools.model.signals import Accelerometer, Trajectory
from tumtools.model.time import join_stamp

if TYPE_CHECKING:
    import numpy.typing as npt

    from tumtools.formats.ros.batches import Batch
    from tumtools.formats.ros.codec import Columns, MessageType
    from tumtools.formats.ros.recording import RawMessage
    from tumtools.formats.ros.tf import TransformTree

_STAMP_OFFSET: Final = 4
"""Of the header's stamp: behind the representation in CDR, behind the sequence number in ROS 1."""
_BEHIND_STAMP: Final = _STAMP_OFFSET + 8
_STAMPS: Final = {"cdr": struct.Struct("<iI"), "ros1": struct.Struct("<II")}
_BIG_ENDIAN_STAMP: Final = struct.Struct(">iI")


class Collector(ABC):
    """Takes the messages of one channel in order of log time.

    Args:
        kind: Decodes them.

    Attributes:
        frame_id: Coordinate frame of the first message.
        frames: How many messages name each coordinate frame.
        besides: What messages say beside what is collected, and how many do.
        late: How messages were logged at other times than their stamps say.

    """

    def __init__(self, kind: MessageType) -> None:
        self._kind = kind
        self._copies: Copies | None = None
        self._waiting: dict[int, list[tuple[npt.NDArray[np.intp], npt.NDArray[np.uint8]]]] = {}
        self._log_times: list[npt.NDArray[np.int64]] = []
        self._nbytes = 0
        self._count = 0
        self._done = 0
        self._first = -1
        self.frame_id = ""
        self.frames: Counter[str] = Counter()
        self.besides: Counter[str] = Counter()
        self.late = Lateness()

    @abstractmethod
    def _take(self, part: Columns, log_times: npt.NDArray[np.int64]) -> None:
        """Take decoded messages; their `rows` count all messages of the channel."""

    def add(self, message: RawMessage) -> None:
        """Take a message; see `add_batch`."""
        if self._copies is None:
            self._copies = Copies(message.channel)
        self._copies.add(message)
        if self._copies.is_enough:
            self.add_batch(self._copies.take())

    def add_batch(self, batch: Batch) -> None:
        """Take many messages.

        Raises:
            InputError: A message does not fit its definition: one of these, or of those before them.

        """
        for rows, table in tables(batch.data, batch.starts, batch.lengths):
            self._waiting.setdefault(table.shape[1], []).append((self._count + rows, table))
            self._nbytes += table.size
        self._log_times.append(batch.log_times)
        self._count += len(batch.log_times)
        if self._count - self._done >= BATCH or self._nbytes >= BATCH_BYTES:
            self._decode()

    def flush(self) -> None:
        """Decode what waits.

        Raises:
            InputError: A message does not fit its definition.

        """
        if self._copies is not None:
            self.add_batch(self._copies.take())
        self._decode()

    def _decode(self) -> None:
        waiting, log_times = self._waiting, np.concatenate([np.empty(0, np.int64), *self._log_times])
        self._waiting, self._log_times, self._nbytes = {}, [], 0
        for parts in waiting.values():
            rows, table = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
            for part in self._kind.columns_of(rows, table):
                self._take(part, log_times[part.rows - self._done])
        self._done = self._count

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
        super().__init__(kind)
        self._parts: list[tuple[npt.NDArray[np.intp], Accelerometer]] = []

    def _take(self, part: Columns, log_times: npt.NDArray[np.int64]) -> None:
        found = signals.accelerations_in(part)
        self._parts.append((part.rows, found))
        self.late += lateness(log_times, found.stamps)
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
        super().__init__(kind)
        self._bodies = bodies
        self._parts: list[tuple[npt.NDArray[np.intp], Trajectory]] = []

    def _take(self, part: Columns, log_times: npt.NDArray[np.int64]) -> None:
        if self._kind.name in signals.POSE_PATHS:
            found = [(part.texts.get("header.frame_id", ""), signals.poses_in(self._kind.name, part))]
            self.besides += beside_poses(part)
        else:
            triples = list(signals.transforms_in(part))
            found = [(parent, poses) for parent, child, poses in triples if child in self._bodies]
            others = [poses for _, child, poses in triples if child not in self._bodies]
            self.besides += Counter({TRANSFORMS: len(part.rows) * len(others)} if others else {})
        for frame_id, poses in found:
            self._note_frame(part, frame_id)
            self._parts.append((part.rows, poses))
            self.late += lateness(log_times, poses.stamps)

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
        super().__init__(kind)
        self._tree = tree

    def _take(self, part: Columns, log_times: npt.NDArray[np.int64]) -> None:
        self._tree.add(part, log_times)


Times = tuple["npt.NDArray[np.int64]", "npt.NDArray[np.int64]"]
"""Log times and header stamps of the messages of an image stream, in order of log time."""


class StampCollector:
    """Collects log times and header stamps.

    Attributes:
        other_frames: Messages whose frame id is not that of the first.

    """

    def __init__(self) -> None:
        self._found: list[tuple[int, int]] = []
        self._frame: bytes | None = None
        self.other_frames = 0

    def add(self, message: RawMessage) -> None:
        """Take a message."""
        self._found.append((message.log_time, header_stamp(message)))
        frame = _frame_id(message)
        self._frame = frame if self._frame is None else self._frame
        self.other_frames += frame != self._frame

    def flush(self) -> None:
        """Do nothing: nothing waits."""

    def result(self) -> Times:
        """Return log times and header stamps of all messages."""
        table = np.array(self._found, np.int64).reshape(-1, 2)
        return table[:, 0].copy(), table[:, 1].copy()


class ConstantCollector:
    """Counts messages that differ from the first in more than their stamp.

    Attributes:
        others: How many do.

    """

    def __init__(self) -> None:
        self._first: bytes | None = None
        self.others = 0

    def add(self, message: RawMessage) -> None:
        """Take a message."""
        rest = message.data[_BEHIND_STAMP:]
        if self._first is None:
            self._first = bytes(rest)
        self.others += rest != self._first

    def flush(self) -> None:
        """Do nothing: nothing waits."""


def _frame_id(message: RawMessage) -> bytes:
    """Return the header's frame id, which follows its stamp in both encodings, without decoding the rest."""
    start = _BEHIND_STAMP
    order = ">" if message.channel.encoding == "cdr" and not message.data[1] & 1 else "<"
    if len(message.data) < start + 4:
        return b""
    (length,) = struct.unpack_from(order + "I", message.data, start)
    return bytes(message.data[start + 4 : start + 4 + length])


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
