# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""One pass through a rawlog: what is in it, and where its images are."""

from __future__ import annotations

from array import array
from collections import Counter
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

from tumtools.errors import InputError
from tumtools.formats.rawlog import comment, observations
from tumtools.formats.rawlog.archive import class_of
from tumtools.formats.rawlog.objects import Objects
from tumtools.formats.rawlog.pictures import Picture, nameless, pictures_of
from tumtools.formats.rawlog.runs import TICKS, Run

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from tumtools.formats.rawlog.archive import Record
    from tumtools.model.camera import CameraInfo

_WITH_STREAMS: Final = frozenset({"CObservation3DRangeScan", "CObservationImage", "CObservationIMU"})
_TIMELESS: Final = "observations without a time"
_HELD_BYTES: Final = 64 * 2**20
"""First images are held up to this size; a rawlog may have thousands of sensors."""
_HELD_LETTERS: Final = 2**20
"""Of the comments of others, which are shown."""
_COLLECTIONS: Final = frozenset({"CSensoryFrame", "CActionCollection"})


Key = tuple[int, int]
"""An image: number of its top-level object, and which of the images of that object."""


@dataclass(slots=True)
class Sensor:
    """The observations of one class under one label.

    Attributes:
        count: How many.
        first_ticks: Earliest time; 0 if none has a time.
        last_ticks: Latest time.

    """

    count: int = 0
    first_ticks: int = 0
    last_ticks: int = 0

    def add(self, count: int, first: int, last: int) -> None:
        """Count observations between two times; 0 ticks is no time."""
        self.count += count
        if first:
            self.first_ticks = min(self.first_ticks or first, first)
            self.last_ticks = max(self.last_ticks, last)


@dataclass(slots=True)
class Accelerations:
    """Rows of one accelerometer, in the order of the file."""

    ticks: array[int] = field(default_factory=lambda: array("Q"))
    values: array[float] = field(default_factory=lambda: array("d"))


@dataclass(frozen=True, slots=True)
class Place:
    """Where an image is.

    Attributes:
        number: Number of the top-level object.
        part: Which of the images of that object.
        picture: Without what is embedded.
        nbytes: Bytes embedded in the rawlog; 0 if it is an external file.

    """

    number: int
    part: int
    picture: Picture
    nbytes: int

    @property
    def key(self) -> Key:
        """Number of the object and of the image in it."""
        return self.number, self.part


@dataclass(frozen=True, slots=True)
class Remark:
    """A comment of ours: its text, and where it is, for messages."""

    text: str
    place: str


@dataclass(frozen=True, slots=True)
class _Told:
    """What an observation tells besides its images and values, whatever their files are called.

    Attributes:
        not_carried: What the model has no place for.
        nameless: Its images that are said to be in a file without a name.
        is_euclidean: Whether its depth is distances along the ray.

    """

    not_carried: tuple[str, ...] = ()
    nameless: tuple[str, ...] = ()
    is_euclidean: bool = False


