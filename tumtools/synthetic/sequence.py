# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The synthetic sequence: motion, room and sensors put together as a `Sequence`."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.errors import UsageError
from tumtools.model.camera import calibration
from tumtools.model.image import ENCODINGS, Image
from tumtools.model.sequence import (
    IMAGE_STREAMS,
    STREAMS,
    TUM_DEPTH_UNITS_PER_METRE,
    Frame,
    ImageStreamInfo,
    Sequence,
    SequenceInfo,
    frame_order,
)
from tumtools.model.signals import Accelerometer, Trajectory
from tumtools.model.text import default_layout
from tumtools.synthetic import sensor
from tumtools.synthetic.bake import bake
from tumtools.synthetic.motion import GRAVITY, Motion, rotate_back, rotation_matrices
from tumtools.synthetic.render import camera_rays, cast, shade

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator

    import numpy.typing as npt

    Floats = npt.NDArray[np.float64]
    Stamps = npt.NDArray[np.int64]

DEFAULT_STREAMS: Final = ("rgb", "depth", "accelerometer", "groundtruth")

# First colour stamp of each camera's sequences: in the months in which the real ones were recorded.
_FIRST_STAMP: Final = {
    "fr1": 1_305_031_000_015_342_000,
    "fr2": 1_311_868_000_022_718_000,
    "fr3": 1_341_845_000_009_554_000,
}
_ENCODING: Final = {"rgb": "rgb8", "depth": "16UC1", "ir": "mono8"}
_FRAME_PERIOD: Final = 33_333_333
_DEPTH_DELAY: Final = 20_000_000
_MICROSECOND: Final = 1000
_ACCELEROMETER_PERIOD: Final = 2_000_000
_GROUNDTRUTH_PERIOD: Final = 10_000_000
_LEAD: Final = 500_000_000
"""Signals start this much before the first image, and end as much after the last; nanoseconds."""
_MAX_FRAMES: Final = 100_000
_MAX_SIDE: Final = 4096

_MOUNTING: Final = (-0.36, 0.42, 0.55, 0.625)
"""Rotation of the accelerometer's axes into the camera's (x y z w, normalised where it is used)."""
_ACCELEROMETER_NOISE: Final = 0.06
_ACCELEROMETER_STEP: Final = 9.80665 / 819
"""m/s2 per count of the Kinect's 12-bit accelerometer at its range of 2 g."""


def synthesize(
    frames: int = 60,
    seed: int = 0,
    camera: str = "fr1",
    width: int = 640,
    height: int = 480,
    streams: Collection[str] = DEFAULT_STREAMS,
) -> Sequence:
    """Make up a sequence of a hand-held Kinect in a furnished room, consistent in all its signals.

    Images are rendered when they are asked for, so this returns at once; the same arguments give the
    same values.

    Args:
        frames: Images per stream, at 30 Hz.
        seed: Decides the path, the room and the noise; not negative.
        camera: `fr1`, `fr2` or `fr3`: whose intrinsics and distortion, and in which months.
        width: Columns of the images.
        height: Rows of the images.
        streams: What it has, of `model.sequence.STREAMS`.

    Raises:
        UsageError: An argument is out of range.

    """
    if camera not in _FIRST_STAMP:
        raise UsageError(f"no synthetic sequence for camera {camera!r}", hint="choose fr1, fr2 or fr3")
    if not 1 <= frames <= _MAX_FRAMES:
        raise UsageError(f"frames must be 1 .. {_MAX_FRAMES}, not {frames}")
    if seed < 0:
        raise UsageError(f"the seed must not be negative: {seed}")
    if not 8 <= min(width, height) <= max(width, height) <= _MAX_SIDE:  # noqa: PLR2004 - the smallest picture that makes sense
        raise UsageError(f"images must have sides of 8 .. {_MAX_SIDE} pixels, not {width} x {height}")
    unknown = sorted(set(streams) - set(STREAMS))
    if unknown:
        raise UsageError(f"unknown stream {unknown[0]!r}", hint=f"streams are {', '.join(STREAMS)}")
    return _Synthetic(frames, seed, camera, (width, height), frozenset(streams))


