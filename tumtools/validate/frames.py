# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What is measured of each image, in one pass over its pixels, so that no rule needs to see them again."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np
from isal import isal_zlib

from tumtools.errors import InputError
from tumtools.images import png
from tumtools.images.codec import canonical, pixels_of
from tumtools.images.depth import count_levels
from tumtools.validate.depth_scale import DepthScale, measure_depth_scale

if TYPE_CHECKING:
    import numpy.typing as npt

    from tumtools.model.image import Image
    from tumtools.model.sequence import Frame

COUNTS: Final = 65_536
NO_READING_ELSEWHERE: Final = 65_535
"""What other cameras write for "no reading", where the benchmark has 0."""
_SAMPLED_ROWS: Final = 30
_LEAST_PAIRS: Final = 500
"""Fewer neighbours with readings say nothing about the order of bytes."""
_COLOUR_STEP: Final = 8
_GREY_CHANNELS: Final = 2


@dataclass(frozen=True, slots=True, eq=False)
class DepthFacts:
    """What is measured of a depth image, in counts (float metres: in millimetres, rounded).

    Attributes:
        zero_share: Share of pixels without a reading.
        nearest: Smallest count but 0; 0 if there is none.
        farthest: Greatest count; 65535 is left out where other cameras use it for "no reading".
        no_reading_elsewhere: Pixels of 65535.
        distinct: Distinct counts but 0.
        low_bytes: Distinct low bytes among them.
        high_bytes: Distinct high bytes among them.
        swapped_ratio: How much rougher the image is as it stands than with its bytes swapped; above 1,
            swapping makes it smoother.
        scale: Measure of its quantisation.

    """

    zero_share: float
    nearest: int
    farthest: int
    no_reading_elsewhere: int
    distinct: int
    low_bytes: int
    high_bytes: int
    swapped_ratio: float
    scale: DepthScale | None


@dataclass(frozen=True, slots=True, eq=False)
class FrameFacts:
    """What is measured of an image.

    Attributes:
        stream: Its stream.
        row: Its row, 0 = first.
        stamp: Nanoseconds since 1970.
        width: Columns; 0 if it cannot be read.
        height: Rows.
        encoding: As in `Image`; empty if it cannot be read.
        png_kind: Bit depth and colour type of a PNG file; None for other images.
        depth_units_per_metre: Declared, where it is depth.
        error: Why it cannot be read or decoded.
        fingerprint: Equal for images that are equal; None if it was not decoded.
        constant: The one value of all pixels, or None.
        red: Mean of the red channel, 0 .. 255, from a sample of the pixels; None but for colour.
        blue: Mean of the blue channel.
        depth: Of depth images that were decoded.

    """

    stream: str
    row: int
    stamp: int
    width: int = 0
    height: int = 0
    encoding: str = ""
    png_kind: tuple[int, int] | None = None
    depth_units_per_metre: float | None = None
    error: InputError | None = None
    fingerprint: tuple[int, int, int] | None = None
    constant: int | None = None
    red: float | None = None
    blue: float | None = None
    depth: DepthFacts | None = None


def measure(frame: Frame, *, decode: bool) -> tuple[FrameFacts, npt.NDArray[np.int64] | None]:
    """Load an image and measure it; a damaged one gives facts with an error.

    Args:
        frame: The image.
        decode: Look at the pixels, too.

    Returns:
        The facts, and for decoded depth the histogram of its counts, shape [65536].

    """
    try:
        image = frame.load()
        header = None if image.png is None else png.header(image.png)
        facts = FrameFacts(
            frame.stream,
            frame.row,
            frame.stamp,
            image.width,
            image.height,
            image.encoding,
            None if header is None else (header.bit_depth, header.colour_type),
            image.depth_units_per_metre,
        )
        if not decode:
            return facts, None
        pixels, _ = canonical(pixels_of(image), image.encoding)
    except InputError as error:
        return FrameFacts(frame.stream, frame.row, frame.stamp, error=error), None
    low, high = pixels.min(), pixels.max()
    facts = replace(
        facts, fingerprint=_fingerprint(image, pixels), constant=int(low) if low == high else None
    )
    if frame.stream == "depth" and pixels.ndim == _GREY_CHANNELS and pixels.dtype != np.uint8:
        depth, histogram = _measure_depth(pixels)
        return replace(facts, depth=depth), histogram
    if pixels.ndim > _GREY_CHANNELS:
        sample = pixels[::_COLOUR_STEP, ::_COLOUR_STEP]
        return replace(facts, red=float(sample[..., 0].mean()), blue=float(sample[..., 2].mean())), None
    return facts, None


def _fingerprint(image: Image, pixels: npt.NDArray[np.generic]) -> tuple[int, int, int]:
    """Return two checksums and the length, of the file where there is one: equal images have equal files."""
    data = image.compressed if image.compressed is not None else np.ascontiguousarray(pixels).data.cast("B")
    return isal_zlib.crc32(data), isal_zlib.adler32(data), len(data)


def depth_counts(pixels: npt.NDArray[np.generic]) -> npt.NDArray[np.uint16]:
    """Return depth as counts: as it is, or float metres as whole millimetres with 0 for no reading."""
    if pixels.dtype.kind == "f":
        counts = np.empty(pixels.shape, np.uint16)
        for row, metres in enumerate(pixels):  # one row at a time fits into the cache
            with np.errstate(invalid="ignore"):
                scaled = np.nan_to_num(metres.astype(np.float64) * 1000, nan=0.0, posinf=0.0, neginf=0.0)
            counts[row] = np.clip(np.rint(scaled), 0, NO_READING_ELSEWHERE - 1)
        return counts
    return pixels.astype(np.uint16, copy=False)


def _measure_depth(pixels: npt.NDArray[np.generic]) -> tuple[DepthFacts, npt.NDArray[np.int64]]:
    counts = depth_counts(pixels)
    histogram = count_levels(counts)
    present = np.flatnonzero(histogram)
    present = present[present > 0]
    sensible = present[present != NO_READING_ELSEWHERE]
    facts = DepthFacts(
        zero_share=float(histogram[0] / counts.size),
        nearest=int(sensible[0]) if len(sensible) else 0,
        farthest=int(sensible[-1]) if len(sensible) else 0,
        no_reading_elsewhere=int(histogram[NO_READING_ELSEWHERE]),
        distinct=len(present),
        low_bytes=len(np.unique(present & 0xFF)),
        high_bytes=len(np.unique(present >> 8)),
        swapped_ratio=_swapped_ratio(counts),
        scale=measure_depth_scale(sensible.astype(np.uint16)),
    )
    return facts, histogram


def _swapped_ratio(counts: npt.NDArray[np.uint16]) -> float:
    """Compare the mean step between neighbours as they stand and with their bytes swapped."""
    rows = counts[:: max(1, len(counts) // _SAMPLED_ROWS)]
    both = (rows[:, 1:] > 0) & (rows[:, :-1] > 0)
    if int(both.sum()) < _LEAST_PAIRS:
        return 0.0
    steps = [
        float(np.abs(np.diff(values.astype(np.int32), axis=1))[both].mean())
        for values in (rows, rows.byteswap())
    ]
    return steps[0] / steps[1] if steps[1] else float(bool(steps[0])) * COUNTS
