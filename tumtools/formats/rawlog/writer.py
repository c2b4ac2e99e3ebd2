# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Write a rawlog with its folder of images and the ground truth beside it, in one of three dialects."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.errors import InternalError, UsageError
from tumtools.formats import metadata
from tumtools.formats.cameras import chosen_calibration, known_camera
from tumtools.formats.options import Needs, Plan
from tumtools.formats.rawlog import comment
from tumtools.formats.rawlog.classes import CODEC
from tumtools.formats.rawlog.compression import CONTAINERS, Container, deflater
from tumtools.formats.rawlog.dialects import (
    DIALECTS,
    IMU_LABEL,
    INFRARED,
    SCAN_LABEL,
    VISIBLE,
    Dialect,
    ImuRows,
    ScanKind,
    Scans,
    camera_record,
    comment_bytes,
)
from tumtools.formats.rawlog.externals import IMAGES_SUFFIX
from tumtools.formats.rawlog.plan import (
    Key,
    ScanPlan,
    Slot,
    converter_name_losses,
    plan_converter,
    plan_lossless,
)
from tumtools.formats.rawlog.reader import SUFFIX
from tumtools.formats.rawlog.signals import ACCELEROMETER, GROUNDTRUTH_FILE
from tumtools.formats.rawlog.store import Store, Stored
from tumtools.formats.tum.text import fit_layout, render
from tumtools.images import depth
from tumtools.images.parallel import batch_of, ordered_map
from tumtools.model.camera import ROS_DEFAULT, calibration
from tumtools.model.digest import to_strings
from tumtools.model.sequence import TUM_DEPTH_UNITS_PER_METRE, Loss
from tumtools.model.text import default_layout

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from tumtools.formats.options import Progress, WriteOptions
    from tumtools.formats.rawlog.compression import Deflater
    from tumtools.model.camera import CameraInfo
    from tumtools.model.sequence import Frame, Sequence

_CONVERTER_UNITS_PER_METRE: Final = 1000.0
_IMU_BLOCK: Final = 1024
"""Accelerometer rows encoded at a time."""
_DEFAULT_SIZE: Final = (640, 480)
_DEFAULT_RANGE_UNITS: Final = 0.001
"""MRPT's, where a scan has no depth."""
_NS_PER_TICK: Final = 100
_DEPTH_SHARE: Final = 0.19
"""Typical size of a depth file as a share of 16-bit pixels, for the estimate."""
_SCAN_BYTES, _IMU_BYTES = 45, 30
"""Typical sizes of objects in the compressed rawlog, for the estimate."""


def write(sequence: Sequence, target: Path, options: WriteOptions, progress: Progress) -> tuple[Loss, ...]:
    """Write `NAME/NAME.rawlog`, `NAME/NAME_Images/` and `NAME/groundtruth.txt`; NAME is the target's.

    Args:
        sequence: Any; its depth as `needs` says.
        target: The folder to make.
        options: `dialect`, `compression`, `camera`, `cameras`, `jobs`.
        progress: Told of each image.

    Returns:
        What the dialect cannot hold.

    Raises:
        UsageError: An option that the dialect does not have.
        InputError: The sequence is damaged.

    """
    dialect, container = _choices(options)
    stem = target.name.removesuffix(SUFFIX)
    plan = _plan(sequence, dialect, stem, options)
    images = target / f"{stem}{IMAGES_SUFFIX}"
    images.mkdir(parents=True)
    if sequence.groundtruth is not None:
        (target / GROUNDTRUTH_FILE).write_bytes(_groundtruth_text(sequence))
    store = Store(images, dialect, container, plan.files())
    # The threads write files: none may do so when an error has left here and the folder is removed.
    images_stored = ordered_map(
        store, _wanted(sequence, store.names), options.jobs, batch=batch_of(sequence), join=True
    )
    with (
        closing(_Objects(target / f"{stem}{SUFFIX}", deflater(container))) as out,
        closing(images_stored),
    ):
        writer = _ScanWriter(out, sequence, plan, dialect, options)
        for stored in images_stored:
            writer.add(stored)
            progress(1, stored.nbytes)
        writer.finish()
    return plan.losses + tuple(writer.losses())


