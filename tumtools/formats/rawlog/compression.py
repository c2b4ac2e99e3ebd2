# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""gzip, Zstandard or nothing around a rawlog and each of its external files, told by their first bytes."""

from __future__ import annotations

import os
import stat
import zlib
from contextlib import suppress
from io import BytesIO
from typing import IO, TYPE_CHECKING, Final, Literal, Protocol

import zstandard
from isal import isal_zlib
from isal.igzip_lib import IsalError

from tumtools.errors import InputError, MissingInputError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

Container = Literal["gzip", "zstd", "none"]
CONTAINERS: Final[tuple[Container, ...]] = ("gzip", "zstd", "none")

_GZIP_MAGIC: Final = b"\x1f\x8b"
_ZSTD_MAGIC: Final = b"\x28\xb5\x2f\xfd"
_CHUNK: Final = 256 * 1024
_STEP: Final = 1024
"""What is inflated at a time next to damage; what comes before it in one step is lost."""
_GZIP: Final = 31
"""zlib's window bits for the largest window inside a gzip member."""
_LARGEST_RATIO: Final = {"none": 1, "gzip": 1032, "zstd": 2**16}
"""Inflated bytes that a compressed byte can at most stand for (deflate: 258 bytes in 2 bits;
Zstandard: a block of 128 KiB in 4 bytes)."""
_MOST_MEMBERS: Final = 100
"""Of the gzip file of an image."""
_ZSTD_WINDOW: Final = 64 * 2**20
_OPEN: Final[int] = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)


def sniff(head: bytes | memoryview) -> Container:
    """Tell the compression from the first four bytes."""
    start = bytes(head[:4])
    if start[:2] == _GZIP_MAGIC:
        return "gzip"
    return "zstd" if start == _ZSTD_MAGIC else "none"


def _end_of_gzip_header(data: bytes) -> int:
    """Return where the compressed data of a gzip member begins (RFC 1952, section 2.3)."""
    flags, end = data[3], 10
    if flags & 4:  # extra field
        end += 2 + int.from_bytes(data[end : end + 2], "little")
    for flag in (8, 16):  # name, comment
        if flags & flag:
            end = data.find(b"\0", end) + 1 or len(data)
    return end + (2 if flags & 2 else 0)


