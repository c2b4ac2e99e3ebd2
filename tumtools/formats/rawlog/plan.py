# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Which scans a sequence becomes: pairs of images, times and file names, known from the stamps alone."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.errors import OutputError
from tumtools.model.camera import ROS_DEFAULT, camera_of_name
from tumtools.model.sequence import WHOLE_SEQUENCE, Loss
from tumtools.model.time import (
    NANOSECONDS_PER_SECOND,
    decimals_needed,
    format_stamp,
    parse_stamp,
    stamp_to_ticks,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy.typing as npt

    from tumtools.model.sequence import Sequence

Key = tuple[str, int]
"""An image: stream and row."""

MAX_DIFFERENCE_NS: Final = NANOSECONDS_PER_SECOND // 60
"""Half the time between two frames at 30 Hz; what MRPT's converter takes."""
_DECIMALS: Final = 6
_NANOSECONDS_PER_TICK: Final = 100


@dataclass(frozen=True, slots=True)
class Slot:
    """A scan to write.

    Attributes:
        ticks: Its time.
        image: The colour or infrared image, if any.
        depth: The depth image, if any.
        image_file: Name of the image's file, without suffix.
        depth_file: Name of the depth file, without suffix.

    """

    ticks: int
    image: Key | None
    depth: Key | None
    image_file: str = ""
    depth_file: str = ""

    @property
    def keys(self) -> tuple[Key, ...]:
        """The images of the scan."""
        return tuple(key for key in (self.image, self.depth) if key is not None)


@dataclass(frozen=True, slots=True)
class ScanPlan:
    """The scans of a rawlog in order of time, and its accelerometer rows.

    Attributes:
        slots: The scans.
        imu_ticks: Time of each accelerometer object, sorted, int64, shape [n].
        imu_rows: Row of the accelerometer file that each object comes from, shape [n].
        losses: What is lost that can be told without looking at pixels.

    """

    slots: tuple[Slot, ...]
    imu_ticks: npt.NDArray[np.int64]
    imu_rows: npt.NDArray[np.intp]
    losses: tuple[Loss, ...] = ()

    def files(self) -> dict[Key, list[str]]:
        """Return the names under which each image is stored, without suffix."""
        names: dict[Key, list[str]] = {}
        for slot in self.slots:
            if slot.image is not None:
                names.setdefault(slot.image, []).append(slot.image_file)
            if slot.depth is not None:
                names.setdefault(slot.depth, []).append(slot.depth_file)
        return names


# --- lossless -----------------------------------------------------------------------------------------


def plan_lossless(sequence: Sequence) -> ScanPlan:
    """Plan the dialects `modern` and `legacy`: every image and every row once, at its own stamp.

    Colour and depth images that are each other's nearest become one scan at the time of the colour image.
    """
    stamps = {stream: sequence.image_stamps(stream) for stream in ("rgb", "depth", "ir")}
    names = {stream: _names(stream, values) for stream, values in stamps.items()}
    partner = "rgb" if len(stamps["rgb"]) else "ir"
    depth_of = dict(_mutual_nearest(stamps[partner], stamps["depth"], MAX_DIFFERENCE_NS))
    paired = set(depth_of.values())
    slots: list[tuple[int, int, Slot]] = []
    for order, stream in enumerate(("rgb", "depth", "ir")):
        for row, stamp in enumerate(stamps[stream].tolist()):
            if stream == "depth" and row in paired:
                continue
            depth = row if stream == "depth" else depth_of.get(row) if stream == partner else None
            slot = Slot(
                stamp_to_ticks(stamp),
                None if stream == "depth" else (stream, row),
                None if depth is None else ("depth", depth),
                "" if stream == "depth" else names[stream][row],
                "" if depth is None else names["depth"][depth],
            )
            slots.append((stamp, order, slot))
    slots.sort(key=lambda item: item[:2])
    ticks, rows = _imu_by_stamp(sequence)
    return ScanPlan(tuple(slot for _, _, slot in slots), ticks, rows)


def _mutual_nearest(
    first: npt.NDArray[np.int64], second: npt.NDArray[np.int64], limit_ns: int
) -> Iterator[tuple[int, int]]:
    """Yield pairs of rows that are each other's nearest in time; each row in at most one pair."""
    if not len(first) or not len(second):
        return
    there, back = _nearest(first, second), _nearest(second, first)
    mutual = back[there] == np.arange(len(first))
    close = np.abs(second[there] - first) <= limit_ns
    for row in np.flatnonzero(mutual & close).tolist():
        yield row, int(there[row])


def _nearest(stamps: npt.NDArray[np.int64], others: npt.NDArray[np.int64]) -> npt.NDArray[np.intp]:
    """Return for each stamp the row of the nearest other: the first of equal ones, the earlier on a tie."""
    order = np.argsort(others, kind="stable")
    ordered = others[order]
    after = np.searchsorted(ordered, stamps)
    before = np.searchsorted(ordered, ordered[np.maximum(after - 1, 0)])
    after = np.minimum(after, len(ordered) - 1)
    nearer = np.abs(stamps - ordered[before]) <= np.abs(ordered[after] - stamps)
    found: npt.NDArray[np.intp] = order[np.where(nearer, before, after)]
    return found


def _names(stream: str, stamps: npt.NDArray[np.int64]) -> list[str]:
    """Return the file name of each image: its own stamp, numbered where the same stamp comes again."""
    decimals = decimals_needed(stamps, _DECIMALS)
    seen: dict[int, int] = {}
    names = []
    for stamp in stamps.tolist():
        times = seen.get(stamp, 0)
        seen[stamp] = times + 1
        again = f"-{times}" if times else ""
        names.append(f"{format_stamp(stamp, decimals)}{again}_{stream}")
    return names


def _imu_by_stamp(sequence: Sequence) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.intp]]:
    if sequence.accelerometer is None:
        return np.empty(0, np.int64), np.empty(0, np.intp)
    stamps = sequence.accelerometer.stamps
    rows = np.argsort(stamps, kind="stable")
    return stamps[rows] // _NANOSECONDS_PER_TICK + stamp_to_ticks(0), rows


