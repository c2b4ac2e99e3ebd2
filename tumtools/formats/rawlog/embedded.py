# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Images that are inside of the rawlog, handed out in any order in one pass through the file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from tumtools.formats.rawlog.pictures import Picture, pictures_of
from tumtools.formats.rawlog.survey import Key, Place, Survey, observations_of

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator

_HELD_BYTES: Final = 64 * 2**20
"""Images that come before their turn are held up to this size, and have to be read again beyond it."""


class Embedded:
    """Goes once through the file; holds an image from where it stands to where its turn is.

    Args:
        found: The rawlog.
        wanted: Which images will be asked for.

    """

    def __init__(self, found: Survey, wanted: Collection[Key]) -> None:
        self._pending = frozenset(wanted)
        self._pictures = pictures_in(found)
        self._held: dict[Key, Picture] = {}
        self._held_bytes = 0
        self._position: Key = (-1, -1)

    def take(self, place: Place) -> Picture | None:
        """Return the image of a place; None if it was too much to hold and has to be read again."""
        while self._position < place.key:
            self._position, picture = next(self._pictures, ((place.number + 1, 0), None))
            if picture is None or self._position not in self._pending:
                continue
            if self._position == place.key or self._held_bytes + picture.nbytes <= _HELD_BYTES:
                self._held[self._position] = picture
                self._held_bytes += picture.nbytes
        held = self._held.pop(place.key, None)
        if held is not None:
            self._held_bytes -= held.nbytes
        return held


def pictures_in(found: Survey) -> Iterator[tuple[Key, Picture]]:
    """Yield every image of the part of the file that can be read, with what is embedded.

    Raises:
        InputError: The file has changed since.

    """
    for number, record in enumerate(found.objects):
        part = 0
        for observation in observations_of(record):
            for picture in pictures_of(observation):
                yield (number, part), picture
                part += 1
        if number + 1 == found.count:
            return
