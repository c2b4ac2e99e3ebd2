# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Serialise and read messages, driven by their definitions: CDR (ROS 2) and the encoding of ROS 1.

A message is a dict of its fields. Arrays of numbers are numpy views into the message, so a large payload is
not copied. Many messages of one shape are read and written as columns: the layout is traced once, and then
whole columns are cut out of, or put into, a table of bytes.

Source: OMG DDS-XTypes 1.3, section 7.4 (plain CDR, XCDR version 1); ROS wiki `msg` (ROS 1 serialisation).
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from tumtools.errors import InputError, UnsupportedInputError
from tumtools.formats.ros.definitions import PRIMITIVES, Definitions, Field, parse_definitions

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy.typing as npt

    from tumtools.formats.ros.recording import MessageEncoding

Value = object
Message = dict[str, Value]

_CDR_HEADER: Final = b"\x00\x01\x00\x00"
"""Plain CDR, little endian, no options."""
_CDR_BIG_ENDIAN: Final = 0
_CDR_LITTLE_ENDIAN: Final = 1
_MAX_PASSES: Final = 64
"""Layouts of messages of one length that are looked for; further messages are read one by one."""


@dataclass(frozen=True, slots=True)
class _Leaf:
    """A number, or a fixed run of numbers, at an offset of a message."""

    offset: int
    dtype: np.dtype[np.generic]
    count: int | None


@dataclass(slots=True)
class _Trace:
    """Where the leaves of a message are, and which bytes decide its layout (lengths and texts)."""

    leaves: dict[str, _Leaf] = field(default_factory=dict)
    layout: list[tuple[int, int]] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class Columns:
    """Messages of one layout, as columns.

    Attributes:
        rows: Which of the messages, int, shape [n].
        numbers: Path of the field (`header.stamp.sec`, `transforms.0.transform.rotation.x`) -> shape [n],
            or [n, k] for arrays.
        texts: Path -> text, the same in all n messages.

    """

    rows: npt.NDArray[np.intp]
    numbers: Mapping[str, npt.NDArray[np.generic]]
    texts: Mapping[str, str]


class MessageType:
    """A message type with its serialisation.

    Args:
        definition: Text with all dependencies.
        name: `package/msg/Type`.
        encoding: `cdr` or `ros1`.

    Raises:
        InputError: The definition cannot be understood.

    """

    def __init__(self, definition: str, name: str, encoding: MessageEncoding) -> None:
        self.name = name
        self.encoding: MessageEncoding = encoding
        self.definitions: Definitions = parse_definitions(definition, name, ros2=encoding == "cdr")

    def decode(self, data: memoryview) -> Message:
        """Read a message.

        Raises:
            InputError: It does not fit its definition; with the offset.

        """
        return _Reader(data, self).message(self.name, "")

    def columns_of(self, rows: npt.NDArray[np.intp], table: npt.NDArray[np.uint8]) -> list[Columns]:
        """Read many messages of one length at once; one result for each layout that occurs.

        Args:
            rows: Numbers of the messages, for `Columns.rows`.
            table: One message a row.

        Raises:
            InputError: A message does not fit the definition; with the offset.

        """
        result = []
        for _ in range(_MAX_PASSES):
            if len(rows):
                columns, same = self._columns_like_first(table, rows)
                result.append(columns)
                table, rows = table[~same], rows[~same]
        single = (slice(n, n + 1) for n in range(len(rows)))
        return result + [self._columns_like_first(table[one], rows[one])[0] for one in single]

    def _columns_like_first(
        self, table: npt.NDArray[np.uint8], rows: npt.NDArray[np.intp]
    ) -> tuple[Columns, npt.NDArray[np.bool_]]:
        reader = _Reader(memoryview(table[0].tobytes()), self)
        trace = reader.trace = _Trace()
        message = reader.message(self.name, "")
        same = np.ones(len(table), bool)
        header = [(0, 2)] if self.encoding == "cdr" else []  # says the order of bytes
        for start, end in header + trace.layout:
            same &= (table[:, start:end] == table[0, start:end]).all(axis=1)
        chosen = table[same]
        numbers = {}
        for path, leaf in trace.leaves.items():
            size = leaf.dtype.itemsize * (1 if leaf.count is None else leaf.count)
            cut = np.ascontiguousarray(chosen[:, leaf.offset : leaf.offset + size])
            column = cut.view(leaf.dtype)
            numbers[path] = column[:, 0] if leaf.count is None else column
        return Columns(rows[same], numbers, dict(_texts(message, ""))), same

    def encode(self, message: Mapping[str, Value]) -> bytes:
        """Serialise a message."""
        writer = _Writer(self)
        writer.message(self.name, message, "")
        return bytes(writer.data)

    def encode_columns(
        self, template: Mapping[str, Value], columns: Mapping[str, npt.NDArray[np.generic]]
    ) -> npt.NDArray[np.uint8]:
        """Serialise many messages that differ only in some numbers.

        Args:
            template: A message with all its fields.
            columns: Path -> shape [n] or [n, k].

        Returns:
            One message a row, shape [n, length].

        """
        writer = _Writer(self)
        writer.message(self.name, template, "")
        n = len(next(iter(columns.values())))
        table = np.tile(np.frombuffer(bytes(writer.data), np.uint8), (n, 1))
        for path, column in columns.items():
            leaf = writer.trace.leaves[path]
            values = np.ascontiguousarray(column.astype(leaf.dtype)).view(np.uint8).reshape(n, -1)
            table[:, leaf.offset : leaf.offset + values.shape[1]] = values
        return table