class Pieces:
    """The inflated bytes of a file, in pieces of bounded size.

    gzip may consist of several members, and end with zeros. What else follows a member is damage: the header
    of the next one may have been hit, and gzip itself would pass over the rest without a word.

    Attributes:
        container: The compression that was found.
        size: Bytes of the file as it is stored.

    Raises:
        MissingInputError: There is no such file.
        InputError: The file cannot be opened, or its compression is damaged.

    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._file = open_file(path)
        self.size = os.fstat(self._file.fileno()).st_size
        self.container: Container = sniff(self._file.read(4))
        self._file.seek(0)
        reader = {"gzip": self._gzip, "zstd": self._zstd, "none": self._plain}[self.container]
        self._iterator: Iterator[bytes] = reader()

    def next(self) -> bytes:
        """Return the next piece; empty at the end."""
        try:
            return next(self._iterator, b"")
        except (IsalError, zstandard.ZstdError, EOFError) as error:  # type: ignore[misc]  # its stub is wrong
            raise InputError(
                f"damaged {self.container} data ({error})",
                path=self.path,
                location=f"before offset {self._file.tell()} of the file",
                hint="fetch or copy the file again; --salvage reads what comes before the damage",
            ) from error
        except OSError as error:
            raise InputError(f"cannot be read ({error.strerror})", path=self.path) from error

    def bytes_left(self) -> int:
        """Return an upper bound of the bytes that are still to come."""
        if self._file.closed:
            return 0
        return (self.size - self._file.tell() + 2 * _CHUNK) * _LARGEST_RATIO[self.container]

    def close(self) -> None:
        """Close the file."""
        self._iterator = iter(())
        self._file.close()

    def _plain(self) -> Iterator[bytes]:
        while piece := self._file.read(_CHUNK):
            yield piece

    def _gzip(self) -> Iterator[bytes]:
        data = self._file.read(_CHUNK)
        while data[:2] == _GZIP_MAGIC:
            begin = self._file.tell() - len(data)
            member, given = isal_zlib.decompressobj(_GZIP), 0
            while not member.eof:
                data = data or self._file.read(_CHUNK)
                try:
                    piece = member.decompress(data, _CHUNK)
                except IsalError:  # type: ignore[misc]  # its stub is wrong
                    yield from self._to_the_damage(begin, given)
                    raise
                if not (piece or data or member.eof):
                    raise EOFError("the data ends before the end of the gzip member")
                if piece:
                    given += len(piece)
                    yield piece
                data = member.unconsumed_tail
            data = member.unused_data or self._file.read(_CHUNK)
            if len(data) == 1:
                data += self._file.read(_CHUNK)
        place = self._file.tell() - len(data)
        while data:
            if data.strip(b"\0"):
                raise InputError(
                    "what follows a gzip member is neither another one nor zeros to the end of the file",
                    path=self.path,
                    location=f"offset {place} of the file",
                    hint="fetch or copy the file again; --salvage reads what comes before the damage",
                )
            data = self._file.read(_CHUNK)

    def _to_the_damage(self, begin: int, given: int) -> Iterator[bytes]:
        """Inflate what an inflater has dropped that found damage, and leave out what it has given before.

        Args:
            begin: Where the gzip member begins in the file.
            given: Bytes of it that have been given.

        """
        with open_file(self.path) as file:
            file.seek(begin)
            head = file.read(_CHUNK)
            start = _end_of_gzip_header(head)
            inflater, data = zlib.decompressobj(-zlib.MAX_WBITS), head[start:]
            parts: list[bytes] = []
            try:
                while data and not inflater.eof:
                    piece = inflater.decompress(data, min(given, _CHUNK) or _STEP)
                    parts.append(piece[given:])
                    given = max(0, given - len(piece))
                    data = inflater.unconsumed_tail or file.read(_STEP)
            except zlib.error:
                pass
        yield b"".join(parts)

    def _zstd(self) -> Iterator[bytes]:
        given = 0
        with _zstd_reader(self._file) as reader:
            try:
                while piece := reader.read(_CHUNK):
                    given += len(piece)
                    yield piece
            except zstandard.ZstdError:
                yield from self._to_the_zstd_damage(given)
                raise
        # The reader of zstandard says nothing when the last frame is cut off; the rawlog's framing does.
        if not given and self.size:
            raise EOFError("the data ends before the first block is whole")

    def _to_the_zstd_damage(self, given: int) -> Iterator[bytes]:
        """Read what the reader has dropped that found damage, and leave out what it has given before."""
        with open_file(self.path) as file, _zstd_reader(file) as reader, suppress(zstandard.ZstdError):
            while given > 0 and (piece := reader.read(min(given, _CHUNK))):
                given -= len(piece)
            while piece := reader.read1(_STEP):
                yield piece


def open_file(path: str | Path) -> IO[bytes]:
    """Open a file for reading; a pipe or a device is none, and opening it must not wait for anybody.

    Raises:
        MissingInputError: There is no such file.
        InputError: It cannot be opened, or is no regular file.

    """
    try:
        file = os.fdopen(os.open(path, _OPEN), "rb")
    except FileNotFoundError as error:
        raise MissingInputError("there is no such file", path=path) from error
    except OSError as error:
        raise InputError(f"cannot be opened ({error.strerror})", path=path) from error
    if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
        file.close()
        raise InputError("this is no file but a pipe or a device", path=path, hint="save it to a file first")
    return file


def read_file(path: str | Path, most: int | None = None) -> bytes:
    """Read a file at once, up to one byte more than `most`; raises as `open_file` does."""
    with open_file(path) as file:
        size = os.fstat(file.fileno()).st_size
        try:
            return file.read((size if most is None else min(size, most)) + 1)  # its memory is taken at once
        except OSError as error:
            raise InputError(f"cannot be read ({error.strerror})", path=path) from error


class Content:
    """The content of a small file that has been read, inflated piece by piece.

    Args:
        data: The file.
        path: Of the file, for messages.

    """

    def __init__(self, data: bytes, path: str | Path) -> None:
        self._path = path
        self._reader: _Reader
        match sniff(data):
            case "gzip":
                self._reader = _GzipMembers(data)
            case "zstd":
                self._reader = _zstd_reader(data)
            case _:
                self._reader = BytesIO(data)

    def read(self, size: int) -> bytes:
        """Return so many of the next bytes, at least one; fewer at the end.

        Raises:
            InputError: The compression is damaged.

        """
        try:
            return self._reader.read(size)
        except (IsalError, zstandard.ZstdError, EOFError) as error:  # type: ignore[misc]  # its stub is wrong
            what = f"damaged compression ({error})"
            raise InputError(what, path=self._path, hint="copy the file again") from error


class _Reader(Protocol):
    def read(self, size: int, /) -> bytes: ...


class _GzipMembers:
    """The members of a gzip file; their sizes and checksums are checked where they end."""

    def __init__(self, data: bytes) -> None:
        self._inflater, self._rest = isal_zlib.decompressobj(_GZIP), data
        self._members = 1

    def read(self, size: int) -> bytes:
        parts: list[bytes] = []
        while size and not (self._inflater.eof and not self._next_member()):
            piece = self._inflater.decompress(self._rest, size)
            self._rest = self._inflater.unconsumed_tail
            if not (piece or self._inflater.eof):
                raise EOFError("the data ends before the end of the gzip member")
            parts.append(piece)
            size -= len(piece)
        return parts[0] if len(parts) == 1 else b"".join(parts)

    def _next_member(self) -> bool:
        """Go on with another member; tell whether there is one."""
        rest = self._inflater.unused_data
        if not rest.strip(b"\0"):
            return False
        if not rest.startswith(_GZIP_MAGIC):
            raise EOFError(
                "what follows a gzip member is neither another one nor zeros to the end of the file"
            )
        if self._members == _MOST_MEMBERS:
            raise EOFError(f"more than {_MOST_MEMBERS} gzip members")
        self._members += 1
        self._inflater, self._rest = isal_zlib.decompressobj(_GZIP), rest
        return True


def _zstd_reader(source: IO[bytes] | bytes) -> zstandard.ZstdDecompressionReader:
    inflater = zstandard.ZstdDecompressor(max_window_size=_ZSTD_WINDOW)
    return inflater.stream_reader(source, read_across_frames=True, closefd=False)


class Deflater(Protocol):
    """What compresses a stream."""

    def compress(self, data: bytes, /) -> bytes:
        """Take bytes in, give compressed ones as they get ready."""

    def flush(self) -> bytes:
        """Give what is left."""


def _zstd_compressor() -> zstandard.ZstdCompressor:
    # Without a checksum, which zstd leaves out unless told, other numbers come out of damaged data.
    return zstandard.ZstdCompressor(level=1, write_checksum=True)


class _Stored:
    def compress(self, data: bytes, /) -> bytes:
        return data

    def flush(self) -> bytes:
        return b""


def deflater(container: Container) -> Deflater:
    """Return a compressor for a rawlog; gzip is byte for byte what MRPT writes (zlib, level 1)."""
    match container:
        case "gzip":
            return zlib.compressobj(1, zlib.DEFLATED, _GZIP, 8, zlib.Z_DEFAULT_STRATEGY)
        case "zstd":
            return _zstd_compressor().compressobj()
        case _:
            return _Stored()


def deflate(data: bytes | memoryview, container: Container) -> bytes:
    """Compress an external file."""
    match container:
        case "gzip":
            packed: bytes = isal_zlib.compress(data, 1, _GZIP)
            return packed
        case "zstd":
            return _zstd_compressor().compress(data)
        case _:
            return bytes(data)