def needs(options: WriteOptions) -> Needs:
    """Depth is written from its pixels, as counts or metres; the dialect `converter` has millimetres."""
    dialect, _ = _choices(options)
    return Needs(
        depth_units_per_metre=None if dialect.lossless else _CONVERTER_UNITS_PER_METRE,
        float_depth_units_per_metre=None if dialect.float_depth else TUM_DEPTH_UNITS_PER_METRE,
        pixel_streams=frozenset({"depth"}),
        keeps_digest=dialect.lossless,
    )


def plan(sequence: Sequence, target: Path, options: WriteOptions) -> Plan:
    """Return what is known to be lost without looking at pixels, and the estimated size in bytes."""
    dialect, container = _choices(options)
    found = _plan(sequence, dialect, target.name.removesuffix(SUFFIX), options)
    size = len(found.slots) * _SCAN_BYTES + len(found.imu_ticks) * _IMU_BYTES
    for stream, image in sequence.info.images.items():
        if stream != "depth" and image.compression:
            size += image.nbytes
        else:
            pixels = image.count * image.width * image.height
            share = 1.0 if container == "none" else _DEPTH_SHARE
            size += int(pixels * 2 * share) if stream == "depth" else int(pixels * 1.5)
    if sequence.groundtruth is not None:
        size += len(_groundtruth_text(sequence))
    rows: dict[str, set[int]] = {stream: set() for stream in sequence.info.images}
    for stream, row in found.files():
        rows[stream].add(row)
    poses = 0 if sequence.groundtruth is None else len(sequence.groundtruth)
    return Plan(
        found.losses,
        size,
        tuple(_warnings(sequence, dialect, options)),
        rows,
        frames=sum(len(slot.keys) for slot in found.slots),
        rows=poses + len(found.imu_ticks),
    )


def _warnings(sequence: Sequence, dialect: Dialect, options: WriteOptions) -> Iterator[str]:
    known = options.camera or sequence.info.camera or options.cameras or sequence.cameras
    if dialect.lossless and sequence.info.images and not known:
        yield (
            "the camera is unknown, so the calibration written is that of ROS's default "
            "(525, 525, 319.5, 239.5); name it with --camera"
        )


def _choices(options: WriteOptions) -> tuple[Dialect, Container]:
    name = options.dialect or "modern"
    if name not in DIALECTS:
        raise UsageError(f"no dialect {name!r}", hint=f"dialects of rawlog: {', '.join(DIALECTS)}")
    container = options.compression or "gzip"
    if container not in CONTAINERS:
        raise UsageError(
            f"a rawlog is not compressed with {container}", hint=f"one of {', '.join(CONTAINERS)}"
        )
    if container == "zstd" and name != "modern":
        raise UsageError(
            f"readers of the dialect {name} do not know zstd", hint="only MRPT 3 reads it; use gzip or none"
        )
    return DIALECTS[name], container


def _plan(sequence: Sequence, dialect: Dialect, stem: str, options: WriteOptions) -> ScanPlan:
    if dialect.lossless:
        return plan_lossless(sequence)
    found = plan_converter(sequence)
    named = converter_name_losses(sequence, stem, known_camera(sequence, options))
    return replace(found, losses=(*found.losses, *named))


def _groundtruth_text(sequence: Sequence) -> bytes:
    trajectory = sequence.groundtruth
    if trajectory is None:
        return b""
    layout = sequence.info.text.get("groundtruth") or default_layout("groundtruth", sequence.info.name)
    layout = fit_layout(layout, trajectory.stamps, trajectory.values)
    return render(layout, "groundtruth", trajectory.stamps, trajectory.values)


