# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""MCAP files that no writer at hand makes, put together record by record."""

from __future__ import annotations

import struct
from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from tests.formats.mcap.foreign import ONE, ZERO
from tumtools.formats.mcap.records import (
    CHUNK_HEADER,
    INDEX_ENTRY,
    MAGIC,
    MESSAGE_HEADER,
    Op,
    number_map,
    record,
    string,
    string_map,
)
from tumtools.formats.ros import messages

if TYPE_CHECKING:
    from pathlib import Path

IMU: Final = ("sensor_msgs/msg/Imu", "ros2msg", messages.definition(messages.IMU, "cdr"))
"""Name, encoding and definition of a schema."""


class One(NamedTuple):
    """A message; its acceleration tells which one it is."""

    channel: int
    time: int
    x: float

    def record(self) -> bytes:
        none, (seconds, nanoseconds) = [0.0] * 9, divmod(self.time, 10**9)
        header = {"stamp": {"sec": seconds, "nanosec": nanoseconds}, "frame_id": "imu"}
        data = messages.message_type(messages.IMU, "cdr").encode(
            {
                "header": header, "orientation": ONE, "orientation_covariance": [-1.0, *none[1:]],
                "angular_velocity": ZERO, "angular_velocity_covariance": [-1.0, *none[1:]],
                "linear_acceleration": ZERO | {"x": self.x}, "linear_acceleration_covariance": none,
            }
        )  # fmt: skip
        return record(Op.MESSAGE, MESSAGE_HEADER.pack(self.channel, 0, self.time, self.time), data)


@dataclass(frozen=True)
class ByHand:
    """A file, and what its writer leaves out.

    Attributes:
        parts: Messages, and lists of messages, which are chunks.
        channels: Number -> schema and topic.
        schemas: Number -> name, encoding and definition.
        counted: Messages of each channel by the statistics; None for those that are there.
        by_channel: Whether the statistics count by channel.
        chunk_index: How many chunks the summary knows, the last ones first; None for all.
        message_index: Whether chunks are indexed.
        summary: Whether there is one.
        repeated: Channels that the summary repeats; None for all.
        extra: Entries of channels.

    """

    parts: list[One | list[One]]
    channels: dict[int, tuple[int, str]] = field(default_factory=lambda: {1: (1, "/imu")})
    schemas: dict[int, tuple[str, str, str]] = field(default_factory=lambda: {1: IMU})
    counted: dict[int, int] | None = None
    by_channel: bool = True
    chunk_index: int | None = None
    message_index: bool = True
    summary: bool = True
    repeated: frozenset[int] | None = None
    extra: dict[int, dict[str, str]] = field(default_factory=dict)

    def write(self, path: Path) -> Path:
        file = bytearray(MAGIC + record(Op.HEADER, string("ros2"), string("by hand")))
        file += b"".join(self._described(frozenset(self.channels)))
        indexes = []
        for part in self.parts:
            if isinstance(part, One):
                file += part.record()
            else:
                indexes.append(self._add_chunk(file, part))
        file += record(Op.DATA_END, bytes(4))
        start = len(file)
        if self.summary:
            repeated = frozenset(self.channels) if self.repeated is None else self.repeated
            kept = indexes[::-1][: self.chunk_index]
            file += b"".join([*self._described(repeated), *kept, self._statistics(len(indexes))])
        file += record(Op.FOOTER, struct.pack("<QQI", start if self.summary else 0, 0, 0)) + MAGIC
        path.write_bytes(file)
        return path

    def _described(self, channels: frozenset[int]) -> list[bytes]:
        return [
            *(
                record(Op.SCHEMA, struct.pack("<H", number), *map(string, texts))
                for number, texts in self.schemas.items()
            ),
            *(
                record(Op.CHANNEL, struct.pack("<HH", number, schema), string(topic), string("cdr"),
                       string_map(self.extra.get(number, {})))
                for number, (schema, topic) in self.channels.items()
                if number in channels
            ),
        ]  # fmt: skip

    def _add_chunk(self, file: bytearray, part: list[One]) -> bytes:
        """Add a chunk and its index; return the entry of the summary."""
        body, entries = b"", {}
        for one in part:
            entries.setdefault(one.channel, []).append(INDEX_ENTRY.pack(one.time, len(body)))
            body += one.record()
        times = [one.time for one in part]
        place, ends = len(file), (min(times), max(times))
        head = CHUNK_HEADER.pack(*ends, len(body), 0) + string("")
        file += record(Op.CHUNK, head, struct.pack("<Q", len(body)), body)
        end, offsets = len(file), {}
        for channel, packed in entries.items() if self.message_index else ():
            offsets[channel] = len(file)
            file += record(Op.MESSAGE_INDEX, struct.pack("<H", channel), string(b"".join(packed)))
        tail = struct.pack("<Q", len(file) - end) + string("") + struct.pack("<QQ", len(body), len(body))
        head = struct.pack("<QQQQ", *ends, place, end - place)
        return record(Op.CHUNK_INDEX, head, number_map(offsets), tail)

    def _statistics(self, chunks: int) -> bytes:
        found = Counter(one.channel for one in self.messages())
        counts = dict(found) if self.counted is None else self.counted
        times = [one.time for one in self.messages()]
        sizes = (sum(counts.values()), len(self.schemas), len(self.channels), 0, 0, chunks)
        numbers = struct.pack("<QHIIIIQQ", *sizes, min(times, default=0), max(times, default=0))
        return record(Op.STATISTICS, numbers, number_map(counts if self.by_channel else {}))

    def messages(self) -> list[One]:
        """Return all messages in the order of the file."""
        return [one for part in self.parts for one in ([part] if isinstance(part, One) else part)]


def in_order(file: ByHand) -> list[tuple[int, float]]:
    """Return time and acceleration of all messages in order of log time and place in the file."""
    return [(one.time, one.x) for one in sorted(file.messages(), key=lambda one: one.time)]


def value_of(data: bytes | memoryview) -> float:
    """Return the acceleration that a message says."""
    return float(np.frombuffer(data[-96:-88], "<f8")[0])
