# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What is in a rawlog, whether or not a sequence can be made of it."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

from tumtools.formats.rawlog.externals import Folder
from tumtools.formats.rawlog.survey import Survey, survey
from tumtools.model.time import NANOSECONDS_PER_SECOND, ticks_to_stamp

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from tumtools.formats.rawlog.compression import Container
    from tumtools.model.sequence import DetailRow


@dataclass(frozen=True, slots=True)
class ClassCount:
    """Objects of one class and version.

    Attributes:
        name: As spelled in the file.
        version: Of the class.
        count: How many, those in collections included.

    """

    name: str
    version: int
    count: int


@dataclass(frozen=True, slots=True)
class SensorSummary:
    """Observations of one class under one label.

    Attributes:
        label: Sensor label; empty if there is none.
        type: Class, without namespace.
        count: How many.
        first: Earliest time, nanoseconds; None if none has a time.
        last: Latest time, nanoseconds.

    """

    label: str
    type: str
    count: int
    first: int | None
    last: int | None

    @property
    def duration_s(self) -> float:
        """Seconds from the earliest to the latest time."""
        if self.first is None or self.last is None:
            return 0.0
        return (self.last - self.first) / NANOSECONDS_PER_SECOND

    @property
    def rate_hz(self) -> float | None:
        """Mean rate; None for fewer than two times."""
        return (self.count - 1) / self.duration_s if self.duration_s else None


@dataclass(frozen=True, slots=True)
class Description:
    """What is in a rawlog.

    Attributes:
        path: The file.
        compression: Of the file.
        stored_bytes: Size of the file.
        inflated_bytes: Size without compression, of the part that could be read.
        objects: Top-level objects.
        classes: By class and version.
        sensors: By label and class.
        images: Images by stream.
        comment: Text of the comments of others.
        external_folder: Name of the folder of the external files, if there is one.
        stopped: Why the reading ended before the end of the file; None if it did not.

    """

    path: Path
    compression: Container
    stored_bytes: int
    inflated_bytes: int
    objects: int
    classes: tuple[ClassCount, ...]
    sensors: tuple[SensorSummary, ...]
    images: dict[str, int]
    comment: str
    external_folder: str | None
    stopped: str | None

    @property
    def first(self) -> int | None:
        """Earliest time of all observations, nanoseconds."""
        return min((sensor.first for sensor in self.sensors if sensor.first is not None), default=None)

    @property
    def last(self) -> int | None:
        """Latest time of all observations, nanoseconds."""
        return max((sensor.last for sensor in self.sensors if sensor.last is not None), default=None)


def describe(path: Path) -> Description:
    """Describe a rawlog; one that is damaged up to the damage.

    Raises:
        MissingInputError: There is no such file.

    """
    return description_of(survey(path))


def description_of(found: Survey) -> Description:
    """Return the description of a rawlog that has been read."""
    progress = found.objects.progress
    folder = Folder(found.objects.path).path
    return Description(
        path=found.objects.path,
        compression=progress.container,
        stored_bytes=progress.stored,
        inflated_bytes=progress.inflated,
        objects=found.count,
        classes=tuple(ClassCount(*key, count) for key, count in sorted(found.classes.items())),
        sensors=tuple(
            SensorSummary(
                label,
                type_,
                sensor.count,
                ticks_to_stamp(sensor.first_ticks) if sensor.first_ticks else None,
                ticks_to_stamp(sensor.last_ticks) if sensor.last_ticks else None,
            )
            for (type_, label), sensor in sorted(found.sensors.items(), key=lambda item: item[0][::-1])
        ),
        images=dict(Counter(place.picture.stream for place in found.places)),
        comment="".join(found.comments),
        external_folder=folder.name if folder else None,
        stopped=str(found.damage) if found.damage else None,
    )


def tables(found: Description) -> Mapping[str, tuple[DetailRow, ...]]:
    """Return a description as tables; stamps as integer nanoseconds in strings."""
    file: DetailRow = {
        "compression": found.compression,
        "bytes": found.stored_bytes,
        "inflated": found.inflated_bytes,
        "objects": found.objects,
        "first": _text(found.first),
        "last": _text(found.last),
        "external_folder": found.external_folder,
    }
    classes: tuple[DetailRow, ...] = tuple(asdict(entry) for entry in found.classes)
    sensors: tuple[DetailRow, ...] = tuple(
        {
            "label": sensor.label,
            "class": sensor.type,
            "count": sensor.count,
            "rate_hz": round(sensor.rate_hz, 3) if sensor.rate_hz else None,
            "duration_s": round(sensor.duration_s, 6),
            "first": _text(sensor.first),
            "last": _text(sensor.last),
        }
        for sensor in found.sensors
    )
    return {"rawlog": (file,), "classes": classes, "sensors": sensors}


def _text(stamp: int | None) -> str | None:
    return None if stamp is None else str(stamp)
