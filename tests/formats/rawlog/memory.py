# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Read objects from bytes instead of a file."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tumtools.formats.rawlog.archive import Input, Record
from tumtools.formats.rawlog.classes import CODEC
from tumtools.formats.rawlog.objects import top_level

if TYPE_CHECKING:
    from collections.abc import Iterator


class InMemory:
    """Pieces of bytes that are there already, one byte more each time."""

    def __init__(self, data: bytes) -> None:
        self._left = data
        self._size = 1

    def next(self) -> bytes:
        piece, self._left = self._left[: self._size], self._left[self._size :]
        self._size += 1
        return piece

    def bytes_left(self) -> int:
        return len(self._left)


def records_of(data: bytes, *, flat: bool = True) -> Iterator[Record]:
    """Yield the objects; a whole-file object as what it contains unless `flat` is False."""
    source = Input(InMemory(data), "memory")
    if flat:
        yield from top_level(source)
        return
    while not source.at_end():
        yield CODEC.read(source)