# --- as MRPT's converter ------------------------------------------------------------------------------

_CONVERTER_FRAME_LIMIT: Final = 1.0 / 60
_CONVERTER_IMU_LIMIT: Final = 0.010
_CONVERTER_LAST: Final = 9.2e9
"""Seconds since 1970; int64 nanoseconds end a few months later."""


@dataclass(slots=True)
class _Moved:
    """Stamps that are not what they were."""

    largest_ns: int = 0
    count: int = 0

    def add(self, change_ns: int) -> None:
        if change_ns:
            self.count += 1
            self.largest_ns = max(self.largest_ns, abs(change_ns))


@dataclass(slots=True)
class _Clock:
    """Times of a stream as MRPT's converter has them: float64 seconds, sorted, the last of equal ones."""

    stamps: npt.NDArray[np.int64]
    seconds: list[float] = field(init=False)
    rows: list[int] = field(init=False)

    def __post_init__(self) -> None:
        # Division of Python's integers rounds once, as reading the decimal text does.
        last = {stamp / NANOSECONDS_PER_SECOND: row for row, stamp in enumerate(self.stamps.tolist())}
        self.seconds = sorted(last)
        self.rows = [last[time] for time in self.seconds]

    def nearest(self, time: float) -> int | None:
        """Return the index of the nearest time, the later one on a tie."""
        after = bisect_left(self.seconds, time)
        candidates = [index for index in (after, after - 1) if 0 <= index < len(self.seconds)]
        return min(candidates, key=lambda index: abs(self.seconds[index] - time), default=None)


_NO_ROWS: Final = "no rows where colour or depth is missing"
_MEAN_WHY: Final = "this dialect has one time per scan, the mean of colour and depth"


def plan_converter(sequence: Sequence) -> ScanPlan:
    """Plan what MRPT's `rgbd_dataset2rawlog` writes: a scan for each colour image that has a depth image.

    The arithmetic is that program's, in float64, so that times come out as its.
    """
    clocks = {stream: _Clock(sequence.image_stamps(stream)) for stream in ("rgb", "depth")}
    scans = list(_converter_scans(clocks["rgb"], clocks["depth"]))
    _refuse_what_it_cannot_name(sequence, [time for time, _, _ in scans])
    rows = sequence.accelerometer
    imu = _Clock(rows.stamps if rows is not None else np.empty(0, np.int64))
    moved = {stream: _Moved() for stream in ("rgb", "depth", "accelerometer")}
    slots, imu_ticks, imu_rows = [], [], []
    for time, colour, depth in scans:
        ticks = int(time * 1e7) + stamp_to_ticks(0)
        name = f"{time:.6f}"
        stamp = parse_stamp(name)
        keys: dict[str, Key] = {}
        for stream, index in (("rgb", colour), ("depth", depth)):
            if index is not None:
                keys[stream] = (stream, clocks[stream].rows[index])
                moved[stream].add(stamp - int(clocks[stream].stamps[keys[stream][1]]))
        slots.append(Slot(ticks, keys.get("rgb"), keys.get("depth"), f"{name}_rgb", f"{name}_depth"))
        if colour is None or depth is None:
            continue  # that program looks for accelerations only where it pairs colour with depth
        sample = imu.nearest(time)
        if (
            sample is not None
            and abs(clocks["rgb"].seconds[colour] - imu.seconds[sample]) < _CONVERTER_IMU_LIMIT
        ):
            imu_ticks.append(ticks)
            imu_rows.append(imu.rows[sample])
            moved["accelerometer"].add(stamp - int(imu.stamps[imu.rows[sample]]))
    losses = tuple(_converter_losses(sequence, slots, imu_rows, moved))
    return ScanPlan(tuple(slots), np.array(imu_ticks, np.int64), np.array(imu_rows, np.intp), losses)


