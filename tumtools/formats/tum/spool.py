# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The content of a compressed file, inflated once into a temporary file without a name.

One pass with ISA-L, and then any place is read at once, in whatever order the members lie. That takes as
much of the disk as the unpacked files, for as long as the process lives: even a killed one leaves nothing.
"""

from __future__ import annotations

import errno
import os
import shutil
import tempfile
from typing import TYPE_CHECKING, Final

from tumtools.formats.tum.inflate import BLOCK, Cursor, RandomAccess
from tumtools.images.parallel import read_ahead

if TYPE_CHECKING:
    from collections.abc import Generator
    from pathlib import Path

_WAITING: Final = 8
"""Blocks that are inflated ahead of the pass."""
_MAX_RATIO: Final = 4
"""PNG files hardly become smaller, so what inflates to more than this is nothing to fill a disk with."""
_ALLOWANCE: Final = 1 << 26
_NO_ROOM: Final = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}


class NoRoomError(Exception):
    """There is no room for the content; it has to be read without a spool."""


class SpooledStream:
    """The uncompressed content of a gzip or zstd file; safe to use from several threads after the pass.

    Args:
        path: The compressed file.
        folder: Where the temporary file goes.

    Raises:
        NoRoomError: The folder cannot take the content and as much again, for what is made of it.

    """

    def __init__(self, path: Path, folder: Path) -> None:
        self.scanned = 0
        self._spooled = 0
        size = path.stat().st_size
        self._limit = _MAX_RATIO * size + _ALLOWANCE
        try:
            if shutil.disk_usage(folder).free < 3 * size:
                raise NoRoomError
            self._spool = tempfile.TemporaryFile(dir=folder, buffering=0)  # noqa: SIM115 - `close` closes it
        except OSError as error:
            raise NoRoomError from error
        self._blocks = read_ahead(_inflate(path), _WAITING)

    def scan(self, size: int) -> bytes:
        """Return the next bytes of the pass.

        Raises:
            InputError: The compressed data is damaged or cut off.
            NoRoomError: The disk is full, or the content is out of all proportion.

        """
        self._advance(self.scanned + size)
        data = self.read_at(self.scanned, size)
        self.scanned += len(data)
        return data

    def skip_scan(self, position: int) -> None:
        """Move the pass forward, not beyond the end; see `scan`."""
        self._advance(position)
        self.scanned = min(position, self._spooled)

    def _advance(self, position: int) -> None:
        """Spool at least up to a position."""
        while self._spooled < position and (block := next(self._blocks, b"")):
            if self._spooled + len(block) > self._limit:
                raise NoRoomError
            try:
                _write(self._spool.fileno(), block)
            except OSError as error:
                if error.errno in _NO_ROOM:
                    raise NoRoomError from error
                raise
            self._spooled += len(block)

    def read_at(self, offset: int, size: int) -> bytes:
        """Return bytes of the uncompressed stream; none behind what the pass has reached."""
        return os.pread(self._spool.fileno(), size, offset)

    def close(self) -> None:
        """Give the room back."""
        self._blocks.close()
        self._spool.close()


def _inflate(path: Path) -> Generator[bytes, None, None]:
    file = RandomAccess(path)
    try:
        cursor = Cursor(file, copies=False)
        while block := cursor.read(BLOCK):
            yield block
    finally:
        file.close()


def _write(descriptor: int, block: bytes) -> None:
    done = os.write(descriptor, block)
    while done < len(block):  # a full disk, which the next call tells
        done += os.write(descriptor, block[done:])
