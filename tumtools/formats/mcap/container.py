# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Write channels and messages into a MCAP file: chunks, indexes, summary, all CRCs.

Chunks are finished by several threads and written in order.
"""

from __future__ import annotations

import os
import struct
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from isal import isal_zlib

from tumtools import __version__
from tumtools.formats.mcap.chunks import Chunker
from tumtools.formats.mcap.records import (
    CHUNK_HEADER,
    FOOTER,
    INDEX_ENTRY,
    MAGIC,
    RECORD_HEADER,
    Op,
    number_map,
    record,
    string,
    string_map,
)
from tumtools.formats.metadata import DIGEST_RECORD, RECORD
from tumtools.formats.ros.messages import definition, ros1_name
from tumtools.formats.ros.qos import qos_profile
from tumtools.images.parallel import ordered_map

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence
    from pathlib import Path

    from tumtools.formats.mcap.chunks import Buffer, Chunk
    from tumtools.formats.options import Progress
    from tumtools.formats.ros.recording import MessageEncoding, OutChannel, OutMessage
    from tumtools.formats.ros.rows import Rows

_MAX_PARTS: Final = 1000
"""Buffers in one call of writev; POSIX allows 1024."""
_SCHEMA_ENCODINGS: Final[dict[MessageEncoding, str]] = {"cdr": "ros2msg", "ros1": "ros1msg"}
_PROFILES: Final[dict[MessageEncoding, str]] = {"cdr": "ros2", "ros1": "ros1"}


@dataclass(frozen=True, slots=True)
class Packing:
    """How messages and chunks are encoded.

    Attributes:
        encoding: Of the messages; decides profile and schemas.
        stored: Channels whose messages are compressed already; their chunks are not.
        compression: Of the other chunks: `zstd`, `lz4` or `none`.

    """

    encoding: MessageEncoding
    stored: frozenset[int]
    compression: str


class _File:
    """A file that is written with as few copies as possible; knows its offset and CRC."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("wb", buffering=0)
        self.offset = 0
        self.crc = 0

    def write(self, parts: list[Buffer]) -> None:
        for part in parts:
            self.crc = isal_zlib.crc32(part, self.crc)
        self._write(parts)

    def write_chunk(self, head: bytes, chunk: Chunk) -> None:
        """Write a chunk, whose CRC is known, behind its head."""
        self.crc = isal_zlib.crc32_combine(isal_zlib.crc32(head, self.crc), chunk.body_crc, chunk.body_size)
        self._write([head, *chunk.body])

    def _write(self, parts: list[Buffer]) -> None:
        for start in range(0, len(parts), _MAX_PARTS):
            self._write_some(parts[start : start + _MAX_PARTS])

    def _write_some(self, parts: list[Buffer]) -> None:
        size = sum(map(len, parts))
        self.offset += size
        done = os.writev(self._file.fileno(), parts)
        if done < size:
            # A full disk, or a very large write: go on behind what was taken.
            rest = memoryview(b"".join(parts))[done:]
            while rest:
                rest = rest[os.write(self._file.fileno(), rest) :]

    def close(self) -> None:
        self._file.close()


def write_mcap(  # noqa: PLR0913 - all but two are parts of the file
    path: Path,
    channels: tuple[OutChannel, ...],
    messages: Iterable[OutMessage],
    metadata: Mapping[str, str],
    *,
    packing: Packing,
    jobs: int,
    progress: Progress,
    rows: Sequence[Rows] = (),
    digest: Callable[[], Mapping[str, str]] = dict,
) -> None:
    """Write a MCAP file.

    Args:
        path: The file to make.
        channels: Topics; the index is the channel's number less one, as 0 means "no schema".
        messages: In order of their stamps.
        metadata: The record named `tumtools`; not written if empty.
        packing: How messages and chunks are encoded.
        jobs: Threads.
        progress: Told of each image.
        rows: Further messages; at equal stamps they come behind `messages`.
        digest: Gives the record named `tumtools.digest` when all messages have been taken; may be empty.

    """
    file = _File(path)
    try:
        writer = _Writer(file, channels, packing.encoding)
        writer.start(metadata)
        chunker = Chunker(writer.introduce, packing.stored)
        chunks = ordered_map(
            lambda chunk: chunk.finish(packing.compression),
            chunker.chunks(messages, rows),
            jobs,
            window=2 * jobs,
        )
        for chunk in chunks:
            writer.chunk(chunk)
            progress(chunk.frames, chunk.payload)
        writer.finish(digest())
    finally:
        file.close()