def _wanted(sequence: Sequence, names: Mapping[Key, list[str]]) -> Iterator[Frame]:
    streams = sorted({stream for stream, _ in names})
    return (frame for frame in sequence.images(streams) if (frame.stream, frame.row) in names)


# --- the rawlog ---------------------------------------------------------------------------------------


class _Objects:
    """The rawlog file: objects go through the compressor as they come."""

    def __init__(self, path: Path, compressor: Deflater) -> None:
        self._file = path.open("wb")
        self._compressor = compressor

    def add(self, data: bytes) -> None:
        self._file.write(self._compressor.compress(data))

    def finish(self) -> None:
        self._file.write(self._compressor.flush())

    def close(self) -> None:
        self._file.close()


@dataclass(slots=True)
class _Rounded:
    """Depth images that rounding changed."""

    images: int = 0
    total: depth.Rounding = depth.EXACT

    def add(self, rounding: depth.Rounding) -> None:
        if rounding != depth.EXACT:
            self.images += 1
            self.total += rounding


@dataclass(slots=True)
class _ScanWriter:
    """Writes each scan, in the order of the plan, as soon as the files of its images are there."""

    out: _Objects
    sequence: Sequence
    plan: ScanPlan
    dialect: Dialect
    options: WriteOptions
    _stored: dict[Key, Stored] = field(init=False, default_factory=dict)
    _cameras: dict[tuple[str, int, int], bytes] = field(init=False, default_factory=dict)
    _uses: dict[Key, int] = field(init=False)
    _next_slot: int = field(init=False, default=0)
    _next_row: int = field(init=False, default=0)
    _rows_before: list[int] = field(init=False)
    _imu: ImuRows = field(init=False)
    _scans: Scans = field(init=False)
    _rounded: _Rounded = field(init=False, default_factory=_Rounded)

    def __post_init__(self) -> None:
        times = np.array([slot.ticks for slot in self.plan.slots], np.int64)
        self._rows_before = np.searchsorted(self.plan.imu_ticks, times, side="left").tolist()
        self._imu = ImuRows(self.dialect)
        self._scans = Scans(self.dialect)
        self._uses = {key: len(names) for key, names in self.plan.files().items()}
        if self.dialect.lossless:
            first = min(
                [slot.ticks for slot in self.plan.slots[:1]] + self.plan.imu_ticks[:1].tolist(), default=0
            )
            notes = _notes(self.sequence, self.dialect, self.options)
            self.out.add(comment_bytes(self.dialect, comment.dump(notes), first))

    def add(self, stored: Stored) -> None:
        """Take an image in and write the scans that were waiting for it."""
        self._stored[stored.key] = stored
        self._rounded.add(stored.rounding)
        slots = self.plan.slots
        while self._next_slot < len(slots) and all(
            key in self._stored for key in slots[self._next_slot].keys
        ):
            self._write_scan(slots[self._next_slot])
            self._next_slot += 1

    def finish(self) -> None:
        """Write the accelerometer rows after the last scan, and the digest if somebody notes it.

        Raises:
            InternalError: An image of the plan never came.

        """
        if self._next_slot < len(self.plan.slots):
            waiting = self.plan.slots[self._next_slot].keys
            raise InternalError(f"the sequence did not deliver all of {waiting}")
        self._write_imu(len(self.plan.imu_ticks))
        digest = self.sequence.noted_digest()
        if digest is not None and self.dialect.lossless:
            last = max(
                [slot.ticks for slot in self.plan.slots[-1:]] + self.plan.imu_ticks[-1:].tolist(), default=0
            )
            self.out.add(comment_bytes(self.dialect, comment.dump_digest(to_strings(digest)), last))
        self.out.finish()

    def losses(self) -> Iterator[Loss]:
        """Yield what was lost in the pixels."""
        if self._rounded.images:
            why = "a depth file holds 16-bit counts"
            error = self._rounded.total.largest_error
            yield Loss(
                "depth", "depth rounded to 1/5000 m", self._rounded.images, why, error, "m", ("pixels",)
            )
        if self._rounded.total.clipped:
            why = "the depth is outside of what 16 bits hold in this unit; it became 0, no reading"
            yield Loss("depth", "pixels out of range", self._rounded.total.clipped, why, alters=("pixels",))

    def _write_scan(self, slot: Slot) -> None:
        self._write_imu(self._rows_before[self._next_slot])
        image = self._take(slot.image)
        depth_image = self._take(slot.depth)
        stream = slot.image[0] if slot.image else "rgb"
        kind = ScanKind(
            has_image=image is not None,
            has_depth=depth_image is not None,
            range_units=_DEFAULT_RANGE_UNITS if depth_image is None else depth_image.range_units,
            channel=INFRARED if stream == "ir" else VISIBLE,
            depth_camera=self._camera("depth", depth_image or image),
            image_camera=self._camera(stream, image or depth_image),
        )
        image_file = "" if image is None else slot.image_file + image.suffix
        depth_file = "" if depth_image is None else slot.depth_file + depth_image.suffix
        self.out.add(self._scans.encode(kind, slot.ticks, image_file, depth_file))

    def _take(self, key: Key | None) -> Stored | None:
        """Return an image, and forget it after its last use."""
        if key is None:
            return None
        self._uses[key] -= 1
        return self._stored[key] if self._uses[key] else self._stored.pop(key)

    def _camera(self, stream: str, image: Stored | None) -> bytes:
        width, height = _DEFAULT_SIZE if image is None else (image.width, image.height)
        key = (stream, width, height)
        if key not in self._cameras:
            camera = _camera_of(self.sequence, self.dialect, self.options, stream, width, height)
            self._cameras[key] = CODEC.encode(camera_record(self.dialect, camera))
        return self._cameras[key]

    def _write_imu(self, end: int) -> None:
        accelerometer = self.sequence.accelerometer
        while accelerometer is not None and self._next_row < end:
            stop = min(end, self._next_row + _IMU_BLOCK)
            rows = self.plan.imu_rows[self._next_row : stop]
            ticks = self.plan.imu_ticks[self._next_row : stop]
            self.out.add(self._imu.encode(ticks, accelerometer.values[rows]))
            self._next_row = stop


