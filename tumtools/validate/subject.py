# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What the rules look at: a sequence with its text files and the facts of its images, nothing to be read."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.model.sequence import IMAGE_STREAMS
from tumtools.validate.depth_scale import DepthScale, measure_depth_scale
from tumtools.validate.finding import Place
from tumtools.validate.frames import COUNTS, NO_READING_ELSEWHERE
from tumtools.validate.gravity import GravityFit, estimate_offset, fit_readings

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy.typing as npt

    from tumtools.errors import InputError, UsageError
    from tumtools.formats.ros.inspection import RecordingFacts
    from tumtools.formats.tum.text import Problem, Table
    from tumtools.kept_digest import Check
    from tumtools.model.sequence import SequenceInfo
    from tumtools.model.signals import Accelerometer, Trajectory
    from tumtools.validate.frames import FrameFacts

    Stamps = npt.NDArray[np.int64]

_NUMBER: Final = re.compile(r"[+-]?\d+(\.\d*)?([eE][+-]?\d+)?")
_DATE: Final = re.compile(r"\d{4}[-/]\d\d?[-/]\d\d?|\d\d?:\d\d:\d\d")
_OUTSIDE: Final = re.compile("before the year|beyond the year")
_IMU_COLUMNS: Final = 7


class ProblemKind(Enum):
    """What is the matter with a line that is no row."""

    HEADER = "header"
    STAMP = "stamp"
    IMU = "imu"
    OTHER = "other"


@dataclass(frozen=True, slots=True)
class TextFile:
    """A text file of a sequence.

    Attributes:
        name: Relative to the source; empty if it is the source.
        table: Its rows, and the lines that are none.
        damage: Why it could not be read at all; then the table is empty.

    """

    name: str
    table: Table
    damage: InputError | None = None

    def problems(self, *kinds: ProblemKind) -> list[Problem]:
        """Return the problems of these kinds, in the order of the lines."""
        return [problem for problem in self.table.problems if problem_kind(problem) in kinds]

    @property
    def is_sound(self) -> bool:
        """Whether every line of it could be read."""
        return self.damage is None and not any(not problem.is_header for problem in self.table.problems)


def problem_kind(problem: Problem) -> ProblemKind:
    """Tell what is the matter with a line."""
    if problem.is_header:
        return ProblemKind.HEADER
    fields = re.split(r"[,\s]+", problem.text.strip())
    if _DATE.match(fields[0]) or (_NUMBER.fullmatch(fields[0]) and _OUTSIDE.search(problem.message)):
        return ProblemKind.STAMP
    if len(fields) == _IMU_COLUMNS and "ax ay az" in problem.message and all(map(_NUMBER.fullmatch, fields)):
        return ProblemKind.IMU
    return ProblemKind.OTHER


@dataclass(eq=False)
class Subject:
    """A sequence to be checked.

    Attributes:
        source: As the user named it.
        path: Where it is on disk.
        is_folder: Whether `Place.file` is a file of its own on disk.
        format: Name of its format; empty if unknown.
        info: Its header; None if it could not be opened.
        damage: What could not be read, in the order found.
        salvage: Damage is known and only warned of.
        unclear: Why it is not clear which topics are the streams; then it could not be opened.
        texts: Text files by stream (format tum).
        sizes: Size of each file that is there, by name (format tum); None for others.
        names: File name of each row of the image lists (format tum).
        missing: Images whose file is missing, by stream: row, stamp and name (format rawlog).
        stamps: Stamps of each image stream, in file order.
        groundtruth: Poses.
        accelerometer: Accelerations.
        recording: What a recording of ROS says beyond the sequence in it; None for other formats.
        is_estimate: It is a trajectory on its own that does not claim to be ground truth.
        frames: Facts of the images that were looked at, by stream, in order of time.
        depth_histogram: How often each depth count occurs, shape [65536].
        digests: Each stream held against the digest that the source carries of itself, if it does.

    """

    source: str
    path: str
    is_folder: bool = False
    format: str = ""
    info: SequenceInfo | None = None
    damage: list[InputError] = field(default_factory=list)
    salvage: bool = False
    unclear: UsageError | None = None
    texts: Mapping[str, TextFile] = field(default_factory=dict)
    sizes: Mapping[str, int] | None = None
    names: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    missing: dict[str, list[tuple[int, int, str]]] = field(default_factory=dict)
    stamps: Mapping[str, Stamps] = field(default_factory=dict)
    groundtruth: Trajectory | None = None
    accelerometer: Accelerometer | None = None
    recording: RecordingFacts | None = None
    is_estimate: bool = False
    frames: dict[str, list[FrameFacts]] = field(default_factory=dict)
    depth_histogram: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(COUNTS, np.int64))
    digests: list[Check] = field(default_factory=list)

    @cached_property
    def all_stamps(self) -> dict[str, Stamps]:
        """Stamps of all streams, in file order."""
        every = {stream: self.stamps[stream] for stream in IMAGE_STREAMS if stream in self.stamps}
        if self.accelerometer is not None:
            every["accelerometer"] = self.accelerometer.stamps
        if self.groundtruth is not None:
            every["groundtruth"] = self.groundtruth.stamps
        return every

    def place(self, stream: str, row: int) -> Place:
        """Return where a row is: the line of its text file, or its number in the recording."""
        stamp = int(self.all_stamps[stream][row])
        text = self.texts.get(stream)
        if text is None:
            return Place(stream=stream, row=row, stamp=stamp)
        return Place(text.name, int(text.table.lines[row]), stream, row, stamp)

    def image_place(self, stream: str, row: int) -> Place:
        """Return where an image is: its file, or its number in the recording."""
        stamp = int(self.all_stamps[stream][row])
        names = self.names.get(stream)
        return Place(names[row] if names else "", None, stream, row, stamp)

    def stream_place(self, stream: str) -> Place:
        """Return the text file of a stream, or the stream."""
        text = self.texts.get(stream)
        return Place(text.name if text else "", None, stream)

    @property
    def depth_units_per_metre(self) -> float | None:
        """The declared depth factor, in the counts of `depth_histogram`."""
        for facts in self.frames.get("depth", []):
            if facts.depth is not None and facts.depth_units_per_metre is not None:
                return (
                    1000.0 * facts.depth_units_per_metre
                    if facts.encoding == "32FC1"
                    else facts.depth_units_per_metre
                )
        return None

    @cached_property
    def depth_scale(self) -> DepthScale | None:
        """The depth factor measured from all images together."""
        present = np.flatnonzero(self.depth_histogram)
        return measure_depth_scale(present[present != NO_READING_ELSEWHERE].astype(np.uint16))

    @cached_property
    def gravity(self) -> dict[str, GravityFit]:
        """How well each reading of the quaternions fits; empty where nothing can be said."""
        if self.groundtruth is None or self.accelerometer is None:
            return {}
        return fit_readings(self.groundtruth, self.accelerometer)

    @cached_property
    def accelerometer_offset(self) -> tuple[float, float] | None:
        """See `gravity.estimate_offset`."""
        if self.groundtruth is None or self.accelerometer is None:
            return None
        return estimate_offset(self.groundtruth, self.accelerometer)