class _Synthetic(Sequence):
    """See `synthesize`."""

    def __init__(
        self, frames: int, seed: int, camera: str, size: tuple[int, int], streams: frozenset[str]
    ) -> None:
        self._seed = seed
        self._size = size
        self._focal_length = calibration(camera, "rgb", *size).k[0]
        self._rays = {
            sensor_name: camera_rays(calibration(camera, sensor_name, *size)) for sensor_name in ("rgb", "ir")
        }
        self._motion = Motion.from_seed(seed)
        self._start = _FIRST_STAMP[camera]
        self._stamps: dict[str, Stamps] = {
            stream: self._image_stamps(stream, frames) for stream in IMAGE_STREAMS if stream in streams
        }
        end = self._start + frames * _FRAME_PERIOD
        if "groundtruth" in streams:
            self.groundtruth = self._make_groundtruth(end)
        if "accelerometer" in streams:
            self.accelerometer = self._make_accelerometer(end)
        name = f"synthetic_freiburg{camera[-1]}_room"
        self.info = SequenceInfo(
            name=name,
            format="synthetic",
            camera=camera,
            images={stream: self._stream_info(stream, frames) for stream in self._stamps},
            text={stream: default_layout(stream, name) for stream in STREAMS if stream in streams},
            licence="CC0-1.0",
            citation="synthetic sequence, made by tumtools",
        )

    def _random(self, *key: int) -> np.random.Generator:
        """Return a stream of random numbers of its own, so that frames can be made in any order."""
        return np.random.Generator(np.random.PCG64([self._seed, 3, *key]))

    def _stream_info(self, stream: str, frames: int) -> ImageStreamInfo:
        width, height = self._size
        encoding = ENCODINGS[_ENCODING[stream]]
        return ImageStreamInfo(
            count=frames,
            encoding=encoding.name,
            width=width,
            height=height,
            depth_units_per_metre=TUM_DEPTH_UNITS_PER_METRE if stream == "depth" else None,
            nbytes=frames * width * height * encoding.bytes_per_pixel,
            source="synthetic",
        )

    def _image_stamps(self, stream: str, frames: int) -> Stamps:
        """Return 30 Hz with jitter, whole microseconds; depth and infrared come about 20 ms later."""
        late = stream != "rgb"
        jitter = self._random(0, IMAGE_STREAMS.index(stream)).integers(-900, 900, frames) * (1 + late)
        regular = self._start + late * _DEPTH_DELAY + _FRAME_PERIOD * np.arange(frames)
        stamps: Stamps = (regular // _MICROSECOND + jitter) * _MICROSECOND
        return stamps

    def _seconds(self, stamps: Stamps) -> Floats:
        return (stamps - self._start) / 1e9

    def _make_groundtruth(self, end: int) -> Trajectory:
        """Return the motion at 100 Hz, rounded to the four decimals that are published."""
        first = (self._start - _LEAD) // _GROUNDTRUTH_PERIOD * _GROUNDTRUTH_PERIOD + 3_100_000
        stamps = np.arange(first, end + _LEAD, _GROUNDTRUTH_PERIOD, dtype=np.int64)
        seconds = self._seconds(stamps)
        return Trajectory(
            stamps,
            np.round(self._motion.positions(seconds), 4),
            np.round(self._motion.quaternions(seconds), 4),
        )

    def _make_accelerometer(self, end: int) -> Accelerometer:
        """Return specific force R^T (a - g) in the sensor's axes at 500 Hz, with noise, in its counts."""
        random = self._random(1)
        regular = np.arange(self._start - _LEAD, end + _LEAD, _ACCELEROMETER_PERIOD, dtype=np.int64)
        stamps = (regular // _MICROSECOND + random.integers(-150, 150, len(regular))) * _MICROSECOND
        seconds = self._seconds(stamps)
        force = self._motion.accelerations(seconds) + np.array([0.0, 0.0, GRAVITY])
        in_camera = rotate_back(rotation_matrices(self._motion.quaternions(seconds)), force)
        mounting = np.array([_MOUNTING])
        mounting /= np.sqrt((mounting * mounting).sum())
        values = rotate_back(rotation_matrices(mounting), in_camera)
        values += random.normal(0, _ACCELEROMETER_NOISE, values.shape)
        return Accelerometer(stamps, np.round(np.rint(values / _ACCELEROMETER_STEP) * _ACCELEROMETER_STEP, 6))

    def image_stamps(self, stream: str) -> Stamps:
        """See `Sequence`."""
        return self._stamps[stream] if stream in self._stamps else np.empty(0, np.int64)

    def images(
        self, streams: Collection[str] | None = None, start: int | None = None, end: int | None = None
    ) -> Iterator[Frame]:
        """See `Sequence`."""
        frames = [
            Frame(stream, stamp, row, partial(self._render, stream, stamp, row))
            for stream, stamps in self._stamps.items()
            if streams is None or stream in streams
            for row, stamp in enumerate(stamps.tolist())
            if (start is None or stamp >= start) and (end is None or stamp <= end)
        ]
        yield from sorted(frames, key=frame_order)

    def _render(self, stream: str, stamp: int, row: int) -> Image:
        width, height = self._size
        scene = bake(self._seed, round(0.0025 * 640 / width, 6))
        seconds = self._seconds(np.array([stamp]))
        rotation = rotation_matrices(self._motion.quaternions(seconds))[0]
        rays = self._rays["ir" if stream == "ir" else "rgb"]
        view = cast(scene, rays, self._motion.positions(seconds)[0], rotation)
        random = self._random(2, IMAGE_STREAMS.index(stream), row)
        if stream == "depth":
            return Image(
                width,
                height,
                _ENCODING[stream],
                TUM_DEPTH_UNITS_PER_METRE,
                pixels=sensor.depth_image(scene, view, random),
            )
        shaded = shade(scene, view, self._focal_length)
        if stream == "ir":
            return Image(width, height, _ENCODING[stream], pixels=sensor.infrared_image(view, shaded, random))
        return Image(width, height, _ENCODING[stream], pixels=sensor.colour_image(shaded, random))
