# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The records of a MCAP file, packed and unpacked.

Source: MCAP specification, section "Records". All numbers are little endian.
"""

from __future__ import annotations

import struct
from enum import IntEnum
from typing import TYPE_CHECKING, Final

from tumtools.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping

MAGIC: Final = b"\x89MCAP0\r\n"
RECORD_HEADER: Final = struct.Struct("<BQ")
"""Opcode and length of what follows."""
MESSAGE_HEADER: Final = struct.Struct("<HIqq")
"""Channel, sequence, log time, publish time; times signed, as in arrays, so that all of them fit there."""
FOOTER: Final = struct.Struct("<QQI")
"""Start of the summary, start of the summary offsets, CRC of the summary."""
FOOTER_RECORD_SIZE: Final = RECORD_HEADER.size + FOOTER.size
CHUNK_HEADER: Final = struct.Struct("<QQQI")
"""First and last log time, uncompressed size, CRC of the uncompressed records."""
INDEX_ENTRY: Final = struct.Struct("<QQ")
"""Log time, offset in the uncompressed records."""


class Op(IntEnum):
    """Opcodes."""

    HEADER = 0x01
    FOOTER = 0x02
    SCHEMA = 0x03
    CHANNEL = 0x04
    MESSAGE = 0x05
    CHUNK = 0x06
    MESSAGE_INDEX = 0x07
    CHUNK_INDEX = 0x08
    ATTACHMENT = 0x09
    ATTACHMENT_INDEX = 0x0A
    STATISTICS = 0x0B
    METADATA = 0x0C
    METADATA_INDEX = 0x0D
    SUMMARY_OFFSET = 0x0E
    DATA_END = 0x0F


def record(op: Op, *parts: bytes) -> bytes:
    """Return a record."""
    return b"".join([RECORD_HEADER.pack(op, sum(map(len, parts))), *parts])


def string(text: str | bytes) -> bytes:
    """Return a string with its length."""
    data = text if isinstance(text, bytes) else text.encode()
    return struct.pack("<I", len(data)) + data


def string_map(values: Mapping[str, str]) -> bytes:
    """Return a map of strings with its size in bytes; sorted, so that the bytes are always the same."""
    return string(b"".join(string(key) + string(values[key]) for key in sorted(values)))


def number_map(values: Mapping[int, int]) -> bytes:
    """Return a map from channel to a number with its size in bytes."""
    return string(b"".join(struct.pack("<HQ", key, values[key]) for key in sorted(values)))


class Fields:
    """Takes the fields of a record one after the other.

    Args:
        data: Content of the record.
        offset: Where it is in the file, for messages.
        path: The file, for messages.

    """

    def __init__(self, data: memoryview, offset: int, path: str) -> None:
        self._data = data
        self._path = path
        self._offset = offset
        self._position = 0

    def take(self, size: int) -> memoryview:
        """Return so many bytes.

        Raises:
            InputError: The record ends before.

        """
        left = len(self._data) - self._position
        if size > left:
            raise InputError(
                f"the record ends too early: {size} bytes needed, {left} left",
                path=self._path,
                location=f"offset {self._offset + self._position}",
            )
        part = self._data[self._position : self._position + size]
        self._position += size
        return part

    def unpack(self, kind: struct.Struct) -> tuple[int, ...]:
        """Return numbers."""
        return kind.unpack(self.take(kind.size))

    def number(self, code: str) -> int:
        """Return one number, given by its code of `struct`."""
        (value,) = struct.unpack("<" + code, self.take(struct.calcsize("<" + code)))
        return int(value)

    def blob(self) -> memoryview:
        """Return bytes that are preceded by their length as uint32."""
        return self.take(self.number("I"))

    def string(self) -> str:
        """Return a text."""
        return bytes(self.blob()).decode("utf-8", "replace")

    def string_map(self) -> dict[str, str]:
        """Return a map of texts."""
        inner = Fields(self.blob(), self._offset + self._position, self._path)
        result = {}
        while inner.left:
            key = inner.string()
            result[key] = inner.string()
        return result

    def number_map(self) -> dict[int, int]:
        """Return a map from channel to a number."""
        return dict(struct.iter_unpack("<HQ", self._whole(self.blob(), 10)))

    def index_entries(self) -> memoryview:
        """Return (log time, offset) pairs of uint64 as bytes."""
        return self._whole(self.blob(), INDEX_ENTRY.size)

    def _whole(self, part: memoryview, size: int) -> memoryview:
        if len(part) % size:
            raise InputError(
                f"{len(part)} bytes are no multiple of {size}",
                path=self._path,
                location=f"offset {self._offset + self._position}",
            )
        return part

    @property
    def left(self) -> int:
        """Bytes that have not been taken."""
        return len(self._data) - self._position

    def rest(self) -> memoryview:
        """Return all bytes that are left."""
        return self.take(self.left)
