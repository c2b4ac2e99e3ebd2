# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Scans that are like the one before but for their time and the names of their files.

All the rest of them is the same in a recording, byte by byte. To see that takes a tenth of the time that
reading them field by field takes.
"""

from __future__ import annotations

import struct
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from tumtools.formats.rawlog.archive import Record, text_bytes

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tumtools.formats.rawlog.archive import Input

_SCAN: Final = "CObservation3DRangeScan"
_TIME, _DEPTH_FILE, _IMAGE_FILE = "time", "range_file", "file"
_TICKS: Final = struct.Struct("<Q")
_LENGTH_BYTES: Final = 4
"""Before the letters of a text."""
_MOST_BYTES: Final = 4096
"""Of a scan that is remembered; one with its images in it is larger, and never like another."""


class Alike:
    """Remembers the latest scan, and reads the next one if it is like that."""

    def __init__(self) -> None:
        self._record = Record("", 0)
        self._places: dict[str, slice] = {}
        self._same: list[tuple[slice, bytes]] = []
        self._size = 0

    def remember(self, source: Input, record: Record) -> None:
        """Compare what follows with this object, which has just been read, if it is a scan."""
        if record.type != _SCAN:
            return
        self._size = 0
        size = source.offset - record.offset
        data = source.since(record.offset) if size <= _MOST_BYTES else b""
        places = {}
        for name, encoded, begin in _varying(record):
            place = data.find(encoded)
            if place < 0 or data.rfind(encoded) != place:
                return  # nobody knows which of them is the field
            places[name] = slice(place + begin, place + len(encoded))
        ends = sorted(end for place in places.values() for end in (place.start, place.stop))
        same = [slice(*between) for between in zip([0, *ends[1::2]], [*ends[::2], size], strict=True)]
        self._record, self._places, self._size = record, places, size
        self._same = [(place, data[place]) for place in same]

    def read(self, source: Input) -> Record | None:
        """Read the next object if it is a scan like the latest one."""
        if not self._size:
            return None
        data = bytes(source.at_hand(self._size))
        for place, same in self._same:
            if data[place] != same:
                return None
        known = self._record
        record = replace(known, fields=known.fields.copy(), offset=source.offset, like=known)
        image = known.child("intensity")
        if image is not None:
            moved = image.offset + record.offset - known.offset
            image = record.fields["intensity"] = replace(image, fields=image.fields.copy(), offset=moved)
        for name, place in self._places.items():
            if name == _TIME:
                record.fields[name] = _TICKS.unpack(data[place])[0]
            else:
                holder = record if name == _DEPTH_FILE or image is None else image
                holder.fields[name] = data[place].decode("utf-8", "surrogateescape")
        source.take(self._size)
        return record


def _varying(scan: Record) -> Iterator[tuple[str, bytes, int]]:
    """Yield the fields that may differ: name, how they are written, and where in that the value begins."""
    yield _TIME, _TICKS.pack(scan.integer("time")), 0
    image = scan.child("intensity")
    for holder, name in ((scan, _DEPTH_FILE), (image, _IMAGE_FILE)):
        if holder is not None and (text := holder.text(name)):
            yield name, text_bytes(text), _LENGTH_BYTES