def _camera_of(
    sequence: Sequence, dialect: Dialect, options: WriteOptions, stream: str, width: int, height: int
) -> CameraInfo:
    """Choose the intrinsics to write; the program that the other dialect follows has but one."""
    if not dialect.lossless:
        return calibration(ROS_DEFAULT, stream, *_DEFAULT_SIZE)
    return chosen_calibration(sequence, options, stream, width, height)


def _notes(sequence: Sequence, dialect: Dialect, options: WriteOptions) -> comment.Notes:
    info = sequence.info
    accelerometer = sequence.accelerometer
    counts = {stream: len(sequence.image_stamps(stream)) for stream in info.images}
    places = dict.fromkeys(info.images, SCAN_LABEL)
    remainders: tuple[int, ...] = ()
    if accelerometer is not None:
        counts[ACCELEROMETER] = len(accelerometer)
        places[ACCELEROMETER] = IMU_LABEL
        rest = np.sort(accelerometer.stamps, kind="stable") % _NS_PER_TICK
        remainders = tuple(rest.tolist()) if rest.any() else ()
    if sequence.groundtruth is not None:
        places["groundtruth"] = GROUNDTRUTH_FILE
    return comment.Notes(
        metadata=metadata.gather(sequence, places, options.camera),
        dialect=dialect.name,
        counts=counts,
        frame_ids=dict(info.frame_ids),
        accelerometer_remainders_ns=remainders,
        cameras={**({} if options.camera else sequence.cameras), **options.cameras},
    )
