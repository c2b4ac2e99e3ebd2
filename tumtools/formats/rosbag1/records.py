# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Records of a ROS 1 bag: a header of named fields, then data. Every length is checked before use."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, Final, NamedTuple

from tumtools.errors import InputError, UnsupportedInputError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

MAGIC: Final = b"#ROSBAG V2.0\n"
BAG_HEADER_SIZE: Final = 4096
"""Header and data of the bag header record together; padded, so that it can be rewritten in place."""

SALVAGE_HINT: Final = "--salvage reads what comes before the damage"


class Op(IntEnum):
    """What a record is, its field `op`."""

    MESSAGE = 0x02
    BAG_HEADER = 0x03
    INDEX = 0x04
    CHUNK = 0x05
    CHUNK_INFO = 0x06
    CONNECTION = 0x07


_MOST_FIELDS: Final = 16 * 2**20
"""Bytes of the fields of a header, or of a connection with its message definition; mostly some kilobytes."""
_LENGTH: Final = struct.Struct("<I")
_NUMBERS: Final = {1: struct.Struct("<B"), 4: struct.Struct("<I"), 8: struct.Struct("<Q")}
_TIME: Final = struct.Struct("<II")


def _ignore(offset: int, nbytes: int) -> None:
    """Nobody wants to know."""


@dataclass(frozen=True, slots=True)
class Block:
    """Bytes that records are in: the file, or the content of a chunk.

    Attributes:
        path: The file.
        data: The bytes.
        chunk: Offset of the chunk in the file, or None for the file itself.
        passed: Of the file: told from where and how many bytes are read, so that memory can be given back.

    """

    path: str
    data: memoryview
    chunk: int | None = None
    passed: Callable[[int, int], None] = _ignore

    def damage(self, message: str, offset: int) -> InputError:
        """Return the error for damage at this offset of the block."""
        inside = "" if self.chunk is None else f" of the chunk at offset {self.chunk}"
        return InputError(message, path=self.path, location=f"offset {offset}{inside}", hint=SALVAGE_HINT)


class Record(NamedTuple):
    """A record: where it is in its block, what it is, its other fields, and where its data is."""

    block: Block
    offset: int
    op: int
    fields: dict[bytes, bytes]
    data_start: int
    data_end: int

    @property
    def data(self) -> memoryview:
        """The data, as a view."""
        return self.block.data[self.data_start : self.data_end]

    def number(self, name: bytes, size: int) -> int:
        """Return an unsigned number of the header.

        Raises:
            InputError: It is missing or has another size.

        """
        value = self._field(name, size)
        return int(_NUMBERS[size].unpack(value)[0])

    def time(self, name: bytes) -> int:
        """Return a time of the header in nanoseconds."""
        seconds, nanoseconds = _TIME.unpack(self._field(name, 8))
        return int(seconds) * 1_000_000_000 + int(nanoseconds)

    def text(self, name: bytes) -> str:
        """Return a text of the header."""
        return decode_text(self._field(name, None), self)

    def expect(self, op: Op, what: str) -> Record:
        """Return the record itself if it is of this kind."""
        if self.op != op:
            raise self.block.damage(
                f"expected {what} (op {int(op)}), found a record with op {self.op}", self.offset
            )
        return self

    def _field(self, name: bytes, size: int | None) -> bytes:
        value = self.fields.get(name)
        if value is None:
            raise self.block.damage(f"record (op {self.op}) without the field {name.decode()!r}", self.offset)
        if size is not None and len(value) != size:
            message = f"field {name.decode()!r} has {len(value)} bytes, expected {size}"
            raise self.block.damage(message, self.offset)
        return value


def decode_text(value: bytes, record: Record) -> str:
    """Decode UTF-8.

    Raises:
        InputError: It is none.

    """
    try:
        return str(value, "utf-8")
    except UnicodeDecodeError as error:
        raise record.block.damage(
            f"text that is not UTF-8 in a record with op {record.op}", record.offset
        ) from error


def parse_fields(block: Block, start: int, end: int) -> dict[bytes, bytes]:
    """Parse `length name=value` fields between two offsets.

    Raises:
        InputError: A length passes the end, or a field has no `=`.
        UnsupportedInputError: There are more bytes of fields than any bag has.

    """
    if end - start > _MOST_FIELDS:
        raise UnsupportedInputError(
            f"{end - start} bytes of header fields, more than {_MOST_FIELDS}",
            path=block.path,
            location=f"offset {start}",
            hint=SALVAGE_HINT,
        )
    data, fields, at, size = bytes(block.data[start:end]), {}, 0, end - start
    while at < size:
        if size - at < _LENGTH.size:
            raise block.damage(f"{size - at} bytes left where a field of a header begins", start + at)
        (length,) = _LENGTH.unpack_from(data, at)
        at += _LENGTH.size
        if length > size - at:
            raise block.damage(f"a header field of {length} bytes where {size - at} are left", start + at)
        name, equals, value = data[at : at + length].partition(b"=")
        if not equals:
            raise block.damage("a header field without '='", start + at)
        fields[name] = value
        at += length
    return fields


def find_message(block: Block, offset: int, connection: int, time: int) -> memoryview:
    """Return the data of the message that an index says is at an offset.

    Raises:
        InputError: It is not there, or cut short.

    """
    record = read_record(block, offset)
    found = record.op == Op.MESSAGE and (record.number(b"conn", 4), record.time(b"time"))
    if found != (connection, time):
        raise block.damage(f"the index says that a message of connection {connection} is here", offset)
    return record.data


def read_record(block: Block, offset: int, *, cut: bool = False) -> Record:
    """Read the record at an offset; its data is not touched.

    Args:
        block: Where it is.
        offset: Where in the block.
        cut: Accept data that the end of the block cuts short.

    Raises:
        InputError: The record is cut short or makes no sense.

    """
    start, header_length = _sized(block, offset, "header")
    data_start, data_length = _sized(block, start + header_length, "data", cut=cut)
    fields = parse_fields(block, start, start + header_length)
    op = fields.pop(b"op", None)
    if op is None or len(op) != 1:
        raise block.damage("a record header without an op field of one byte", offset)
    return Record(block, offset, op[0], fields, data_start, data_start + data_length)


def _sized(block: Block, offset: int, what: str, *, cut: bool = False) -> tuple[int, int]:
    left = len(block.data) - offset
    if left < _LENGTH.size:
        raise block.damage(f"the end is reached where the {what} of a record is expected", offset)
    (length,) = _LENGTH.unpack_from(block.data, offset)
    left -= _LENGTH.size
    if length > left:
        if cut:
            return offset + _LENGTH.size, left
        raise block.damage(
            f"the {what} of a record has {length} bytes by its length field, {left} are left", offset
        )
    return offset + _LENGTH.size, int(length)


def encode_fields(fields: Mapping[bytes, bytes]) -> bytes:
    """Encode `length name=value` fields, in the order given."""
    return b"".join(
        _LENGTH.pack(len(name) + 1 + len(value)) + name + b"=" + value for name, value in fields.items()
    )


def encode_header(op: Op, fields: Mapping[bytes, bytes], data_length: int) -> bytes:
    """Encode all of a record that stands before its data."""
    header = encode_fields({**fields, b"op": bytes([op])})
    return _LENGTH.pack(len(header)) + header + _LENGTH.pack(data_length)


def encode_number(value: int, size: int = 4) -> bytes:
    """Encode an unsigned number."""
    return value.to_bytes(size, "little")


def encode_time(stamp: int) -> bytes:
    """Encode nanoseconds as a ROS time."""
    return _TIME.pack(*divmod(stamp, 1_000_000_000))
