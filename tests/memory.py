# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A sequence that is made of arrays, for tests that need particular contents."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tumtools.images.codec import image_of_pixels, image_of_png, png_of
from tumtools.model.sequence import IMAGE_STREAMS, Frame, ImageStreamInfo, Sequence, SequenceInfo, frame_order
from tumtools.model.signals import Accelerometer, Trajectory

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator

    import numpy.typing as npt

    from tumtools.model.image import Image

SECOND = 1_000_000_000
START = 1_305_031_102 * SECOND
DEPTH_VALUES = (0, 1, 4999, 5000, 5001, 32767, 65534, 65535)


def picture(stream: str, row: int, width: int = 8, height: int = 6, *, encoding: str | None = None) -> Image:
    """Return a PNG image, its pixels different in each row; or raw pixels of an encoding."""
    random = np.random.default_rng([IMAGE_STREAMS.index(stream), row])
    if stream == "depth":
        pixels = random.choice(np.array(DEPTH_VALUES, np.uint16), (height, width))
        return image_of_png(png_of(image_of_pixels(pixels, "16UC1", 5000.0)), 5000.0)
    shape = (height, width) if stream == "ir" or encoding == "mono8" else (height, width, 3)
    image = image_of_pixels(
        random.integers(0, 256, shape, np.uint8), encoding or ("mono8" if len(shape) == 2 else "rgb8")
    )
    return image if encoding else image_of_png(png_of(image))


class Memory(Sequence):
    """Images at the given stamps, rows in the order given, and signals."""

    def __init__(
        self,
        stamps: dict[str, list[int]],
        *,
        accelerometer: Accelerometer | None = None,
        groundtruth: Trajectory | None = None,
        encoding: str | None = None,
        **info: object,
    ) -> None:
        self._stamps = stamps
        self._encoding = encoding
        self.accelerometer = accelerometer
        self.groundtruth = groundtruth
        images = {}
        for stream in IMAGE_STREAMS:
            if stream in stamps:
                first = picture(stream, 0, encoding=None if stream == "depth" else encoding)
                images[stream] = ImageStreamInfo(
                    count=len(stamps[stream]),
                    encoding=first.encoding,
                    width=first.width,
                    height=first.height,
                    depth_units_per_metre=first.depth_units_per_metre,
                    nbytes=first.nbytes * len(stamps[stream]),
                    compression=first.compression,
                )
        defaults: dict[str, object] = {"name": "memory", "format": "memory", "camera": "fr1"}
        self.info = SequenceInfo(images=images, **defaults | info)  # type: ignore[arg-type]  # as given

    def image_stamps(self, stream: str) -> npt.NDArray[np.int64]:
        return np.array(self._stamps.get(stream, []), np.int64)

    def images(
        self, streams: Collection[str] | None = None, start: int | None = None, end: int | None = None
    ) -> Iterator[Frame]:
        frames = [
            Frame(stream, stamp, row, lambda stream=stream, row=row: self._load(stream, row))
            for stream in self._stamps
            if stream in IMAGE_STREAMS and (streams is None or stream in streams)
            for row, stamp in enumerate(self._stamps[stream])
            if (start is None or stamp >= start) and (end is None or stamp <= end)
        ]
        return iter(sorted(frames, key=frame_order))

    def _load(self, stream: str, row: int) -> Image:
        return picture(stream, row, encoding=None if stream == "depth" else self._encoding)


def accelerometer(*stamps: int) -> Accelerometer:
    """Return rows with values that no short decimal prints."""
    values = np.random.default_rng(1).normal(size=(len(stamps), 3))
    return Accelerometer(np.array(stamps, np.int64), values)


def groundtruth(*stamps: int) -> Trajectory:
    """Return poses; their quaternions are not normalised."""
    values = np.random.default_rng(2).normal(size=(len(stamps), 7))
    return Trajectory(np.array(stamps, np.int64), values[:, :3].copy(), values[:, 3:].copy())


def full() -> Memory:
    """Return three images of each kind, some at equal stamps, and signals."""
    times = [START, START + 100, START + SECOND]
    return Memory(
        {"rgb": times, "depth": times, "ir": times},
        accelerometer=accelerometer(*times),
        groundtruth=groundtruth(*times),
    )
