# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Pages of a mapped file count as memory of the process: give them back now and then."""

from __future__ import annotations

import mmap
from typing import Final

_PIECE: Final = 64 * 1024
"""What Linux maps when a single byte is read (`fault_around_bytes`)."""
_MOST_PIECES: Final = 24 * 2**20 // _PIECE


class Pages:
    """Gives the pages of a mapped file back after some have been read; those that are read again come back.

    Args:
        mapped: The file.

    """

    def __init__(self, mapped: mmap.mmap) -> None:
        self._map = mapped
        self._pieces = 0
        self._latest = -1

    def read(self, offset: int, nbytes: int) -> None:
        """Note that so many bytes are read from an offset on."""
        first, last = offset // _PIECE, (offset + nbytes) // _PIECE
        self._pieces += last - first + (first != self._latest)
        self._latest = last
        if self._pieces > _MOST_PIECES:
            self._map.madvise(mmap.MADV_DONTNEED)
            self._pieces, self._latest = 0, -1
