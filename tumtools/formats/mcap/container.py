# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Write channels and messages into a MCAP file: chunks, indexes, summary, all CRCs.

Chunks are compressed by several threads and written in order; payloads that are kept as they are go from
their buffers to the file without being copied.
"""

from __future__ import annotations

import os
import struct
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import lz4.frame
import zstandard
from isal import isal_zlib

from tumtools import __version__
from tumtools.formats.mcap.records import (
    CHUNK_HEADER,
    FOOTER,
    INDEX_ENTRY,
    MAGIC,
    MESSAGE_HEADER,
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
    from collections.abc import Callable, Iterable, Iterator, Mapping
    from pathlib import Path

    from tumtools.formats.options import Progress
    from tumtools.formats.ros.recording import MessageEncoding, OutChannel, OutMessage

CHUNK_BYTES: Final = 1 << 20
"""A chunk is closed before the message that would make it larger, unless it holds nothing else."""
_ZSTD_LEVEL: Final = 1
_LARGE: Final = 1 << 14
"""A buffer of this size is not copied."""
_MAX_PARTS: Final = 1000
"""Buffers in one call of writev; POSIX allows 1024."""
_SCHEMA_ENCODINGS: Final[dict[MessageEncoding, str]] = {"cdr": "ros2msg", "ros1": "ros1msg"}
_PROFILES: Final[dict[MessageEncoding, str]] = {"cdr": "ros2", "ros1": "ros1"}

Buffer = bytes | bytearray | memoryview


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


@dataclass(slots=True)
class _Chunk:
    """Messages that are written together."""

    stored: bool
    parts: list[Buffer] = field(default_factory=list)
    open: bytearray | None = None
    size: int = 0
    first: int = 0
    last: int = 0
    index: dict[int, list[tuple[int, int]]] = field(default_factory=dict)
    frames: int = 0
    payload: int = 0
    compression: str = ""
    crc: int = 0
    body: list[Buffer] = field(default_factory=list)
    body_size: int = 0

    def add(self, parts: Iterable[Buffer]) -> None:
        """Add buffers; small ones are joined, large ones are kept as they are."""
        for part in parts:
            self.size += len(part)
            if len(part) >= _LARGE:
                self.parts.append(part)
                self.open = None
            else:
                if self.open is None:
                    self.open = bytearray()
                    self.parts.append(self.open)
                self.open += part


class _File:
    """A file that is written with as few copies as possible; knows its offset and CRC."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("wb", buffering=0)
        self.offset = 0
        self.crc = 0

    def write(self, parts: list[Buffer]) -> None:
        for start in range(0, len(parts), _MAX_PARTS):
            self._write_some(parts[start : start + _MAX_PARTS])

    def _write_some(self, parts: list[Buffer]) -> None:
        size = 0
        for part in parts:
            self.crc = isal_zlib.crc32(part, self.crc)
            size += len(part)
        self.offset += size
        done = os.writev(self._file.fileno(), parts)
        if done < size:
            # A full disk, or a very large write: go on behind what was taken.
            rest = memoryview(b"".join(parts))[done:]
            while rest:
                rest = rest[os.write(self._file.fileno(), rest) :]

    def close(self) -> None:
        self._file.close()


def write_mcap(
    path: Path,
    channels: tuple[OutChannel, ...],
    messages: Iterable[OutMessage],
    metadata: Mapping[str, str],
    *,
    packing: Packing,
    jobs: int,
    progress: Progress,
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
        digest: Gives the record named `tumtools.digest` when all messages have been taken; may be empty.

    """
    file = _File(path)
    try:
        writer = _Writer(file, channels, packing.encoding)
        writer.start(metadata)
        chunks = ordered_map(
            lambda chunk: _finish(chunk, packing.compression),
            _chunks(writer, messages, packing.stored),
            jobs,
        )
        for chunk in chunks:
            writer.chunk(chunk)
            progress(chunk.frames, chunk.payload)
        writer.finish(digest())
    finally:
        file.close()


def _chunks(writer: _Writer, messages: Iterable[OutMessage], stored: frozenset[int]) -> Iterator[_Chunk]:
    """Gather messages to chunks. Small messages go with whichever images are at hand."""
    chunk = _Chunk(stored=False)
    has_image = False
    sequences: dict[int, int] = {}
    for message in messages:
        size = sum(map(len, message.parts))
        kind = message.channel in stored
        full = chunk.size + size > CHUNK_BYTES or (message.is_image and has_image and kind != chunk.stored)
        if chunk.size and full:
            yield chunk
            chunk, has_image = _Chunk(stored=False), False
        if message.is_image:
            has_image, chunk.stored = True, kind
            chunk.frames += 1
        chunk.payload += size
        chunk.add(writer.introduce(message.channel))
        chunk.first = min(chunk.first, message.stamp) if chunk.index else message.stamp
        chunk.last = max(chunk.last, message.stamp)
        chunk.index.setdefault(message.channel + 1, []).append((message.stamp, chunk.size))
        sequence = sequences[message.channel] = sequences.get(message.channel, -1) + 1
        head = RECORD_HEADER.pack(Op.MESSAGE, MESSAGE_HEADER.size + size)
        head += MESSAGE_HEADER.pack(message.channel + 1, sequence % 2**32, message.stamp, message.stamp)
        chunk.add((head, *message.parts))
    if chunk.size:
        yield chunk


def _finish(chunk: _Chunk, compression: str) -> _Chunk:
    """Compress a chunk and compute its CRC."""
    for part in chunk.parts:
        chunk.crc = isal_zlib.crc32(part, chunk.crc)
    if chunk.stored or compression == "none":
        chunk.body, chunk.body_size = chunk.parts, chunk.size
        return chunk
    whole = b"".join(chunk.parts)
    if compression == "zstd":
        packed = zstandard.ZstdCompressor(_ZSTD_LEVEL).compress(whole)
    else:
        packed = lz4.frame.compress(whole)
    chunk.compression, chunk.body, chunk.body_size = compression, [packed], len(packed)
    return chunk


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

    def chunk(self, chunk: _Chunk) -> None:
        head = CHUNK_HEADER.pack(chunk.first, chunk.last, chunk.size, chunk.crc) + string(chunk.compression)
        head += struct.pack("<Q", chunk.body_size)
        length = len(head) + chunk.body_size
        start = self._file.offset
        self._file.write([RECORD_HEADER.pack(Op.CHUNK, length) + head, *chunk.body])
        index_start, offsets, indexes = self._file.offset, {}, []
        place = index_start
        for channel, entries in sorted(chunk.index.items()):
            packed = b"".join(INDEX_ENTRY.pack(*entry) for entry in entries)
            data = record(Op.MESSAGE_INDEX, struct.pack("<H", channel), string(packed))
            offsets[channel] = place
            place += len(data)
            indexes.append(data)
            self._counts[channel] += len(entries)
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