def _refuse_what_it_cannot_name(sequence: Sequence, times: list[float]) -> None:
    """Refuse a sequence without scans, or whose files would overwrite each other.

    Raises:
        OutputError: It is such a sequence.

    """
    if not times:
        problem = "it has scans only, and there is no colour image with a depth image within 1/60 s"
    elif not all(abs(time) < _CONVERTER_LAST for time in times):
        problem = "it has times in float64, which cannot tell those next to the year 2262"
    elif len(times) > len({f"{time:.6f}" for time in times}):
        problem = "it names files by microseconds, and there are two scans in one"
    else:
        return
    raise OutputError(
        f"the dialect converter cannot hold this sequence: {problem}",
        path=sequence.info.name,
        hint="write it with --dialect modern",
    )


def _converter_scans(rgb: _Clock, depth: _Clock) -> Iterator[tuple[float, int | None, int | None]]:
    """Yield time, colour index and depth index of each scan."""
    if not rgb.seconds or not depth.seconds:
        for clock in (rgb, depth):
            for index, time in enumerate(clock.seconds):
                yield time, index if clock is rgb else None, index if clock is depth else None
        return
    for colour, time in enumerate(rgb.seconds):
        partner = depth.nearest(time)
        if partner is not None and abs(time - depth.seconds[partner]) <= _CONVERTER_FRAME_LIMIT:
            yield 0.5 * (time + depth.seconds[partner]), colour, partner


def _converter_losses(
    sequence: Sequence, slots: list[Slot], imu_rows: list[int], moved: dict[str, _Moved]
) -> Iterator[Loss]:
    for stream, why in (
        ("rgb", "this dialect drops colour images without a depth image within 1/60 s"),
        ("depth", "this dialect stores only depth images that are the nearest of a colour image"),
        ("ir", "this dialect has no infrared images"),
    ):
        used = {key for slot in slots for key in slot.keys if key[0] == stream}
        dropped = len(sequence.image_stamps(stream)) - len(used)
        if dropped:
            yield Loss(stream, "images dropped", dropped, why, alters=("rows dropped",))
    depths = [slot.depth for slot in slots if slot.depth is not None]
    if repeated := len(depths) - len(set(depths)):
        why = "this dialect gives each colour image its nearest depth image"
        yield Loss("depth", "images stored again", repeated, why, alters=("rows repeated",))
    rows = 0 if sequence.accelerometer is None else len(sequence.accelerometer)
    if dropped := rows - len(set(imu_rows)):
        paired = any(slot.image and slot.depth for slot in slots)
        why = f"this dialect stores {'one row per scan' if paired else _NO_ROWS}"
        yield Loss("accelerometer", "rows dropped", dropped, why, alters=("rows dropped",))
    if repeated := len(imu_rows) - len(set(imu_rows)):
        why = "this dialect gives each scan its nearest row"
        yield Loss("accelerometer", "rows stored again", repeated, why, alters=("rows repeated",))
    for stream, change in moved.items():
        if change.count:
            yield Loss(
                stream,
                "stamps replaced",
                change.count,
                _MEAN_WHY,
                change.largest_ns / NANOSECONDS_PER_SECOND,
                "s",
                ("stamps",),
            )
    yield from _converter_header_losses(sequence)


def _converter_header_losses(sequence: Sequence) -> Iterator[Loss]:
    why = "this dialect has no place for header lines and decimals"
    for stream in sequence.info.text:
        if stream != "groundtruth":
            yield Loss(stream, "text layout dropped", 1, why, alters=("text",))
    why = "this dialect writes 525 525 319.5 239.5 for every camera"
    for stream in ("rgb", "depth"):
        if stream not in sequence.info.images:
            continue
        if stream in sequence.cameras or sequence.info.camera not in {None, ROS_DEFAULT}:
            yield Loss(stream, "calibration replaced", 1, why, alters=("calibration",))
    why = "this dialect has no place for frame ids"
    for stream, frame in sequence.info.frame_ids.items():
        yield Loss(stream, f"frame id {frame}", 1, why, alters=("frame id",))


def converter_name_losses(sequence: Sequence, stem: str, camera: str | None) -> Iterator[Loss]:
    """Yield what the dialect `converter` keeps only as far as the name of the file tells it.

    Args:
        sequence: What is written.
        stem: Name of the rawlog, without suffix.
        camera: That of the sequence, or the one that was asked for.

    """
    info = sequence.info
    if info.name != stem:
        why = "this dialect has no place for it but the name of the file"
        yield Loss(WHOLE_SEQUENCE, f"name {info.name}", 1, why, alters=("name",))
    if camera is not None and camera_of_name(stem) != camera:
        why = "this dialect tells the camera only by the name of the file"
        yield Loss(next(iter(info.images), WHOLE_SEQUENCE), f"camera {camera}", 1, why, alters=("camera",))
    if info.licence is not None:
        why = "this dialect has no place for it"
        yield Loss(WHOLE_SEQUENCE, "licence and citation", 1, why, alters=("licence",))
