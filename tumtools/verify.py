# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Read back what was written and hold it against what the writer was given.

While the writer takes its frames, a fingerprint of each goes into a table: of its PNG file where that is
passed on, of its pixels where the writer needs them decoded anyway. The result is read with the reader of
its format; a frame that is the same PNG file is the same image, and nothing more is decoded.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from isal import isal_zlib

from tumtools.digest import canonical_pixels
from tumtools.errors import InternalError
from tumtools.formats.tum.text import render
from tumtools.images.codec import pixels_of
from tumtools.images.parallel import ordered_map
from tumtools.kept_digest import Noted, image_digest
from tumtools.model.sequence import IMAGE_STREAMS, Frame, Sequence
from tumtools.model.time import format_stamp

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping

    import numpy.typing as npt

    from tumtools.formats.options import Progress
    from tumtools.model.digest import KeptDigest, Kind
    from tumtools.model.image import Image


@dataclass(frozen=True, slots=True)
class _Fingerprint:
    """What is remembered of an image.

    CRC-32 is enough here: it guards against accidents, in bytes that this process has seen itself a moment
    ago, and it is twenty times faster than SHA-256.

    Attributes:
        png: Length and CRC-32 of the PNG file.
        pixels: Size, kind and CRC-32 of the canonical pixels.

    """

    png: tuple[int, int] | None
    pixels: tuple[str, int] | None


def _fingerprint_of_png(data: bytes | memoryview) -> tuple[int, int]:
    return len(data), isal_zlib.crc32(data)


def _fingerprint_of_pixels(image: Image) -> tuple[str, int]:
    kind, pixels = canonical_pixels(image)
    crc = isal_zlib.crc32(np.ascontiguousarray(pixels).view(np.uint8).data)
    return f"{kind} {image.width}x{image.height}", crc


class Recorded(Sequence):
    """A sequence that notes what passes through it on the way to a writer.

    Args:
        sequence: What is written.
        pixel_streams: Streams whose pixels the writer needs; they are decoded here, once.
        keep_digest: Note SHA-256 as well, for the writer to keep.

    """

    def __init__(
        self, sequence: Sequence, pixel_streams: Collection[str] = (), *, keep_digest: bool = False
    ) -> None:
        self._inner = sequence
        self._pixel_streams = frozenset(pixel_streams)
        self.fingerprints: dict[tuple[str, int], _Fingerprint] = {}
        self._noted = Noted() if keep_digest else None
        self.info = sequence.info
        self.groundtruth = sequence.groundtruth
        self.accelerometer = sequence.accelerometer
        self.cameras = sequence.cameras

    def image_stamps(self, stream: str) -> npt.NDArray[np.int64]:
        """Return the stamps of the inner sequence."""
        return self._inner.image_stamps(stream)

    def images(
        self, streams: Collection[str] | None = None, start: int | None = None, end: int | None = None
    ) -> Iterator[Frame]:
        """Yield the frames; each is noted when it is loaded."""
        for frame in self._inner.images(streams, start, end):
            yield replace(frame, load=partial(self._load, frame))

    def _load(self, frame: Frame) -> Image:
        image = frame.load()
        if frame.stream in self._pixel_streams and image.pixels is None:
            image = replace(image, pixels=pixels_of(image))
        png = None if image.png is None else _fingerprint_of_png(image.png)
        pixels = None if image.pixels is None and png is not None else _fingerprint_of_pixels(image)
        # A dict is safe to fill from several threads.
        self.fingerprints[frame.stream, frame.row] = _Fingerprint(png, pixels)
        if self._noted is not None:
            of: Kind = "files" if image.png is not None and image.pixels is None else "pixels"
            self._noted.add(frame, of, image_digest(image, of))
        return image

    def noted_digest(self) -> Mapping[str, KeptDigest] | None:
        """Return the digest of what has been loaded, if it is noted."""
        return None if self._noted is None else self._noted.digest(self)


def verify(
    written: Recorded, result: Sequence, *, skip: Collection[str] = (), jobs: int = 2, progress: Progress
) -> None:
    """Check that a result holds everything that was written.

    Args:
        written: What the writer was given, after it has run.
        result: What the reader of the target's format makes of the target.
        skip: Streams for which the writer has reported a loss.
        jobs: Threads.
        progress: Told of each image.

    Raises:
        InternalError: It does not: a bug of the writer or the reader.
        InputError: The result is not readable.

    """
    for stream in IMAGE_STREAMS:
        if stream not in skip:
            expected, found = written.image_stamps(stream), result.image_stamps(stream)
            _check_equal(stream, "stamps", expected, found)
    _verify_signals(written, result, skip)
    _verify_texts(written, result, skip)

    def check(frame: Frame) -> int:
        image = frame.load()
        _verify_frame(frame, image, written.fingerprints.get((frame.stream, frame.row)))
        return image.nbytes

    streams = [stream for stream in written.info.images if stream not in skip]
    for nbytes in ordered_map(check, result.images(streams), jobs):
        progress(1, nbytes)


def _verify_frame(frame: Frame, image: Image, expected: _Fingerprint | None) -> None:
    if expected is not None:
        png = image.png
        if png is not None and expected.png is not None and _fingerprint_of_png(png) == expected.png:
            return
        if expected.pixels is not None and _fingerprint_of_pixels(image) == expected.pixels:
            return
    raise _bug(f"the {frame.stream} image at {format_stamp(frame.stamp, 9)} differs from what was written")


def _verify_signals(written: Sequence, result: Sequence, skip: Collection[str]) -> None:
    for name in ("accelerometer", "groundtruth"):
        if name in skip:
            continue
        expected, found = getattr(written, name), getattr(result, name)
        if (expected is None) != (found is None):
            raise _bug(f"{name} is {'missing' if found is None else 'there without being written'}")
        if expected is not None:
            _check_equal(name, "stamps", expected.stamps, found.stamps)
            _check_equal(name, "values", expected.values, found.values)


def _check_equal(
    stream: str, what: str, expected: npt.NDArray[np.generic], found: npt.NDArray[np.generic]
) -> None:
    if len(expected) != len(found):
        raise _bug(f"{stream} has {len(found)} rows, {len(expected)} were written")
    if not np.array_equal(expected, found, equal_nan=expected.dtype.kind == "f"):
        rows = np.flatnonzero((expected != found).reshape(len(expected), -1).any(axis=1))
        raise _bug(f"{what} of {stream} differ in {len(rows)} rows, first in row {rows[0]}")


def _verify_texts(written: Sequence, result: Sequence, skip: Collection[str]) -> None:
    for stream, layout in written.info.text.items():
        if stream in skip:
            continue
        after = result.info.text.get(stream)
        if after == layout:
            continue  # the rows are the same already
        stamps, values = _columns(written, stream)
        if after is None or render(layout, stream, stamps, values) != render(after, stream, stamps, values):
            raise _bug(f"the text of {stream} would not come back as it was")


def _columns(sequence: Sequence, stream: str) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float64]]:
    if stream in IMAGE_STREAMS:
        stamps = sequence.image_stamps(stream)
        return stamps, np.empty((len(stamps), 0))
    signal = sequence.groundtruth if stream == "groundtruth" else sequence.accelerometer
    return (np.empty(0, np.int64), np.empty((0, 0))) if signal is None else (signal.stamps, signal.values)


def _bug(message: str) -> InternalError:
    return InternalError(
        f"verification failed: {message}", hint="nothing was left under the target's name; please report this"
    )
