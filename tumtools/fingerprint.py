# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What is remembered of each image while a writer takes it, so that the result can be held against it.

CRC-32 is enough here: it guards against accidents, in bytes that this process has seen itself a moment ago,
and it is thirty times faster than SHA-256.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from isal import isal_zlib

from tumtools.digest import canonical_pixels
from tumtools.formats.options import Needs
from tumtools.images.codec import in_metres, pixels_of
from tumtools.images.depth import is_reversible, nearest_counts
from tumtools.kept_digest import Noted, image_digest, is_hashed_as_file
from tumtools.model.sequence import Frame, Sequence

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping

    import numpy.typing as npt

    from tumtools.model.digest import KeptDigest, Kind
    from tumtools.model.image import Image

Mark = tuple[object, ...]
"""What bytes are, and their CRC-32."""


@dataclass(frozen=True, slots=True)
class Fingerprint:
    """Marks of the forms of an image; of two images, one form that both have must be the same.

    Attributes:
        png: Of the PNG file, if that is what the image came with.
        pixels: Of the pixels as they lie in memory: equal ones need not be brought into the canonical form.
        canonical: Of the canonical pixels.

    """

    png: Mark | None = None
    pixels: Mark | None = None
    canonical: Mark | None = None

    def same(self, other: Fingerprint) -> bool:
        """Tell whether two images are the same, as far as both have a form in common."""
        return (
            (self.png is not None and self.png == other.png)
            or (self.pixels is not None and self.pixels == other.pixels)
            or (self.canonical is not None and self.canonical == other.canonical)
        )


def fingerprint(image: Image) -> Fingerprint:
    """Return the mark of the PNG file where the image is nothing else, or else those of its pixels."""
    if image.pixels is None and image.png is not None:
        return Fingerprint(_mark_of_png(image))
    pixels = pixels_of(image)
    mark = _mark_of_pixels(image, pixels)
    return Fingerprint(None, mark, _mark_of_canonical(image, pixels, mark))


def _of_made(image: Image) -> Fingerprint:
    """Return that of metres made here: they lie in the result as they are, so no other form is needed."""
    return Fingerprint(pixels=_mark_of_pixels(image, pixels_of(image)))


def full_fingerprint(image: Image) -> Fingerprint:
    """Return the marks of all forms, decoding a PNG file."""
    found = fingerprint(replace(image, pixels=pixels_of(image)))
    return found if image.png is None else replace(found, png=_mark_of_png(image))


def is_same(image: Image, expected: Fingerprint) -> bool:
    """Tell whether an image has a fingerprint, computing no more than that needs."""
    if expected.pixels is None:
        return image.png is not None and expected.png == _mark_of_png(image)
    pixels = pixels_of(image)
    mark = None
    if expected.pixels[:-1] == _form(image):
        mark = _mark_of_pixels(image, pixels)
    return mark == expected.pixels or _mark_of_canonical(image, pixels, mark) == expected.canonical


def _mark_of_png(image: Image) -> Mark:
    data = image.png or b""
    return image.depth_units_per_metre, len(data), isal_zlib.crc32(data)


def _form(image: Image) -> Mark:
    return image.encoding, image.depth_units_per_metre, image.width, image.height


def _mark_of_pixels(image: Image, pixels: npt.NDArray[np.generic]) -> Mark:
    return *_form(image), _crc(pixels)


def _mark_of_canonical(image: Image, pixels: npt.NDArray[np.generic], mark: Mark | None) -> Mark:
    kind, ordered = canonical_pixels(image if image.pixels is pixels else replace(image, pixels=pixels))
    # Pixels that are canonical as they are are not looked at again.
    crc = mark[-1] if mark is not None and ordered is pixels else _crc(ordered)
    return kind, image.width, image.height, crc


def _crc(pixels: npt.NDArray[np.generic]) -> int:
    return isal_zlib.crc32(np.ascontiguousarray(pixels).reshape(-1).view(np.uint8).data)


def _in_metres(image: Image) -> Image:
    """Return counts of depth in metres, or the image itself where that cannot be shown to be right.

    It is shown in two steps: each of all counts comes back from its metres, to the bit, and each pixel here
    has the metres of its own count.
    """
    units = image.depth_units_per_metre
    if units is None or image.encoding == "32FC1" or not is_reversible(units):
        return image
    result = in_metres(image)
    back = nearest_counts(pixels_of(result).astype(np.float32, copy=False), units)
    return result if np.array_equal(back, pixels_of(image)) else image


class Recorded(Sequence):
    """A sequence that notes what passes through it on the way to a writer.

    What the writer would decode or bring into metres is so already when it gets it.

    Args:
        sequence: What is written.
        needs: What the writer needs pixels of; these are decoded here, once, and counts made metres.
        keep_digest: Note SHA-256 as well, for the writer to keep.
        keep_fingerprints: Note fingerprints; without, the result cannot be verified.

    Attributes:
        fingerprints: By stream and row, of the images that have been loaded.

    """

    def __init__(
        self,
        sequence: Sequence,
        needs: Needs | None = None,
        *,
        keep_digest: bool = False,
        keep_fingerprints: bool = True,
    ) -> None:
        self._inner = sequence
        self._needs = needs or Needs()
        self.fingerprints: dict[tuple[str, int], Fingerprint] = {}
        self._noted = Noted() if keep_digest else None
        self._keep_fingerprints = keep_fingerprints
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
            load = partial(self._load, frame)
            yield Frame(frame.stream, frame.stamp, frame.row, load, frame.frame_id)

    def _load(self, frame: Frame) -> Image:
        image = frame.load()
        if frame.stream in self._needs.pixel_streams and image.pixels is None:
            image = replace(image, pixels=pixels_of(image))
        if self._noted is not None:
            of: Kind = "files" if image.pixels is None and is_hashed_as_file(image) else "pixels"
            self._noted.add(frame, of, image_digest(image, of))
        given = image
        image = _in_metres(given) if self._needs.metres else given
        if self._keep_fingerprints:
            # A dict is safe to fill from several threads.
            seen = fingerprint(image) if image is given else _of_made(image)
            self.fingerprints[frame.stream, frame.row] = seen
        return image

    def noted_digest(self) -> Mapping[str, KeptDigest] | None:
        """Return the digest of what has been loaded, if it is noted."""
        return None if self._noted is None else self._noted.digest(self)
