# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A content digest that does not depend on the format; defined in docs/reference/digest.md, version 2.

Equal digests mean equal streams: the same stamps to the nanosecond, the same values to the bit and the
same pixels, in whichever container and encoding they are kept.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.errors import InputError
from tumtools.images.codec import canonical, pixels_of
from tumtools.images.depth import divided, exact_counts
from tumtools.images.parallel import batch_of, ordered_map
from tumtools.model.digest import VERSION, digest_of_images, digest_of_rows
from tumtools.model.sequence import TUM_DEPTH_UNITS_PER_METRE

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    import numpy.typing as npt

    from tumtools.formats.options import Progress
    from tumtools.model.image import Image
    from tumtools.model.sequence import Frame, Sequence

_MAGNITUDE: Final = np.uint32(0x7FFFFFFF)
_INFINITY: Final = np.uint32(0x7F800000)
"""Bits of float32: all but the sign, and those of infinity, above which is NaN."""
_PREFIX: Final = f"tumtools-digest {VERSION}\n"


@dataclass(frozen=True, slots=True)
class StreamDigest:
    """Digest of one stream.

    Attributes:
        count: Images or rows.
        value: SHA-256 in hexadecimal.

    """

    count: int
    value: str


@dataclass(frozen=True, slots=True)
class Digest:
    """Digest of a sequence.

    Attributes:
        streams: By stream name.
        frames: `(stream, stamp, pixel digest)` of each image in time order, if asked for.

    """

    streams: Mapping[str, StreamDigest]
    frames: tuple[tuple[str, int, str], ...] = field(default=(), repr=False)

    @property
    def value(self) -> str:
        """One value for all streams."""
        lines = [
            f"{name} {self.streams[name].count} {self.streams[name].value}\n" for name in sorted(self.streams)
        ]
        return hashlib.sha256((_PREFIX + "".join(lines)).encode()).hexdigest()


def canonical_pixels(image: Image) -> tuple[str, npt.NDArray[np.generic]]:
    """Return the kind and the pixels that represent an image in the digest.

    Depth is counts of 1/5000 m as uint16 if it is exactly that, whatever unit it came in, and metres as
    little-endian float32 if not; 0 is "no reading". Colour has the order R G B (A).
    """
    pixels = pixels_of(image)
    units = image.depth_units_per_metre
    if units is None:
        ordered, encoding = canonical(pixels, image.encoding)
        return encoding, ordered
    if image.encoding != "32FC1" and units == TUM_DEPTH_UNITS_PER_METRE:
        return "depth-counts", pixels.astype("<u2", copy=False)
    values = pixels if image.encoding == "32FC1" else depth_in_metres(image, pixels)
    counts = exact_counts(values.astype(np.float32, copy=False), TUM_DEPTH_UNITS_PER_METRE)
    if counts is not None:  # NaN and -0 have become 0 on the way
        return "depth-counts", counts
    return "depth-metres", depth_in_metres(image, pixels)


def depth_in_metres(image: Image, pixels: npt.NDArray[np.generic] | None = None) -> npt.NDArray[np.float32]:
    """Return depth as float32 metres, 0 for "no reading"; the pixels are those of the image unless told."""
    pixels = pixels_of(image) if pixels is None else pixels
    if image.encoding == "32FC1":
        return _canonical_metres(np.ascontiguousarray(pixels, "<f4"))
    return divided(pixels.astype(np.uint16, copy=False), image.depth_units_per_metre or 1.0)


def _canonical_metres(metres: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Return metres with 0 for NaN and for -0.0; the bits tell whether there is anything to do."""
    bits = metres.view("<u4")
    largest = bits.max(initial=0)
    if largest <= _INFINITY:
        return metres
    if largest <= _MAGNITUDE:  # nothing has a sign
        return (bits * (bits <= _INFINITY)).view("<f4")
    return (bits * ((bits & _MAGNITUDE) <= _INFINITY)).view("<f4") + np.float32(0)


def pixel_digest(image: Image) -> bytes:
    """Return the SHA-256 of the canonical pixels of an image, 32 bytes."""
    kind, pixels = canonical_pixels(image)
    return digest_of_pixels(kind, pixels)


def digest_of_pixels(kind: str, pixels: npt.NDArray[np.generic]) -> bytes:
    """Return the SHA-256 of canonical pixels."""
    height, width = pixels.shape[:2]
    sha = hashlib.sha256(f"{kind} {width} {height}\n".encode())
    sha.update(np.ascontiguousarray(pixels).view(np.uint8).data)
    return sha.digest()


def _digest_frames(
    sequence: Sequence, jobs: int, progress: Progress | None
) -> Iterator[tuple[str, int, int, bytes]]:
    def work(frame: Frame) -> tuple[str, int, int, bytes]:
        image = frame.load()
        try:
            value = pixel_digest(image)
        except InputError as error:
            location = error.location or f"{frame.stream} image {frame.row}"
            raise InputError(error.message, path=error.path, location=location, hint=error.hint) from error
        if progress is not None:
            progress(1, image.nbytes)
        return frame.stream, frame.stamp, frame.row, value

    return ordered_map(work, sequence.images(), jobs, batch=batch_of(sequence))


def digest(
    sequence: Sequence, *, jobs: int = 2, deep: bool = False, progress: Progress | None = None
) -> Digest:
    """Digest all streams of a sequence, decoding every image once.

    Args:
        sequence: Any.
        jobs: Threads.
        deep: Keep the digests of the images.
        progress: Told of each image.

    Raises:
        InputError: An image is damaged.

    """
    by_row: dict[str, list[tuple[int, int, bytes]]] = {stream: [] for stream in sequence.info.images}
    frames = []
    for stream, stamp, row, pixels in _digest_frames(sequence, jobs, progress):
        by_row[stream].append((row, stamp, pixels))
        if deep:
            frames.append((stream, stamp, pixels.hex()))
    streams = {}
    for stream, rows in by_row.items():
        value = digest_of_images((stamp, one) for _, stamp, one in sorted(rows))
        streams[stream] = StreamDigest(len(rows), value)
    for name, signal in (("accelerometer", sequence.accelerometer), ("groundtruth", sequence.groundtruth)):
        if signal is not None:
            streams[name] = StreamDigest(len(signal), digest_of_rows(signal.stamps, signal.values))
    return Digest(streams, tuple(frames))
