# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The stamp of each image: the one that its file is named after, where the time of its scan agrees.

A scan has one time, that of its colour image, to 100 ns; the names of the files have every stamp exactly.
Other programs change the times and leave the names as they are, or embed the images and keep only the name
of the depth file.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Final

from tumtools.formats.rawlog.plan import MAX_DIFFERENCE_NS
from tumtools.model.time import parse_stamp

if TYPE_CHECKING:
    from tumtools.formats.rawlog.pictures import Picture

FLOAT_TIME_ERROR_NS: Final = 1000
"""A time that went through float64, or lost what is below a tick, is off by less than this."""
_STAMP_IN_NAME: Final = re.compile(r"(?:.*/)?(-?\d{1,10}\.\d{1,9})(?:-(\d{1,9}))?_(?:rgb|depth|ir)\.\w+")


class Origin(Enum):
    """Where a stamp comes from.

    Attributes:
        NAME: The name of the file, which agrees with the time of the observation.
        TIME: The time of the observation, which is that of the image.
        PARTNER: The time of the observation, which is that of the image beside it.
        MOVED: The time of the observation, with which the name of the file disagrees.

    """

    NAME = 0
    TIME = 1
    PARTNER = 2
    MOVED = 3


@dataclass(frozen=True, slots=True)
class Found:
    """The stamp of an image.

    Attributes:
        stamp: Nanoseconds.
        number: Which of the images of this stamp it is, as far as its name tells.
        origin: Where it comes from.

    """

    stamp: int
    number: int
    origin: Origin


def stamp_of(picture: Picture) -> Found:
    """Return the stamp of an image.

    A depth image may be as far from the time of its scan as two images of one scan can be; the image that
    the scan has its time from, by no more than that time is rounded. If that one has moved, so have both.
    """
    time, named = picture.stamp, _in_name(picture.name)
    beside = _in_name(picture.beside)
    if named is None:
        return Found(time, 0, Origin.TIME if picture.beside is None else Origin.PARTNER)
    limit = FLOAT_TIME_ERROR_NS + (0 if picture.beside is None else MAX_DIFFERENCE_NS)
    moved = beside is not None and abs(beside[0] - time) > FLOAT_TIME_ERROR_NS
    if moved or abs(named[0] - time) > limit:
        return Found(time, named[1], Origin.MOVED)
    return Found(*named, Origin.NAME)


def _in_name(name: str | None) -> tuple[int, int] | None:
    """Return the stamp that a file is named after, and its number among equal ones."""
    match = _STAMP_IN_NAME.fullmatch(name) if name else None
    try:
        return (parse_stamp(match[1]), int(match[2] or 0)) if match else None
    except ValueError:  # a number like a stamp, but before the year 1678 or beyond 2262
        return None
