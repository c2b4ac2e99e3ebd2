# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A sequence made up in memory, every part of which a test can choose."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from tumtools.images import png
from tumtools.images.codec import image_of_png
from tumtools.model.sequence import Frame, ImageStreamInfo, Sequence, SequenceInfo, frame_order
from tumtools.model.signals import Accelerometer, Trajectory

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator

    import numpy.typing as npt

    from tumtools.model.image import Image

WIDTH, HEIGHT = 4, 3


class Made(Sequence):
    """See `made`; `load_rgb`, `load_depth` and `info` may be replaced."""

    def __init__(self, stamps: dict[str, list[int]], colours: list[int], name: str) -> None:
        self._stamps = {stream: np.array(values, np.int64) for stream, values in stamps.items()}
        self._colours = colours
        self.info = SequenceInfo(
            name=name,
            format="made",
            images={stream: self._describe(stream) for stream in self._stamps},
        )

    def _describe(self, stream: str) -> ImageStreamInfo:
        encoding, units = ("16UC1", 5000.0) if stream == "depth" else ("rgb8", None)
        count = len(self._stamps[stream])
        return ImageStreamInfo(count, encoding, WIDTH, HEIGHT, units, None, 100 * count, "png")

    def load_rgb(self, number: int) -> Image:
        return image_of_png(png.encode(np.full((HEIGHT, WIDTH, 3), self._colours[number], np.uint8)))

    def load_depth(self) -> Image:
        return image_of_png(
            png.encode(np.arange(WIDTH * HEIGHT, dtype=np.uint16).reshape(HEIGHT, WIDTH)), 5000.0
        )

    def image_stamps(self, stream: str) -> npt.NDArray[np.int64]:
        return self._stamps.get(stream, np.empty(0, np.int64))

    def images(
        self, streams: Collection[str] | None = None, start: int | None = None, end: int | None = None
    ) -> Iterator[Frame]:
        frames = [
            Frame(stream, stamp, row, partial(self.load_rgb, row) if stream == "rgb" else self.load_depth)
            for stream, stamps in self._stamps.items()
            for row, stamp in enumerate(stamps.tolist())
            if (streams is None or stream in streams)
            and (start is None or stamp >= start)
            and (end is None or stamp <= end)
        ]
        return iter(sorted(frames, key=frame_order))


def made(
    *,
    name: str = "made",
    rgb: list[int] | None = None,
    depth: list[int] | None = None,
    colours: list[int] | None = None,
    accelerometer: list[tuple[int, tuple[float, float, float]]] | None = None,
    groundtruth: list[int] | None = None,
) -> Made:
    """Make up a sequence.

    Args:
        name: Of the sequence.
        rgb: Stamps of the colour images, nanoseconds.
        depth: Stamps of the depth images; None for no depth.
        colours: Grey value of each colour image; their number unless told.
        accelerometer: Stamps and values.
        groundtruth: Stamps of poses at the origin.

    """
    rgb = [10**9, 2 * 10**9, 3 * 10**9] if rgb is None else rgb
    stamps = {"rgb": rgb} | ({} if depth is None else {"depth": depth})
    sequence = Made(stamps, list(range(len(rgb))) if colours is None else colours, name)
    if accelerometer is not None:
        times = np.array([stamp for stamp, _ in accelerometer], np.int64)
        values = np.array([values for _, values in accelerometer], np.float64).reshape(len(times), 3)
        sequence.accelerometer = Accelerometer(times, values)
    if groundtruth is not None:
        count = len(groundtruth)
        rotations = np.tile([0.0, 0.0, 0.0, 1.0], (count, 1))
        sequence.groundtruth = Trajectory(np.array(groundtruth, np.int64), np.zeros((count, 3)), rotations)
    return sequence
