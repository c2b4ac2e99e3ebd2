# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""MRPT's object framing and primitives, over a stream that is read piece by piece.

An object is its class name, a version, a body and an end mark; nothing tells how long it is, so a file
can only be read from its beginning by somebody who knows every class in it. All numbers are little endian.
"""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Final, NoReturn, Protocol, TypeAlias

import numpy as np

from tumtools.errors import InputError

if TYPE_CHECKING:
    import numpy.typing as npt


END_MARK: Final = 0x88
MODERN_MARK: Final = 0x80
"""Set in the first byte of an object, above the length of its name; clear in files before MRPT 0.5.5."""
MAX_NAME: Final = 120
_CLASS_NAME: Final = re.compile(rb"[\w:]+")
MAX_FIELD: Final = 64 * 2**20
"""No field is longer than this many bytes: metres of 16 megapixels."""
MAX_OBJECT: Final = 128 * 2**20
"""No object is: a scan in 4K with its points, colours and depth."""

NULL: Final = "nullptr"
"""Stands for a pointer to no object: no version, no body, an end mark."""
EMPTY: Final = "std::monostate"
"""Stands for an empty variant: no version, no body, no end mark."""
ALIASES: Final = {"CMatrix": "CMatrixF", "CMRPTImage": "CImage", "CSensorialFrame": "CSensoryFrame"}

Array: TypeAlias = np.ndarray[tuple[int, ...], np.dtype[np.generic]]
Value: TypeAlias = "int | float | str | bytes | Array | Record | list[Record] | list[Fields] | dict[int, str]"
"""`bytes` stand for an object that is encoded already; only for writing."""
Fields: TypeAlias = dict[str, Value]


@lru_cache(maxsize=256)
def class_of(name: str) -> str:
    """Return the class that a name stands for: without its namespace, in today's spelling."""
    short = name.rpartition("::")[2]
    return ALIASES.get(short, short)


@dataclass(slots=True, eq=False)
class Record:
    """An object as it is in the file: its fields by name, in the order of the table of its class.

    Attributes:
        name: Class name as written, with or without namespace.
        version: Version of the class; 0 for `NULL` and `EMPTY`.
        fields: Values. Flags are kept as the byte that was read: other values than 0 and 1 occur.
        offset: Where the object begins in the inflated stream.
        old_framing: Written by MRPT before 0.5.5.
        like: An object before it that says the same but for time and file names, if that is known.

    """

    name: str
    version: int
    fields: Fields = field(default_factory=dict)
    offset: int = 0
    old_framing: bool = False
    like: Record | None = None

    @property
    def type(self) -> str:
        """The class, without namespace."""
        return class_of(self.name)

    def __contains__(self, name: str) -> bool:
        return name in self.fields

    def integer(self, name: str, default: int = 0) -> int:
        """Return an integer or flag."""
        value = self.fields.get(name, default)
        return value if isinstance(value, int) else default

    def number(self, name: str, default: float = 0.0) -> float:
        """Return a floating point number."""
        value = self.fields.get(name, default)
        return value if isinstance(value, float) else default

    def text(self, name: str) -> str:
        """Return a string; empty if there is none."""
        value = self.fields.get(name, "")
        return value if isinstance(value, str) else ""

    def array(self, name: str) -> Array:
        """Return an array; empty if there is none."""
        value = self.fields.get(name)
        return value if isinstance(value, np.ndarray) else np.empty(0)

    def child(self, name: str) -> Record | None:
        """Return a nested object, None if there is none."""
        value = self.fields.get(name)
        return value if isinstance(value, Record) else None

    def children(self) -> list[Record]:
        """Return the objects of a collection (`objects`)."""
        value = self.fields.get("objects", [])
        return [item for item in value if isinstance(item, Record)] if isinstance(value, list) else []


class PieceSource(Protocol):
    """Where the bytes come from (`compression.Pieces`)."""

    def next(self) -> bytes:
        """Return the next piece; empty at the end."""

    def bytes_left(self) -> int:
        """Return an upper bound of the bytes that are still to come."""


