# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Images that are inside of the rawlog, handed out in any order in few passes through the file."""

from __future__ import annotations

from bisect import bisect_right
from itertools import accumulate
from typing import TYPE_CHECKING, Final

from tumtools.errors import InputError
from tumtools.formats.rawlog.pictures import Picture, pictures_of
from tumtools.formats.rawlog.survey import Key, Place, Survey, observations_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

_HELD_BYTES: Final = 64 * 2**20
"""Images that come before their turn are held up to this size."""


class Embedded:
    """Goes through the file and holds those of the images whose turn comes next.

    In order of time, which is that of nearly every file, it is one pass. Whatever the order is, each pass
    gathers as many of the next images as may be held, so there are no more passes than that.

    Args:
        found: The rawlog.
        wanted: The images that will be asked for, in this order.

    """

    def __init__(self, found: Survey, wanted: Sequence[Place]) -> None:
        self._found = found
        self._ranks = {place.key: rank for rank, place in enumerate(wanted)}
        self._ends = list(accumulate(place.nbytes for place in wanted))
        self._pictures = pictures_in(found)
        self._held: dict[Key, Picture] = {}
        self._position: Key = (-1, -1)

    def take(self, place: Place) -> Picture:
        """Return the image of a place; those before it in the order have been taken or are not needed.

        Raises:
            InputError: The file has changed since.

        """
        rank = self._ranks[place.key]
        before = self._ends[rank] - place.nbytes
        last = max(rank, bisect_right(self._ends, before + _HELD_BYTES) - 1)
        if place.key not in self._held and self._position >= place.key:
            self._pictures, self._position = pictures_in(self._found), (-1, -1)
        while place.key not in self._held:
            self._position, picture = next(self._pictures, (self._position, None))
            if picture is None:
                raise InputError(
                    f"object {place.number} is not there any more", path=self._found.objects.path
                )
            if rank <= self._ranks.get(self._position, -1) <= last:
                # What is held must not hold the piece of the file around it.
                self._held[self._position] = picture.detached()
        return self._held.pop(place.key)


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