def _texts(value: Value, path: str) -> list[tuple[str, str]]:
    if isinstance(value, str):
        return [(path, value)]
    items: list[tuple[str, Value]] = []
    if isinstance(value, dict):
        items = [(str(name), inner) for name, inner in value.items()]
    elif isinstance(value, list):
        items = [(str(number), inner) for number, inner in enumerate(value)]
    prefix = f"{path}." if path else ""
    return [text for name, inner in items for text in _texts(inner, prefix + name)]


class _Reader:
    """Reads one message from its bytes."""

    def __init__(self, data: memoryview, kind: MessageType) -> None:
        self._data = data
        self._definitions = kind.definitions
        self._cdr = kind.encoding == "cdr"
        self._offset = 0
        self._origin = 0
        self._order: Literal["<", ">"] = "<"
        self.trace: _Trace | None = None
        if self._cdr:
            self._read_cdr_header()

    def _read_cdr_header(self) -> None:
        header = bytes(self._take(len(_CDR_HEADER)))
        if header[0] or header[1] > _CDR_LITTLE_ENDIAN:
            raise UnsupportedInputError(f"CDR representation {header[:2].hex()} is not plain CDR")
        self._order = ">" if header[1] == _CDR_BIG_ENDIAN else "<"
        self._origin = self._offset

    def _take(self, size: int) -> memoryview:
        left = len(self._data) - self._offset
        if size > left:
            raise InputError(
                f"the message ends too early: {size} bytes needed, {left} left",
                location=f"offset {self._offset} of the message",
            )
        part = self._data[self._offset : self._offset + size]
        self._offset += size
        return part

    def _align(self, size: int) -> None:
        if self._cdr and size > 1:
            self._offset += -(self._offset - self._origin) % size

    def _length(self) -> int:
        self._align(4)
        start = self._offset
        (length,) = struct.unpack(self._order + "I", self._take(4))
        if self.trace is not None:
            self.trace.layout.append((start, start + 4))
        return int(length)

    def message(self, name: str, path: str) -> Message:
        prefix = f"{path}." if path else ""
        return {field.name: self._field(field, prefix + field.name) for field in self._definitions[name]}

    def _field(self, field: Field, path: str) -> Value:
        if field.count is None:
            return self._single(field.type, path)
        count = field.count or self._length()
        dtype = PRIMITIVES.get(field.type)
        if dtype is not None:
            return self._numbers(dtype, count, path)
        if count > len(self._data) - self._offset:
            # Each element has at least one byte.
            raise InputError(
                f"{count} elements of {field.type} do not fit into the rest of the message",
                location=f"offset {self._offset} of the message",
            )
        return [self._single(field.type, f"{path}.{number}") for number in range(count)]

    def _single(self, kind: str, path: str) -> Value:
        dtype = PRIMITIVES.get(kind)
        if dtype is not None:
            self._align(dtype.itemsize)
            self._note(path, dtype, None)
            value = np.frombuffer(self._take(dtype.itemsize), dtype.newbyteorder(self._order))[0]
            return bool(value) if kind == "bool" else value.item()
        if kind == "string":
            return self._string()
        return self.message(kind, path)

    def _numbers(self, dtype: np.dtype[np.generic], count: int, path: str) -> npt.NDArray[np.generic]:
        if count:
            self._align(dtype.itemsize)
        self._note(path, dtype, count)
        part = self._take(count * dtype.itemsize)
        return np.frombuffer(part, dtype.newbyteorder(self._order))

    def _string(self) -> str:
        length = self._length()
        start = self._offset
        text = bytes(self._take(length))
        if self.trace is not None:
            self.trace.layout.append((start, self._offset))
        return (text[:-1] if self._cdr and text.endswith(b"\0") else text).decode("utf-8", "replace")

    def _note(self, path: str, dtype: np.dtype[np.generic], count: int | None) -> None:
        if self.trace is not None:
            self.trace.leaves[path] = _Leaf(self._offset, dtype.newbyteorder(self._order), count)


