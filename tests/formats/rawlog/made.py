# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Small sequences and objects to write and read."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from tumtools.formats.options import ReadOptions, WriteOptions, no_progress
from tumtools.formats.rawlog import reader, writer
from tumtools.formats.rawlog.archive import Record
from tumtools.formats.rawlog.classes import CODEC
from tumtools.images.codec import image_of_png
from tumtools.images.png import encode
from tumtools.model.sequence import IMAGE_STREAMS, Frame, ImageStreamInfo, Sequence, SequenceInfo, frame_order
from tumtools.model.signals import Accelerometer, Trajectory

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Iterator
    from pathlib import Path

    import numpy.typing as npt

    from tumtools.model.image import Image

COLLECTION = "CActionCollection"
FIRST = 1_305_031_229_528_748_000
FRAME_NS = 33_333_000


class Made(Sequence):
    """A sequence in memory."""

    def __init__(
        self,
        images: dict[str, list[tuple[int, Image]]],
        accelerometer: Accelerometer | None = None,
        groundtruth: Trajectory | None = None,
        **info: object,
    ) -> None:
        self._images = images
        self.accelerometer = accelerometer
        self.groundtruth = groundtruth
        self.info = SequenceInfo(
            name="made",
            format="made",
            images={stream: _info(rows) for stream, rows in images.items()},
            **info,
        )

    def image_stamps(self, stream: str) -> npt.NDArray[np.int64]:
        return np.array([stamp for stamp, _ in self._images.get(stream, [])], np.int64)

    def images(
        self, streams: Collection[str] | None = None, start: int | None = None, end: int | None = None
    ) -> Iterator[Frame]:
        frames = [
            Frame(stream, stamp, row, partial(lambda image: image, image))
            for stream, rows in self._images.items()
            for row, (stamp, image) in enumerate(rows)
            if (streams is None or stream in streams)
            and (start is None or stamp >= start)
            and (end is None or stamp <= end)
        ]
        return iter(sorted(frames, key=frame_order))


def _info(rows: list[tuple[int, Image]]) -> ImageStreamInfo:
    if not rows:
        return ImageStreamInfo(0)
    image = rows[0][1]
    return ImageStreamInfo(
        len(rows), image.encoding, image.width, image.height, image.depth_units_per_metre, None, image.nbytes
    )


def colour(seed: int = 0, width: int = 8, height: int = 6) -> Image:
    """A colour image as a PNG file."""
    return image_of_png(encode(np.random.default_rng(seed).integers(0, 256, (height, width, 3), np.uint8)))


def depth(seed: int = 0, units: float = 5000.0, width: int = 8, height: int = 6) -> Image:
    """A depth image in counts, some without a reading."""
    pixels = np.random.default_rng(seed).integers(0, 65536, (height, width), np.uint16)
    pixels[0, 0] = 0
    return image_of_png(encode(pixels), units)


def accelerometer(stamps: Iterable[int]) -> Accelerometer:
    """Rows with different values."""
    times = np.array(list(stamps), np.int64)
    return Accelerometer(times, np.random.default_rng(1).normal(0, 9.81, (len(times), 3)))


def groundtruth(count: int = 3) -> Trajectory:
    """Poses with four decimals."""
    stamps = FIRST // 100_000 * 100_000 + 10_000_000 * np.arange(count, dtype=np.int64)
    values = np.round(np.random.default_rng(2).normal(0, 1, (count, 7)), 4)
    return Trajectory(stamps, values[:, :3], values[:, 3:])


def typical(frames: int = 3) -> Made:
    """Colour and depth a little apart, an accelerometer, ground truth."""
    times = [FIRST + FRAME_NS * number for number in range(frames)]
    return Made(
        {
            "rgb": [(time, colour(number)) for number, time in enumerate(times)],
            "depth": [(time + 36_000, depth(number)) for number, time in enumerate(times)],
        },
        accelerometer(range(FIRST - 5_000_000, FIRST + frames * FRAME_NS, 2_000_000)),
        groundtruth(),
    )


def written(sequence: Sequence, folder: Path, **options: object) -> Path:
    """Write a sequence; return the rawlog."""
    target = folder / "made"
    writer.write(sequence, target, WriteOptions(**options), no_progress)
    return target / "made.rawlog"


def opened(path: Path, **options: object) -> reader.RawlogSequence:
    """Open a rawlog."""
    return reader.RawlogSequence(reader.find(path), ReadOptions(**options))


def names_of(sequence: Sequence) -> dict[str, list[tuple[int, int]]]:
    """Stamp and row of each image by stream, in the order delivered."""
    found: dict[str, list[tuple[int, int]]] = {stream: [] for stream in IMAGE_STREAMS}
    for frame in sequence.images():
        found[frame.stream].append((frame.stamp, frame.row))
    return {stream: rows for stream, rows in found.items() if rows}


# --- objects as other programs write them -------------------------------------------------------------

IDENTITY = np.array([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1], "<f8")
TICKS = 129_495_048_295_287_480


def pose() -> Record:
    return Record("mrpt::poses::CPose3D", 3, {"values": IDENTITY})


def camera(rows: int = 6, columns: int = 8) -> Record:
    return Record(
        "mrpt::img::TCamera",
        6,
        {
            "focal_length_metres": 0.0,
            "distortion": np.zeros(8, "<f8"),
            "fx_fy_cx_cy": np.array([7.0, 7.5, 3.5, 2.5], "<f8"),
            "rows": rows,
            "columns": columns,
            "name": "camera1",
            "model": 0,
        },
    )


def image_record(pixels: npt.NDArray[np.uint8]) -> Record:
    """A raw BGR image as MRPT 2 embeds it."""
    height, width = pixels.shape[:2]
    fields: dict[str, object] = {"external": 0, "colour": 1, "width": -width, "height": -height}
    return Record("mrpt::img::CImage", 9, {**fields, "data": pixels.reshape(-1)})


def scan(ticks: int = TICKS, label: str = "CAM", **changes: object) -> Record:
    """A scan with nothing but what is given."""
    fields: dict[str, object] = {
        "max_range": 5.0,
        "sensor_pose": pose(),
        "has_points": 0,
        "has_range": 0,
        "range_units": 0.001,
        "has_intensity": 0,
        "has_confidence": 0,
        "camera": camera(),
        "camera_intensity": camera(),
        "intensity_pose": pose(),
        "std_error": 0.01,
        "time": ticks,
        "label": label,
        "points_external": 0,
        "points_file": "",
        "range_external": 0,
        "range_file": "",
        "range_is_depth": 1,
        "channel": 0,
        "has_labels": 0,
        "layers": [],
    }
    return Record("mrpt::obs::CObservation3DRangeScan", 10, fields | changes)


def with_depth(counts: npt.NDArray[np.uint16]) -> dict[str, object]:
    """Fields of a scan with embedded depth."""
    rows, columns = counts.shape
    return {"has_range": 1, "rows": rows, "columns": columns, "range": counts.reshape(-1)}


def imu(ticks: int = TICKS, label: str = "IMU", channels: int = 3) -> Record:
    """An IMU object whose first channels are there."""
    present = (np.arange(31) < channels).astype(np.uint8)
    fields: dict[str, object] = {"sensor_pose": pose(), "present": present, "time": ticks}
    return Record(
        "mrpt::obs::CObservationIMU", 4, {**fields, "values": np.arange(31, dtype="<f8"), "label": label}
    )


def save(path: Path, *records: Record) -> Path:
    """Write objects, not compressed."""
    path.write_bytes(b"".join(CODEC.encode(record) for record in records))
    return path
