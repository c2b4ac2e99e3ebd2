# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Random access to the content of a compressed file, forward fast, backward from checkpoints.

The first pass over a gzip file keeps copies of the decompressor every few megabytes (about 40 kB each),
so that later reads start near their place. Zstandard offers no copies: reading backward starts again.
"""

from __future__ import annotations

import mmap
import zlib
from bisect import bisect_right
from threading import Lock
from typing import TYPE_CHECKING, Final, Protocol

import zstandard

from tumtools.errors import InputError

if TYPE_CHECKING:
    from pathlib import Path

GZIP_MAGIC: Final = b"\x1f\x8b"
ZSTD_MAGIC: Final = b"\x28\xb5\x2f\xfd"

_BLOCK: Final = 1 << 18
_MAX_CHECKPOINTS: Final = 256
_MIN_SPACING: Final = 1 << 21
_MAX_CURSORS: Final = 4
_GZIP_WINDOW: Final = 31


class _Decompressor(Protocol):
    """What zlib's and zstandard's decompression objects have in common."""

    @property
    def eof(self) -> bool: ...
    @property
    def unused_data(self) -> bytes: ...
    def decompress(self, data: bytes, /) -> bytes: ...


class Cursor:
    """A place in the uncompressed stream, moving forward.

    Attributes:
        position: Offset in the uncompressed stream.

    """

    def __init__(self, path: str, data: memoryview) -> None:
        self._path = path
        self._data = data
        self._gzip = bytes(data[:2]) == GZIP_MAGIC
        self._in = 0
        self._buffer = b""
        self._inflate: _Decompressor = self._new()
        self.position = 0

    def _new(self) -> _Decompressor:
        return (
            zlib.decompressobj(_GZIP_WINDOW) if self._gzip else zstandard.ZstdDecompressor().decompressobj()
        )

    def copy(self) -> Cursor | None:
        """Return an independent cursor at the same place, or None if the compression has none."""
        if not self._gzip:
            return None
        other = Cursor.__new__(Cursor)
        other.__dict__.update(self.__dict__)
        other._inflate = self._inflate.copy()  # type: ignore[attr-defined]  # gzip's has it  # noqa: SLF001
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
        while size > 0:
            if not self._buffer and not self._fill():
                break
            part, self._buffer = self._buffer[:size], self._buffer[size:]
            parts.append(part)
            size -= len(part)
            self.position += len(part)
        return parts[0] if len(parts) == 1 else b"".join(parts)

    def skip_to(self, position: int) -> None:
        """Move forward."""
        while self.position < position and (self._buffer or self._fill()):
            step = min(position - self.position, len(self._buffer))
            self._buffer = self._buffer[step:]
            self.position += step

    def _fill(self) -> bool:
        """Inflate the next block; False at the end of the stream."""
        try:
            while not self._buffer:
                if self._inflate.eof:
                    # Another gzip member or zstd frame may follow; zeros are padding.
                    self._in -= len(self._inflate.unused_data)
                    if not bytes(self._data[self._in : self._in + 4]).strip(b"\0"):
                        return False
                    self._inflate = self._new()
                block = bytes(self._data[self._in : self._in + _BLOCK])
                if not block:
                    raise InputError(
                        "the compressed data ends too early",
                        path=self._path,
                        location=f"offset {self._in}",
                        hint="the file was cut off; get it again",
                    )
                self._in += len(block)
                self._buffer = self._inflate.decompress(block)
        except (zlib.error, zstandard.ZstdError) as error:
            raise InputError(
                f"the compressed data is damaged: {error}",
                path=self._path,
                location=f"near offset {self._in}",
            ) from error
        return True


class SeekableStream:
    """The uncompressed content of a gzip or zstd file; safe to use from several threads."""

    def __init__(self, path: Path) -> None:
        with path.open("rb") as file:
            self._map = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        self._path = str(path)
        self._data = memoryview(self._map)
        self._spacing = max(_MIN_SPACING, len(self._data) // _MAX_CHECKPOINTS)
        self._checkpoints: list[Cursor] = []
        self._offsets: list[int] = []
        self._cursors: list[Cursor] = []
        self._lock = Lock()
        self._scan = Cursor(self._path, self._data)

    def scan(self, size: int) -> bytes:
        """Return the next bytes of the first pass, keeping checkpoints on the way."""
        last = self._checkpoints[-1].compressed_position if self._checkpoints else 0
        if self._scan.compressed_position - last >= self._spacing:
            copy = self._scan.copy()
            if copy is not None:
                self._checkpoints.append(copy)
                self._offsets.append(copy.position)
        return self._scan.read(size)

    def skip_scan(self, position: int) -> None:
        """Move the first pass forward, keeping checkpoints on the way."""
        while self._scan.position < position:
            if not self.scan(min(_BLOCK, position - self._scan.position)):
                return

    @property
    def scanned(self) -> int:
        """Offset that the first pass has reached."""
        return self._scan.position

    def read_at(self, offset: int, size: int) -> bytes:
        """Return bytes of the uncompressed stream."""
        with self._lock:
            cursor = self._take_cursor(offset)
        cursor.skip_to(offset)
        data = cursor.read(size)
        with self._lock:
            self._cursors.append(cursor)
            del self._cursors[:-_MAX_CURSORS]
        return data

    def _take_cursor(self, offset: int) -> Cursor:
        """Return the nearest cursor at or before the offset: one in use before, or a checkpoint."""
        before = [cursor for cursor in self._cursors if cursor.position <= offset]
        nearest = max(before, key=lambda cursor: cursor.position, default=None)
        number = bisect_right(self._offsets, offset) - 1
        if number >= 0 and (nearest is None or self._offsets[number] > nearest.position):
            copy = self._checkpoints[number].copy()
            if copy is not None:
                return copy
        if nearest is not None:
            self._cursors.remove(nearest)
            return nearest
        return Cursor(self._path, self._data)

    def close(self) -> None:
        """Forget all cursors; the mapping goes with the last view of it."""
        self._cursors.clear()
        self._checkpoints.clear()