class _Writer:
    """Serialises one message, little endian."""

    def __init__(self, kind: MessageType) -> None:
        self._definitions = kind.definitions
        self._cdr = kind.encoding == "cdr"
        self.data = bytearray(_CDR_HEADER if self._cdr else b"")
        self._origin = len(self.data)
        self.trace = _Trace()

    def _align(self, size: int) -> None:
        if self._cdr and size > 1:
            self.data += bytes(-(len(self.data) - self._origin) % size)

    def _length(self, length: int) -> None:
        self._align(4)
        self.data += struct.pack("<I", length)

    def message(self, name: str, message: Mapping[str, Value], path: str) -> None:
        prefix = f"{path}." if path else ""
        for one in self._definitions[name]:
            self._field(one, message[one.name], prefix + one.name)

    def _field(self, one: Field, value: Value, path: str) -> None:
        if one.count is None:
            self._single(one.type, value, path)
            return
        dtype = PRIMITIVES.get(one.type)
        if dtype is not None:
            array = np.asarray(value, dtype.newbyteorder("<"))
            if not one.count:
                self._length(len(array))
            if len(array):
                self._align(dtype.itemsize)
            self.trace.leaves[path] = _Leaf(len(self.data), array.dtype, len(array))
            self.data += array.tobytes()
            return
        elements = value if isinstance(value, list) else []
        if not one.count:
            self._length(len(elements))
        for number, element in enumerate(elements):
            self._single(one.type, element, f"{path}.{number}")

    def _single(self, kind: str, value: Value, path: str) -> None:
        dtype = PRIMITIVES.get(kind)
        if dtype is not None:
            self._align(dtype.itemsize)
            self.trace.leaves[path] = _Leaf(len(self.data), dtype.newbyteorder("<"), None)
            self.data += np.asarray(value, dtype.newbyteorder("<")).tobytes()
        elif kind == "string":
            text = str(value).encode("utf-8", "surrogateescape") + (b"\0" if self._cdr else b"")
            self._length(len(text))
            self.data += text
        elif isinstance(value, dict):
            self.message(kind, value, path)
