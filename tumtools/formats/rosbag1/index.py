# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What is where in a ROS 1 bag, by its index."""

from __future__ import annotations

import struct
from collections import Counter
from dataclasses import replace
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from tumtools.errors import InputError, UnsupportedInputError
from tumtools.formats.rosbag1.records import BAG_HEADER_SIZE, MAGIC, Block, Op, Record, read_record
from tumtools.formats.rosbag1.scan import Scan
from tumtools.formats.rosbag1.structure import (
    ENTRY,
    BagIndex,
    Chunk,
    Connection,
    parse_chunk,
    parse_connection,
)
from tumtools.model.sequence import LEFT_OUT, RECORDING, Loss
from tumtools.model.time import NANOSECONDS_PER_SECOND

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy.typing as npt

_FILE_ENTRY: Final = np.dtype([("seconds", "<u4"), ("nanoseconds", "<u4"), ("offset", "<u4")])
_COUNT: Final = struct.Struct("<II")


def read_index(file: Block, *, salvage: bool = False) -> BagIndex:
    """Read the index of a bag, or scan the bag where it has none.

    Args:
        file: The whole file.
        salvage: Do not trust the index but scan, and leave out what is damaged instead of failing.

    Raises:
        InputError: The file is no bag or damaged.

    """
    at = _check_magic(file)
    try:
        header = read_record(file, at).expect(Op.BAG_HEADER, "the bag's header")
        index_at = header.number(b"index_pos", 8)
    except InputError as error:
        if not salvage:
            raise
        found = Scan(file, salvage=True, damage=[error]).run(at + 8 + BAG_HEADER_SIZE)
        header_loss = Loss(RECORDING, f"header {LEFT_OUT}", 1, "whether the end is there cannot be told")
        return replace(found, left_out=(header_loss, *found.left_out))
    if header.fields.get(b"encryptor"):
        raise UnsupportedInputError("an encrypted bag", path=file.path, hint="decrypt it with rosbag first")
    if salvage and index_at:
        return _salvaged(file, header, index_at)
    if index_at == 0:
        found = Scan(file, salvage=salvage).run(header.data_end)
        unindexed = "the bag has no index, its recorder was interrupted; its chunks were scanned instead"
        return replace(found, warnings=(unindexed, *found.warnings))
    return _from_index(file, header, index_at)


def _salvaged(file: Block, header: Record, index_at: int) -> BagIndex:
    """Scan the bag; where its index can be read, it tells which messages are not there."""
    scan = Scan(file, salvage=True, data_end=index_at if _may_begin(file, index_at) else None)
    try:
        promised = _from_index(file, header, index_at)
    except InputError:
        return scan.run(header.data_end)
    scan.connections.update(promised.connections)
    found = scan.run(header.data_end)
    missing: Counter[str] = Counter()
    for number, count in (promised.count() - found.count()).items():
        missing[promised.connections[number].topic] += count
    why = "; ".join(f"{error.location}: {error.message}" for error in scan.damage[:1])
    losses = (Loss(topic, f"messages {LEFT_OUT}", count, why) for topic, count in sorted(missing.items()))
    return replace(found, left_out=tuple(losses))


def _may_begin(file: Block, index_at: int) -> bool:
    """Tell whether the index may be where it should be: there, or behind the end of a file that was cut."""
    if index_at >= len(file.data):
        return True
    try:
        return read_record(file, index_at).op in {Op.CONNECTION, Op.CHUNK_INFO}
    except InputError:
        return False


def _check_magic(file: Block) -> int:
    """Return the offset of the first record."""
    if not len(file.data):
        raise InputError("the file is empty (0 bytes), expected a ROS bag", path=file.path)
    start = bytes(file.data[: len(MAGIC)])
    if start == MAGIC:
        return len(MAGIC)
    if start.startswith((b"#ROSBAG V1", b"#ROSRECORD")):
        version = str(start, "ascii", "replace").split()[-1]
        raise UnsupportedInputError(
            f"a ROS bag of version {version}, only 2.0 is read",
            path=file.path,
            location="offset 0",
            hint="convert it with `rosbag migrate` or `rosbag fix`",
        )
    raise InputError(
        f"not a ROS bag: it begins with {start!r}, not {MAGIC!r}", path=file.path, location="offset 0"
    )


