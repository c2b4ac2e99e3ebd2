# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The images of a rawlog as the rows of a sequence."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from tumtools.formats.rawlog.stamps import Found, Origin, stamp_of
from tumtools.model.sequence import IMAGE_STREAMS

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from tumtools.formats.rawlog.comment import Notes
    from tumtools.formats.rawlog.survey import Place

Entries = dict[str, "list[Entry]"]
"""The images of each stream, in the order of its rows."""


@dataclass(frozen=True, slots=True)
class Entry:
    """An image of the sequence."""

    stream: str
    stamp: int
    origin: Origin
    row: int
    place: Place


def make_entries(places: Iterable[Place], notes: Notes | None) -> Entries:
    """Give every image its stamp and its row.

    Args:
        places: Where the images are, in the order of the file.
        notes: What a comment of ours says of the order of the rows, and which streams there are.

    """
    streams = notes.counts if notes else ()
    by_stream: dict[str, list[tuple[Found, Place]]] = {
        stream: [] for stream in IMAGE_STREAMS if stream in streams
    }
    for place in places:
        by_stream.setdefault(place.picture.stream, []).append((stamp_of(place.picture), place))
    entries = {}
    for stream, group in by_stream.items():
        if notes:
            group.sort(key=lambda item: (item[0].stamp, item[0].number))
        entries[stream] = [
            Entry(stream, found.stamp, found.origin, row, place) for row, (found, place) in enumerate(group)
        ]
    for stream, order in (notes.metadata.row_order if notes else {}).items():
        if stream in entries and sorted(order) == list(range(len(entries[stream]))):
            moved = [replace(entry, row=row) for entry, row in zip(entries[stream], order, strict=True)]
            entries[stream] = sorted(moved, key=lambda entry: entry.row)
    return {stream: entries[stream] for stream in IMAGE_STREAMS if stream in entries}


def count_of(entries: Mapping[str, list[Entry]], origin: Origin) -> int:
    """Return how many stamps come from somewhere."""
    return sum(entry.origin is origin for group in entries.values() for entry in group)
