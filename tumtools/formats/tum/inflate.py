# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Random access to the content of a compressed file, forward fast, backward from checkpoints.

The first pass over a gzip file keeps copies of the decompressor every few megabytes (about 40 kB each),
so that later reads start near their place. Zstandard offers no copies: reading backward starts again,
and what is read in no order at all is unpacked to a temporary file once.
"""

from __future__ import annotations

import os
import tempfile
import zlib
from bisect import bisect_right
from threading import Lock
from typing import IO, TYPE_CHECKING, Final, Protocol

import zstandard
from isal import isal_zlib
from isal.igzip_lib import IsalError

from tumtools.errors import InputError

if TYPE_CHECKING:
    from pathlib import Path

GZIP_MAGIC: Final = b"\x1f\x8b"
ZSTD_MAGIC: Final = b"\x28\xb5\x2f\xfd"

_MAX_OUTPUT: Final = 1 << 18
BLOCK: Final = 1 << 18
_MAX_CHECKPOINTS: Final = 256
_MIN_SPACING: Final = 1 << 21
_MAX_CURSORS: Final = 4
_MAX_RESTARTS: Final = 8
_GZIP_WINDOW: Final = 31


class RandomAccess:
    """A file that several threads read at offsets of their own; no mapping, which would count as memory."""

    def __init__(self, path: Path) -> None:
        self.path = str(path)
        self._descriptor = os.open(path, os.O_RDONLY)
        self.size = os.fstat(self._descriptor).st_size

    def read_at(self, offset: int, size: int) -> bytes:
        """Return the bytes at an offset; fewer at the end of the file."""
        return os.pread(self._descriptor, size, offset)

    def close(self) -> None:
        """Close the file, if it is open."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1


class _Inflater(Protocol):
    """A decompressor that says how much it has taken."""

    block: int
    """Bytes to feed at a time."""

    @property
    def eof(self) -> bool: ...

    def step(self, block: bytes) -> tuple[bytes, int]:
        """Return a bounded piece of output, and how many bytes of the block were used for it."""

    def copy(self) -> _Inflater | None: ...


class _Igzip:
    """Inflate of ISA-L, which takes three quarters of the time of zlib's, and offers no copies."""

    block = 1 << 18

    def __init__(self, inflate: zlib._Decompress | None = None) -> None:
        self._inflate = inflate or isal_zlib.decompressobj(_GZIP_WINDOW)

    @property
    def eof(self) -> bool:
        return self._inflate.eof

    def step(self, block: bytes) -> tuple[bytes, int]:
        data = self._inflate.decompress(block, _MAX_OUTPUT)
        left = self._inflate.unused_data if self._inflate.eof else self._inflate.unconsumed_tail
        return data, len(block) - len(left)

    def copy(self) -> _Gzip | None:
        return None


class _Gzip(_Igzip):
    """Inflate of zlib."""

    def __init__(self, inflate: zlib._Decompress | None = None) -> None:
        self._copyable = inflate or zlib.decompressobj(_GZIP_WINDOW)
        super().__init__(self._copyable)

    def copy(self) -> _Gzip:
        return _Gzip(self._copyable.copy())


class _Zstd:
    # Its output cannot be limited: the few bytes that make a block of 128 kB are fed sparingly instead.
    block = 1 << 10

    def __init__(self) -> None:
        self._inflate = zstandard.ZstdDecompressor().decompressobj()

    @property
    def eof(self) -> bool:
        return self._inflate.eof

    def step(self, block: bytes) -> tuple[bytes, int]:
        data = self._inflate.decompress(block)
        return data, len(block) - (len(self._inflate.unused_data) if self._inflate.eof else 0)

    def copy(self) -> None:
        return None