def _from_index(file: Block, header: Record, index_at: int) -> BagIndex:
    if not header.data_end <= index_at <= len(file.data):
        raise file.damage(
            f"the index should be at offset {index_at}, outside the {len(file.data)} bytes of the file; "
            "the file was cut or not finished",
            header.offset,
        )
    connections: dict[int, Connection] = {}
    infos: list[Record] = []
    at = index_at
    while at < len(file.data):
        record = read_record(file, at)
        if record.op == Op.CONNECTION:
            number, connection = parse_connection(record)
            connections[number] = connection
        else:
            infos.append(record.expect(Op.CHUNK_INFO, "a connection or a chunk info"))
        at = record.data_end
    for what, name, found in (
        ("connections", b"conn_count", len(connections)),
        ("chunks", b"chunk_count", len(infos)),
    ):
        promised = header.number(name, 4)
        if promised != found:
            raise file.damage(f"the index has {found} {what}, the bag's header promises {promised}", index_at)
    infos.sort(key=lambda info: info.number(b"chunk_pos", 8))
    chunks: list[Chunk] = []
    tables: list[_Table] = []
    for info in infos:
        chunk = parse_chunk(read_record(file, _chunk_offset(info, index_at)))
        tables += _index_of_chunk(file, chunk, len(chunks), info, connections)
        chunks.append(chunk)
        file.passed(chunk.start, chunk.end - chunk.start)
    return BagIndex(connections, chunks, _entries(file, chunks, tables))


def _chunk_offset(info: Record, index_at: int) -> int:
    offset = info.number(b"chunk_pos", 8)
    if offset >= index_at:
        raise info.block.damage(f"a chunk is said to be at offset {offset}, behind the index", info.offset)
    return offset


class _Table(NamedTuple):
    """An index record: where it is, for which chunk and connection, and its rows as they are in the file."""

    offset: int
    chunk: int
    connection: int
    messages: int
    rows: bytes


def _index_of_chunk(
    file: Block, chunk: Chunk, number: int, info: Record, connections: dict[int, Connection]
) -> Iterator[_Table]:
    """Read the index records that follow a chunk; they must have what the chunk info says."""
    if info.number(b"ver", 4) != 1:
        raise UnsupportedInputError(
            "a chunk info of another version than 1", path=file.path, location=f"offset {info.offset}"
        )
    count, rows = _rows(info, _COUNT.size)
    promised = dict(_COUNT.iter_unpack(rows))
    at = chunk.end
    for _ in range(len(promised)):
        record = read_record(file, at).expect(Op.INDEX, "the index of a chunk")
        connection = record.number(b"conn", 4)
        count, rows = _rows(record, _FILE_ENTRY.itemsize)
        if connection not in connections or promised.get(connection) != count:
            message = (
                f"the index of a chunk has {count} messages of connection {connection}, "
                f"its chunk info says {promised.get(connection, 0)}"
            )
            raise file.damage(message, at)
        yield _Table(at, number, connection, count, rows)
        at = record.data_end


def _entries(file: Block, chunks: list[Chunk], tables: list[_Table]) -> npt.NDArray[np.void]:
    """Return the entries of all index records."""
    counts = [table.messages for table in tables]
    found = np.frombuffer(b"".join(table.rows for table in tables), _FILE_ENTRY)
    entries = np.empty(len(found), ENTRY)
    entries["time"] = found["seconds"].astype(np.int64) * NANOSECONDS_PER_SECOND + found["nanoseconds"]
    entries["offset"] = found["offset"]
    for name in ("chunk", "connection"):
        entries[name] = np.repeat(np.array([getattr(table, name) for table in tables], ENTRY[name]), counts)
    sizes = np.array([chunk.size for chunk in chunks], np.int64)
    outside = np.flatnonzero(entries["offset"] >= sizes[entries["chunk"]])
    if len(outside):
        table = tables[int(np.searchsorted(np.cumsum(counts), outside[0], side="right"))]
        size = chunks[table.chunk].size
        raise file.damage(f"an index points behind the end of its chunk ({size} bytes)", table.offset)
    order = np.lexsort((entries["offset"], entries["chunk"]))
    places = entries[["chunk", "offset"]][order]
    twice = np.flatnonzero(places[1:] == places[:-1])
    if len(twice):
        chunk, offset = places[twice[0]].tolist()
        message = (
            f"the index names the message at {offset} of the chunk at offset {chunks[chunk].offset} twice"
        )
        raise file.damage(message, chunks[chunk].end)
    return entries


def _rows(record: Record, size: int) -> tuple[int, bytes]:
    """Return the data of a record, which is `count` rows of a size."""
    count, nbytes = record.number(b"count", 4), record.data_end - record.data_start
    if nbytes != count * size:
        message = f"{count} rows of {size} bytes announced, but {nbytes} bytes of data"
        raise record.block.damage(message, record.offset)
    return count, bytes(record.data)
