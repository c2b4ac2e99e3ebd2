# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What a ROS 1 bag is made of: connections, chunks, and where each message is."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.errors import UnsupportedInputError
from tumtools.formats.rosbag1.compression import COMPRESSIONS, MAX_CHUNK_SIZE, decompress
from tumtools.formats.rosbag1.records import Block, Op, Record, parse_fields

if TYPE_CHECKING:
    import numpy.typing as npt

    from tumtools.model.sequence import Loss

ENTRY: Final = np.dtype([("time", "<i8"), ("chunk", "<i4"), ("offset", "<u4"), ("connection", "<u4")])
"""Where a message is: nanoseconds, number of the chunk, offset in its uncompressed content."""


@dataclass(frozen=True, slots=True)
class Connection:
    """A publisher of a topic.

    Attributes:
        topic: Its topic.
        type: Message type in the spelling of ROS 1: `sensor_msgs/Image`.
        md5sum: Of the definition, as the publisher said.
        definition: Message definition with its dependencies.
        latched: Late subscribers get the last message.

    """

    topic: str
    type: str
    md5sum: str
    definition: str
    latched: bool = False


@dataclass(frozen=True, slots=True)
class Chunk:
    """A chunk: its place in the file, and where its content begins and ends there."""

    offset: int
    compression: str
    size: int
    start: int
    end: int

    def load(self, file: Block) -> Block:
        """Return the content, uncompressed: a view of the file where it is not compressed.

        Raises:
            InputError: The content is damaged.

        """
        file.passed(self.start, self.end - self.start)
        data = file.data[self.start : self.end]
        if self.compression != "none":
            try:
                data = memoryview(decompress(data, self.compression, self.size))
            except ValueError as error:
                raise file.damage(f"a chunk whose {error}", self.offset) from error
        return Block(file.path, data, self.offset)


@dataclass(frozen=True, slots=True)
class BagIndex:
    """What is in a bag.

    Attributes:
        connections: By number.
        chunks: In file order.
        entries: One `ENTRY` a message, in no particular order.
        warnings: No index, damage that was left out.
        left_out: What a salvage passes over.

    """

    connections: dict[int, Connection]
    chunks: list[Chunk]
    entries: npt.NDArray[np.void]
    warnings: tuple[str, ...] = ()
    left_out: tuple[Loss, ...] = ()

    def count(self) -> Counter[int]:
        """Return how many messages each connection has."""
        numbers, counts = np.unique(self.entries["connection"], return_counts=True)
        return Counter(dict(zip(numbers.tolist(), counts.tolist(), strict=True)))


def parse_connection(record: Record) -> tuple[int, Connection]:
    """Read a connection record: its number, and what is published."""
    header = parse_fields(record.block, record.data_start, record.data_end)
    described = record._replace(fields={b"latching": b"0", b"md5sum": b"", **header})
    connection = Connection(
        topic=record.text(b"topic"),
        type=described.text(b"type"),
        md5sum=described.text(b"md5sum"),
        definition=described.text(b"message_definition"),
        latched=described.text(b"latching") == "1",
    )
    return record.number(b"conn", 4), connection


def parse_chunk(record: Record) -> Chunk:
    """Read the header of a chunk.

    Raises:
        InputError: It is none, or promises a size that cannot be.

    """
    record.expect(Op.CHUNK, "a chunk")
    compression, size = record.text(b"compression"), record.number(b"size", 4)
    damage = record.block.damage
    if compression not in COMPRESSIONS:
        raise damage(
            f"chunk compression {compression!r}, expected one of {', '.join(COMPRESSIONS)}", record.offset
        )
    if compression == "none" and size != record.data_end - record.data_start:
        raise damage(f"an uncompressed chunk of size {size} with other bytes of data", record.offset)
    if compression != "none" and size > MAX_CHUNK_SIZE:
        raise UnsupportedInputError(
            f"a compressed chunk of {size} bytes, more than {MAX_CHUNK_SIZE}",
            path=record.block.path,
            location=f"offset {record.offset}",
            hint="run `rosbag decompress` on the bag",
        )
    return Chunk(record.offset, compression, size, record.data_start, record.data_end)