class Input:
    """A cursor over a stream; every size is checked against the bytes left before memory is taken.

    Args:
        pieces: The inflated bytes, piece by piece.
        path: Name of the file, for messages.

    Attributes:
        context: What is being read, for messages.
        latest: Nested objects by the name of their field, the latest of each: its bytes, and what they say.

    """

    def __init__(self, pieces: PieceSource, path: str) -> None:
        self._pieces = pieces
        self._buffer = memoryview(b"")
        self._position = 0
        self._base = 0
        self._object = 0
        self.path = path
        self.context = ""
        self.latest: dict[str, tuple[bytes, Record]] = {}

    @property
    def offset(self) -> int:
        """Bytes read so far, inflated."""
        return self._base + self._position

    def begin(self, context: str) -> None:
        """Tell that an object begins that stands on its own."""
        self.context = context
        self._object = self.offset

    def fail(self, message: str, hint: str | None = None) -> NoReturn:
        """Raise an error that names the place.

        Raises:
            InputError: Always.

        """
        where = f"{self.context}, offset {self.offset}" if self.context else f"offset {self.offset}"
        raise InputError(message, path=self.path, location=where, hint=hint)

    def at_end(self) -> bool:
        """Tell whether nothing is left."""
        return self._position == len(self._buffer) and not self._refill(1)

    def peek(self, size: int) -> memoryview:
        """Return up to so many of the next bytes without reading them."""
        self._refill(size)
        return self.at_hand(size)

    def at_hand(self, size: int) -> memoryview:
        """Return up to so many of the next bytes without reading them, nor anything from the file."""
        return self._buffer[self._position : self._position + size]

    def take(self, size: int) -> memoryview:
        """Read so many bytes.

        Raises:
            InputError: There are not as many, or more than `MAX_FIELD` are asked for.

        """
        end = self._position + size
        if end > len(self._buffer):
            left = self.bytes_left()
            if size > left:
                self.fail(f"a field of {size} bytes, but at most {left} bytes are left")
            if size > MAX_FIELD:
                self.fail(f"a field of {size} bytes; more than {MAX_FIELD} are not read")
            if self.offset + size - self._object > MAX_OBJECT:
                self.fail(f"an object of more than {MAX_OBJECT} bytes, which are not read")
            if not self._refill(size):
                have = len(self._buffer) - self._position
                self.fail(
                    f"the file ends within an object: {size} bytes expected, {have} left",
                    hint="the file is truncated; with --salvage what is before this object is read",
                )
            end = self._position + size
        view = self._buffer[self._position : end]
        self._position = end
        return view

    def skip(self, data: bytes) -> bool:
        """Read so many bytes if they are these; tell whether they are."""
        end = self._position + len(data)
        if self._buffer[self._position : end] != data:
            return False
        self._position = end
        return True

    def since(self, offset: int) -> bytes:
        """Return what was read since an offset; nothing if it is not all at hand any more."""
        start = offset - self._base
        return bytes(self._buffer[start : self._position]) if start >= 0 else b""

    def bytes_left(self) -> int:
        """Return an upper bound of the bytes left."""
        return len(self._buffer) - self._position + self._pieces.bytes_left()

    def unpack(self, layout: struct.Struct) -> tuple[int | float, ...]:
        """Read numbers."""
        return layout.unpack(self.take(layout.size))

    def array(self, dtype: np.dtype[np.generic], count: int) -> npt.NDArray[np.generic]:
        """Read so many numbers as an array, a view on the bytes."""
        return np.frombuffer(self.take(count * dtype.itemsize), dtype)

    def u8(self) -> int:
        """Read a byte."""
        return self.take(1)[0]

    def u32(self) -> int:
        """Read an unsigned number of 32 bits."""
        return int.from_bytes(self.take(4), "little")

    def text(self) -> str:
        """Read a string; bytes that are no UTF-8 survive a rewriting."""
        return bytes(self.take(self.u32())).decode("utf-8", "surrogateescape")

    def _refill(self, size: int) -> bool:
        """Get at least so many bytes into the buffer; False if the stream ends before."""
        if len(self._buffer) - self._position >= size:
            return True
        rest = self._buffer[self._position :]
        parts, have = [rest] if rest else [], len(rest)
        while have < size and (piece := self._pieces.next()):
            parts.append(memoryview(piece))
            have += len(piece)
        self._base += self._position
        self._position = 0
        self._buffer = parts[0] if len(parts) == 1 else memoryview(b"".join(parts))
        return have >= size


@lru_cache(maxsize=256)
def _class_name(raw: bytes) -> str:
    """Return the name of a class; empty if it cannot be one."""
    return raw.decode("latin-1") if _CLASS_NAME.fullmatch(raw) else ""


@dataclass(frozen=True, slots=True)
class Header:
    """The beginning of an object."""

    name: str
    version: int
    offset: int
    old_framing: bool

    @property
    def has_body(self) -> bool:
        """Whether a version and a body follow the name."""
        return self.name not in {NULL, EMPTY}


def read_header(source: Input) -> Header:
    """Read the name and version that an object begins with.

    Raises:
        InputError: There is no object here.

    """
    offset = source.offset
    first = source.peek(1)
    old = bool(len(first)) and not first[0] & MODERN_MARK
    length = source.u32() if old else source.u8() & ~MODERN_MARK
    if not 0 < length <= MAX_NAME:
        source.fail(f"no object begins here: a class name of {length} letters, expected 1 to {MAX_NAME}")
    raw = bytes(source.take(length))
    name = _class_name(raw)
    if not name:
        source.fail(f"no object begins here: {raw[:40]!r} is no class name")
    if name in {NULL, EMPTY}:
        return Header(name, 0, offset, old)
    return Header(name, source.u32() if old else source.u8(), offset, old)


def read_end(source: Input, header: Header) -> None:
    """Read the mark that an object ends with.

    Raises:
        InputError: It is not there.

    """
    if header.old_framing or header.name == EMPTY:
        return
    mark = source.u8()
    if mark != END_MARK:
        source.fail(
            f"{header.name} (version {header.version}, began at offset {header.offset}) should end with "
            f"byte 0x88, found 0x{mark:02x}",
            hint="the file is damaged before this place, or its MRPT has another layout of the class",
        )


def header_bytes(record: Record) -> bytes:
    """Return the bytes that an object begins with."""
    name = record.name.encode("latin-1")
    has_version = record.name not in {NULL, EMPTY}
    if record.old_framing:
        start = struct.pack("<I", len(name)) + name
        return start + struct.pack("<I", record.version) if has_version else start
    start = bytes([MODERN_MARK | len(name)]) + name
    return start + bytes([record.version]) if has_version else start


def end_bytes(record: Record) -> bytes:
    """Return the bytes that an object ends with."""
    return b"" if record.old_framing or record.name == EMPTY else bytes([END_MARK])


def text_bytes(text: str) -> bytes:
    """Return a string as it is written."""
    data = text.encode("utf-8", "surrogateescape")
    return struct.pack("<I", len(data)) + data
