# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Writes a ROS 1 bag that ROS itself reads: chunks with their indexes, then connections and chunk infos."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, BinaryIO, Final

from tumtools.errors import OutputError
from tumtools.formats.options import Progress, no_progress
from tumtools.formats.rosbag1.compression import compress
from tumtools.formats.rosbag1.records import (
    BAG_HEADER_SIZE,
    MAGIC,
    Op,
    encode_fields,
    encode_header,
    encode_number,
    encode_time,
)
from tumtools.images.parallel import ordered_map

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from tumtools.formats.ros.recording import OutMessage
    from tumtools.formats.rosbag1.structure import Connection

CHUNK_SIZE: Final = 768 * 1024
"""A chunk is closed when it has more bytes than this, as in ROS."""

_INDEX_ENTRY: Final = struct.Struct("<8sI")
_COUNT: Final = struct.Struct("<II")
_LIMIT: Final = 2**32


@dataclass(slots=True)
class _Chunk:
    """A chunk that is being filled."""

    parts: list[bytes | memoryview] = field(default_factory=list)
    size: int = 0
    stamps: list[int] = field(default_factory=list)
    index: dict[int, list[tuple[bytes, int]]] = field(default_factory=dict)
    frames: int = 0

    def add(self, *parts: bytes | memoryview) -> None:
        self.parts += parts
        self.size += sum(memoryview(part).nbytes for part in parts)


@dataclass(frozen=True, slots=True)
class _ChunkInfo:
    """What the index at the end of the file says of a chunk."""

    offset: int
    start: int
    end: int
    counts: dict[int, int]


def write_bag(
    file: BinaryIO,
    connections: Sequence[Connection],
    messages: Iterable[OutMessage],
    *,
    compression: str = "none",
    jobs: int = 1,
    progress: Progress = no_progress,
) -> None:
    """Write a bag.

    Args:
        file: An empty file, open for writing, that can seek.
        connections: What `OutMessage.channel` counts.
        messages: In order of their stamps.
        compression: One of `compression.COMPRESSIONS`.
        jobs: Threads that compress.
        progress: Told what has been written.

    Raises:
        OutputError: A message or stamp that a bag cannot hold.

    """
    file.write(MAGIC + _bag_header(0, 0, 0))
    infos: list[_ChunkInfo] = []
    pack = partial(_pack, compression=compression)
    chunks = _chunks(connections, messages)
    threads = jobs if compression != "none" else 1
    for chunk, payload in ordered_map(pack, chunks, threads, window=2 * threads):
        infos.append(_write_chunk(file, chunk, payload, compression))
        progress(chunk.frames, chunk.size)
    index_at = file.tell()
    used = sorted({number for info in infos for number in info.counts})
    file.writelines(_connection_record(number, connections[number]) for number in used)
    file.writelines(_chunk_info_record(info) for info in infos)
    file.seek(len(MAGIC))
    file.write(_bag_header(index_at, len(used), len(infos)))


def _bag_header(index_at: int, connections: int, chunks: int) -> bytes:
    fields = {
        b"chunk_count": encode_number(chunks),
        b"conn_count": encode_number(connections),
        b"index_pos": encode_number(index_at, 8),
    }
    padding = BAG_HEADER_SIZE - len(encode_fields({**fields, b"op": b"\0"}))
    return encode_header(Op.BAG_HEADER, fields, padding) + b" " * padding


def _chunks(connections: Sequence[Connection], messages: Iterable[OutMessage]) -> Iterator[_Chunk]:
    """Gather messages in chunks; a connection is described before its first message."""
    described: set[int] = set()
    chunk = _Chunk()
    for message in messages:
        number = message.channel
        if number not in described:
            described.add(number)
            chunk.add(_connection_record(number, connections[number]))
        length = sum(memoryview(part).nbytes for part in message.parts)
        if not 0 <= message.stamp < _LIMIT * 1_000_000_000:
            raise OutputError(f"a ROS 1 bag holds stamps of 0 to {_LIMIT - 1} s, not {message.stamp} ns")
        if length + CHUNK_SIZE * 2 > _LIMIT:
            raise OutputError(f"a ROS 1 bag holds messages of less than 4 GiB, not {length} bytes")
        time = encode_time(message.stamp)
        chunk.index.setdefault(number, []).append((time, chunk.size))
        chunk.stamps.append(message.stamp)
        chunk.frames += message.is_image
        chunk.add(encode_header(Op.MESSAGE, {b"conn": encode_number(number), b"time": time}, length))
        chunk.add(*message.parts)
        if chunk.size > CHUNK_SIZE:
            yield chunk
            chunk = _Chunk()
    if chunk.size:
        yield chunk


def _pack(chunk: _Chunk, compression: str) -> tuple[_Chunk, list[bytes | memoryview]]:
    """Return the chunk and its content as it goes into the file."""
    if compression == "none":
        return chunk, chunk.parts
    return chunk, [compress(b"".join(chunk.parts), compression)]


def _write_chunk(
    file: BinaryIO, chunk: _Chunk, payload: list[bytes | memoryview], compression: str
) -> _ChunkInfo:
    """Write a chunk and the index records that follow it."""
    offset = file.tell()
    fields = {b"compression": compression.encode(), b"size": encode_number(chunk.size)}
    file.write(encode_header(Op.CHUNK, fields, sum(memoryview(part).nbytes for part in payload)))
    file.writelines(payload)
    for number, entries in sorted(chunk.index.items()):
        table = b"".join(_INDEX_ENTRY.pack(time, at) for time, at in entries)
        fields = {
            b"ver": encode_number(1),
            b"conn": encode_number(number),
            b"count": encode_number(len(entries)),
        }
        file.write(encode_header(Op.INDEX, fields, len(table)) + table)
    counts = {number: len(entries) for number, entries in sorted(chunk.index.items())}
    return _ChunkInfo(offset, min(chunk.stamps), max(chunk.stamps), counts)


def _connection_record(number: int, connection: Connection) -> bytes:
    description = {
        b"topic": connection.topic.encode(),
        b"type": connection.type.encode(),
        b"md5sum": connection.md5sum.encode(),
        b"message_definition": connection.definition.encode(),
    }
    if connection.latched:
        description[b"latching"] = b"1"
    data = encode_fields(description)
    fields = {b"conn": encode_number(number), b"topic": connection.topic.encode()}
    return encode_header(Op.CONNECTION, fields, len(data)) + data


def _chunk_info_record(info: _ChunkInfo) -> bytes:
    table = b"".join(_COUNT.pack(number, count) for number, count in info.counts.items())
    fields = {
        b"ver": encode_number(1),
        b"chunk_pos": encode_number(info.offset, 8),
        b"start_time": encode_time(info.start),
        b"end_time": encode_time(info.end),
        b"count": encode_number(len(info.counts)),
    }
    return encode_header(Op.CHUNK_INFO, fields, len(table)) + table