class Cursor:
    """A place in the uncompressed stream, moving forward.

    Args:
        file: The compressed file.
        copies: Whether checkpoints are wanted, which the fastest decompressor cannot make.

    Attributes:
        position: Offset in the uncompressed stream.

    """

    def __init__(self, file: RandomAccess, *, copies: bool = True) -> None:
        self._file = file
        gzip = _Gzip if copies else _Igzip
        self._kind: type[_Igzip | _Zstd] = gzip if file.read_at(0, 2) == GZIP_MAGIC else _Zstd
        self._inflate: _Inflater = self._kind()
        self._in = 0
        self._buffer = b""
        self._used = 0
        self.position = 0

    def checkpoint(self) -> Cursor | None:
        """Return an independent cursor at the end of what has been inflated, None if there can be none."""
        inflate = self._inflate.copy()
        if inflate is None:
            return None
        other = Cursor(self._file)
        other._inflate, other._in = inflate, self._in
        other.position = self.position + len(self._buffer) - self._used
        return other

    @property
    def compressed_position(self) -> int:
        """Offset in the file."""
        return self._in

    def read(self, size: int) -> bytes:
        """Return the next bytes; fewer only at the end of the stream.

        Raises:
            InputError: The compressed data is damaged or cut off.

        """
        parts = []
        while size > 0 and (self._used < len(self._buffer) or self._fill()):
            part = self._buffer[self._used : self._used + size]
            parts.append(part)
            size -= len(part)
            self._used += len(part)
            self.position += len(part)
        return parts[0] if len(parts) == 1 else b"".join(parts)

    def skip_to(self, position: int) -> None:
        """Move forward, not beyond the end."""
        while self.position < position and (self._used < len(self._buffer) or self._fill()):
            step = min(position - self.position, len(self._buffer) - self._used)
            self._used += step
            self.position += step

    def _fill(self) -> bool:
        """Inflate the next piece; False at the end of the stream."""
        self._buffer, self._used = b"", 0
        try:
            while not self._buffer:
                if self._inflate.eof:
                    if self._is_at_end():
                        return False
                    self._inflate = self._kind()
                block = self._file.read_at(self._in, self._inflate.block)
                self._buffer, used = self._inflate.step(block)
                self._in += used
                if not block and not self._buffer:
                    raise InputError(
                        "the compressed data ends too early",
                        path=self._file.path,
                        location=f"offset {self._in}",
                        hint="the file was cut off; get it again",
                    )
        except (zlib.error, IsalError, zstandard.ZstdError) as error:  # type: ignore[misc]  # see images.png
            raise InputError(
                f"the compressed data is damaged: {error}",
                path=self._file.path,
                location=f"near offset {self._in}",
            ) from error
        return True

    def _is_at_end(self) -> bool:
        """Tell whether nothing follows but padding, which is zeros; another gzip member or zstd frame may."""
        offset = self._in
        while block := self._file.read_at(offset, BLOCK):
            if rest := block.lstrip(b"\0"):
                offset += len(block) - len(rest)
                if offset == self._in:
                    return False
                raise InputError(
                    "there is data behind the zeros that end the compressed data",
                    path=self._file.path,
                    location=f"offset {offset}",
                    hint="the file was damaged; get it again",
                )
            offset += len(block)
        return True


class SeekableStream:
    """The uncompressed content of a gzip or zstd file; safe to use from several threads."""

    def __init__(self, path: Path) -> None:
        self._file = RandomAccess(path)
        self._spacing = max(_MIN_SPACING, self._file.size // _MAX_CHECKPOINTS)
        self._checkpoints: list[Cursor] = []
        self._offsets: list[int] = []
        self._cursors: list[Cursor] = []
        self._lock = Lock()
        self._scan = Cursor(self._file)
        self._restarts = 0
        self._unpacked: IO[bytes] | None = None

    def scan(self, size: int) -> bytes:
        """Return the next bytes of the first pass, keeping checkpoints on the way."""
        last = self._checkpoints[-1].compressed_position if self._checkpoints else 0
        if self._scan.compressed_position - last >= self._spacing:
            checkpoint = self._scan.checkpoint()
            if checkpoint is not None:
                self._checkpoints.append(checkpoint)
                self._offsets.append(checkpoint.position)
        return self._scan.read(size)

    def skip_scan(self, position: int) -> None:
        """Move the first pass forward, keeping checkpoints on the way."""
        while self._scan.position < position:
            if not self.scan(min(BLOCK, position - self._scan.position)):
                return

    @property
    def scanned(self) -> int:
        """Offset that the first pass has reached."""
        return self._scan.position

    def read_at(self, offset: int, size: int) -> bytes:
        """Return bytes of the uncompressed stream."""
        with self._lock:
            if self._unpacked is not None:
                return os.pread(self._unpacked.fileno(), size, offset)
            cursor = self._take_cursor(offset)
        if cursor is None:
            self._unpack()
            return self.read_at(offset, size)
        cursor.skip_to(offset)
        data = cursor.read(size)
        with self._lock:
            self._cursors.append(cursor)
            del self._cursors[:-_MAX_CURSORS]
        return data

    def _take_cursor(self, offset: int) -> Cursor | None:
        """Return the nearest cursor at or before the offset: one in use before, or a checkpoint.

        None if reading from the beginning time and again would not come to an end.
        """
        before = [cursor for cursor in self._cursors if cursor.position <= offset]
        nearest = max(before, key=lambda cursor: cursor.position, default=None)
        number = bisect_right(self._offsets, offset) - 1
        if number >= 0 and (nearest is None or self._offsets[number] > nearest.position):
            return self._checkpoints[number].checkpoint()
        if nearest is not None:
            self._cursors.remove(nearest)
            return nearest
        self._restarts += 1
        # Two image streams in alphabetical order take two; a gzip file has its first checkpoint soon.
        if self._restarts > _MAX_RESTARTS and not self._checkpoints and self._file.size > _MIN_SPACING:
            return None
        return Cursor(self._file)

    def _unpack(self) -> None:
        """Unpack all into a file without a name, for members in an order that suits no cursor."""
        with self._lock:
            if self._unpacked is not None:
                return
            cursor = Cursor(self._file)
            try:
                file = tempfile.TemporaryFile()  # noqa: SIM115 - `close` closes it
                self._unpacked = file
                while data := cursor.read(BLOCK):
                    file.write(data)
                file.flush()
            except OSError as error:
                raise InputError(
                    f"its members are in no order of time, and it cannot be unpacked to "
                    f"{tempfile.gettempdir()}: {error.strerror}",
                    path=self._file.path,
                    hint="unpack it yourself and name the folder",
                ) from error

    def close(self) -> None:
        """Close the file and forget all cursors."""
        self._file.close()
        if self._unpacked is not None:
            self._unpacked.close()
        self._cursors.clear()
        self._checkpoints.clear()