@dataclass(slots=True)
class Survey:
    """What is in a rawlog.

    Attributes:
        objects: The file.
        count: Top-level objects that could be read.
        classes: How many objects of each class name and version, as spelled in the file.
        sensors: By class and label.
        comments: Texts of the comments of others, all together cut after a million letters.
        notes: Comments of ours that hold notes; of more than one the text of the first only.
        digests: Comments of ours that hold a digest, likewise.
        places: Every image with a time.
        first: First image of each stream and label, with what is embedded; of the first of those sensors.
        accelerations: By label.
        cameras: First intrinsics of each stream and label.
        cameras_changed: Observations of each stream and label whose intrinsics are not the first.
        cameras_refused: Intrinsics that are no camera's, by stream and label.
        not_carried: By label and what it is.
        euclidean: Depth images that hold distances along the ray, by label.
        nameless: Images that are said to be in a file without a name, by label and what they are.
        unitless: Depth images of counts whose unit no sensor has, by label.
        damage: What ended the reading before the end of the file.

    """

    objects: Objects
    count: int = 0
    classes: Counter[tuple[str, int]] = field(default_factory=Counter)
    sensors: dict[tuple[str, str], Sensor] = field(default_factory=dict)
    comments: list[str] = field(default_factory=list)
    notes: list[Remark] = field(default_factory=list)
    digests: list[Remark] = field(default_factory=list)
    places: list[Place] = field(default_factory=list)
    first: dict[tuple[str, str], Picture] = field(default_factory=dict)
    accelerations: dict[str, Accelerations] = field(default_factory=dict)
    cameras: dict[tuple[str, str], CameraInfo] = field(default_factory=dict)
    cameras_changed: Counter[tuple[str, str]] = field(default_factory=Counter)
    cameras_refused: Counter[tuple[str, str]] = field(default_factory=Counter)
    not_carried: Counter[tuple[str, str]] = field(default_factory=Counter)
    euclidean: Counter[str] = field(default_factory=Counter)
    nameless: Counter[tuple[str, str]] = field(default_factory=Counter)
    unitless: Counter[str] = field(default_factory=Counter)
    damage: InputError | None = None
    _held_bytes: int = 0
    _letters_left: int = _HELD_LETTERS
    _made: observations.Cameras = field(default_factory=observations.Cameras)
    _told: tuple[Record | None, _Told] = (None, _Told())

    def add(self, number: int, record: Record) -> None:
        """Take a top-level object in."""
        self.classes[record.name, record.version] += 1
        part = 0
        for observation in observations_of(record):
            if observation is not record:
                self.classes[observation.name, observation.version] += 1
            label, ticks = observation.text("label"), observation.integer("time")
            if observation.type in _WITH_STREAMS and ticks and ticks not in TICKS:
                raise InputError(
                    f"{observation.name} has the time {ticks}, not within the years 1678 to 2262",
                    path=self.objects.path,
                    location=_place(number, observation),
                    hint="the file is damaged; with --salvage what is before this object is read",
                )
            self.sensors.setdefault((observation.type, label), Sensor()).add(1, ticks, ticks)
            imu = observations.imu_of(observation) if observation.type == "CObservationIMU" else None
            told = self._told_of(observation, imu)
            for what in told.not_carried:
                self.not_carried[label, what] += 1
            for what in told.nameless:
                self.nameless[label, what] += 1
            for picture in pictures_of(observation):
                self._add_picture(number, part, picture)
                part += 1
            self._add_cameras(observation, label)
            if imu is not None and imu.has_acceleration:
                self._add_acceleration(imu, label, ticks)
            elif observation.type == "CObservationComment":
                self._add_comment(observation.text("text"), _place(number, observation))
            elif told.is_euclidean:
                self.euclidean[label] += 1

    def add_run(self, run: Run) -> None:
        """Take objects in that are like the one before them but for time and values."""
        record, label = run.record, run.record.text("label")
        self.classes[record.name, record.version] += len(run)
        sensor = self.sensors[record.type, label]
        sensor.add(len(run), int(run.ticks.min()), int(run.ticks.max()))
        imu = observations.imu_of(record)
        for what in observations.not_carried(record, imu):
            self.not_carried[label, what] += len(run)
        if imu.has_acceleration:
            rows = self.accelerations.setdefault(label, Accelerations())
            rows.ticks.frombytes(run.ticks.tobytes())
            rows.values.frombytes(run.values[:, :3].tobytes())

    def candidates(self) -> dict[str, Counter[str]]:
        """Return the labels that give each stream, with the number of its images or rows."""
        found: dict[str, Counter[str]] = {}
        for place in self.places:
            found.setdefault(place.picture.stream, Counter())[place.picture.label] += 1
        for label, rows in self.accelerations.items():
            found.setdefault("accelerometer", Counter())[label] += len(rows.ticks)
        return found

    def _told_of(self, observation: Record, imu: observations.Imu | None) -> _Told:
        """Return what an observation tells besides; where it is like another one, that one was asked."""
        if observation.like is not None and observation.like is self._told[0]:
            return self._told[1]
        told = _Told(
            tuple(observations.not_carried(observation, imu)),
            tuple(nameless(observation)),
            bool(observation.integer("has_range") and not observation.integer("range_is_depth", 1)),
        )
        if observation.like is not None:
            self._told = observation.like, told
        return told

    def _add_comment(self, text: str, place: str) -> None:
        if comment.is_digest(text):
            self.digests.append(Remark("" if self.digests else text, place))
        elif comment.is_notes(text):
            self.notes.append(Remark("" if self.notes else text, place))
        else:
            self.comments.append(text[: self._letters_left])
            self._letters_left -= len(self.comments[-1])

    def _add_picture(self, number: int, part: int, picture: Picture) -> None:
        if not picture.ticks:
            self.not_carried[picture.label, _TIMELESS] += 1
            return
        if picture.stream == "depth" and picture.units_per_metre is None:
            self.unitless[picture.label] += 1
        sensor = (picture.stream, picture.label)
        if sensor not in self.first and self._held_bytes + picture.nbytes <= _HELD_BYTES:
            self.first[sensor] = picture.detached()
            self._held_bytes += picture.nbytes
        is_bare = picture.image is None and picture.scan is None
        bare = picture if is_bare else replace(picture, image=None, scan=None)
        self.places.append(Place(number, part, bare, picture.nbytes))

    def _add_cameras(self, observation: Record, label: str) -> None:
        for stream, camera in self._made.of(observation):
            known = self.cameras.get((stream, label))
            if camera is known:
                continue
            if not camera.is_plausible:
                self.cameras_refused[stream, label] += 1
            elif known is None:
                self.cameras[stream, label] = camera
            elif camera != known:
                self.cameras_changed[stream, label] += 1

    def _add_acceleration(self, imu: observations.Imu, label: str, ticks: int) -> None:
        if not ticks:
            self.not_carried[label, _TIMELESS] += 1
            return
        rows = self.accelerations.setdefault(label, Accelerations())
        rows.ticks.append(ticks)
        rows.values.extend(imu.values[:3].tolist())


def _place(number: int, observation: Record) -> str:
    return f"object {number}, offset {observation.offset}"


def observations_of(record: Record) -> Iterator[Record]:
    """Yield an object, or what it is a collection of."""
    if class_of(record.name) in _COLLECTIONS:
        for child in record.children():
            yield from observations_of(child)
    else:
        yield record


def survey(path: Path) -> Survey:
    """Read a rawlog once.

    Damage ends the reading and is kept in `Survey.damage`; what is before it is there.

    Raises:
        MissingInputError: There is no such file.

    """
    objects = Objects(path)
    result = Survey(objects)
    try:
        for item in objects.in_runs():
            if isinstance(item, Run):
                result.add_run(item)
                result.count += len(item)
            else:
                result.add(result.count, item)
                result.count += 1
    except FileNotFoundError:
        raise
    except InputError as error:
        result.damage = error
    return result