class _Writer:
    """The parts of a file in their order, and what its summary needs of them."""

    def __init__(self, file: _File, channels: tuple[OutChannel, ...], encoding: MessageEncoding) -> None:
        self._file = file
        self._encoding: MessageEncoding = encoding
        kinds = list(dict.fromkeys(channel.type for channel in channels))
        self._schemas = [self._schema(number, kind) for number, kind in enumerate(kinds, 1)]
        self._channels = [
            record(
                Op.CHANNEL,
                struct.pack("<HH", number, kinds.index(channel.type) + 1),
                string(channel.topic),
                string(encoding),
                string_map(_qos(channel, encoding)),
            )
            for number, channel in enumerate(channels, 1)
        ]
        self._schema_of = [kinds.index(channel.type) for channel in channels]
        self._introduced: set[int] = set()
        self._introduced_schemas: set[int] = set()
        self._chunk_indexes: list[bytes] = []
        self._metadata_indexes: list[bytes] = []
        self._counts = dict.fromkeys(range(1, len(channels) + 1), 0)
        self._first: int | None = None
        self._last = 0

    def _schema(self, number: int, kind: str) -> bytes:
        return record(
            Op.SCHEMA,
            struct.pack("<H", number),
            string(ros1_name(kind) if self._encoding == "ros1" else kind),
            string(_SCHEMA_ENCODINGS[self._encoding]),
            string(definition(kind, self._encoding)),
        )

    def start(self, metadata: Mapping[str, str]) -> None:
        head = record(Op.HEADER, string(_PROFILES[self._encoding]), string(f"tumtools {__version__}"))
        self._file.write([MAGIC, head])
        self._write_metadata(RECORD, metadata)

    def _write_metadata(self, name: str, values: Mapping[str, str]) -> None:
        if values:
            data = record(Op.METADATA, string(name), string_map(values))
            place = struct.pack("<QQ", self._file.offset, len(data))
            self._metadata_indexes.append(record(Op.METADATA_INDEX, place, string(name)))
            self._file.write([data])

    def introduce(self, channel: int) -> list[bytes]:
        """Return the records that must stand before the first message of a channel."""
        if channel in self._introduced:
            return []
        self._introduced.add(channel)
        schema = self._schema_of[channel]
        new = schema not in self._introduced_schemas
        self._introduced_schemas.add(schema)
        return [*([self._schemas[schema]] if new else []), self._channels[channel]]

    def chunk(self, chunk: Chunk) -> None:
        head = CHUNK_HEADER.pack(chunk.first, chunk.last, chunk.size, chunk.crc) + string(chunk.compression)
        head += struct.pack("<Q", chunk.body_size)
        length = len(head) + chunk.body_size
        start = self._file.offset
        self._file.write_chunk(RECORD_HEADER.pack(Op.CHUNK, length) + head, chunk)
        index_start, offsets, indexes = self._file.offset, {}, []
        place = index_start
        for channel, entries in sorted(chunk.index.items()):
            data = record(Op.MESSAGE_INDEX, struct.pack("<H", channel), string(entries))
            offsets[channel] = place
            place += len(data)
            indexes.append(data)
            self._counts[channel] += len(entries) // INDEX_ENTRY.size
        self._file.write([b"".join(indexes)])
        self._first = chunk.first if self._first is None else min(self._first, chunk.first)
        self._last = max(self._last, chunk.last)
        times = struct.pack("<QQQQ", chunk.first, chunk.last, start, RECORD_HEADER.size + length)
        sizes = struct.pack("<QQ", chunk.body_size, chunk.size)
        self._chunk_indexes.append(
            record(
                Op.CHUNK_INDEX,
                times,
                number_map(offsets),
                struct.pack("<Q", place - index_start),
                string(chunk.compression),
                sizes,
            )
        )

    def finish(self, digest: Mapping[str, str]) -> None:
        missing = [number for number in range(len(self._channels)) if number not in self._introduced]
        self._file.write([part for number in missing for part in self.introduce(number)])
        self._write_metadata(DIGEST_RECORD, digest)
        self._file.write([record(Op.DATA_END, struct.pack("<I", self._file.crc))])
        start = self._file.offset
        groups = [
            (Op.SCHEMA, self._schemas),
            (Op.CHANNEL, self._channels),
            (Op.STATISTICS, [self._statistics()]),
            (Op.CHUNK_INDEX, self._chunk_indexes),
            (Op.METADATA_INDEX, self._metadata_indexes),
        ]
        summary, offsets = [], []
        place = start
        for op, records in groups:
            data = b"".join(records)
            if data:
                summary.append(data)
                offsets.append(record(Op.SUMMARY_OFFSET, struct.pack("<BQQ", op, place, len(data))))
                place += len(data)
        head = RECORD_HEADER.pack(Op.FOOTER, FOOTER.size) + struct.pack("<QQ", start, place)
        crc = 0
        for part in (*summary, *offsets, head):
            crc = isal_zlib.crc32(part, crc)
        self._file.write([*summary, *offsets, head, struct.pack("<I", crc), MAGIC])

    def _statistics(self) -> bytes:
        counts = struct.pack(
            "<QHIIII",
            sum(self._counts.values()),
            len(self._schemas),
            len(self._channels),
            0,
            len(self._metadata_indexes),
            len(self._chunk_indexes),
        )
        times = struct.pack("<QQ", self._first or 0, self._last)
        return record(Op.STATISTICS, counts, times, number_map(self._counts))


def _qos(channel: OutChannel, encoding: MessageEncoding) -> dict[str, str]:
    """Return what rosbag2 and ROS 1 tools keep beside a topic; rosbag2's is the same as in metadata.yaml."""
    if encoding == "cdr":
        return {"offered_qos_profiles": qos_profile(latched=channel.latched)}
    return {"latching": "1"} if channel.latched else {}
