# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The digest that a file keeps of its own content: noted while it is written, compared whenever asked.

Where PNG files are passed through, the files are hashed and nothing is decoded for it; else the canonical
pixels. Defined in docs/reference/digest.md, "Kept in files".
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Final

from tumtools.digest import pixel_digest
from tumtools.errors import InputError
from tumtools.images.codec import pixels_of
from tumtools.images.parallel import batch_of, ordered_map
from tumtools.model.digest import KeptDigest, Kind, digest_of_images, digest_of_rows
from tumtools.model.sequence import TUM_DEPTH_UNITS_PER_METRE

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from tumtools.formats.options import Progress
    from tumtools.model.image import Image
    from tumtools.model.sequence import Frame, Sequence
    from tumtools.model.signals import Accelerometer, Trajectory


_PIXELS: Final[set[Kind]] = {"pixels"}
"""How the images of an empty stream are said to be hashed."""


def is_hashed_as_file(image: Image) -> bool:
    """Tell whether the PNG file of an image says all of it: depth in other units is hashed by its pixels."""
    return image.png is not None and image.depth_units_per_metre in {None, TUM_DEPTH_UNITS_PER_METRE}


def image_digest(image: Image, of: Kind) -> bytes:
    """Return the SHA-256 of an image: of its PNG file or of its canonical pixels, 32 bytes."""
    if of == "files" and image.png is not None:
        return hashlib.sha256(image.png).digest()
    return pixel_digest(image)


class Noted:
    """Digests of images, added by any thread in any order."""

    def __init__(self) -> None:
        self._images: dict[tuple[str, int], tuple[Kind, int, bytes]] = {}

    def add(self, frame: Frame, of: Kind, value: bytes) -> None:
        """Note an image."""
        # A dict is safe to fill from several threads.
        self._images[frame.stream, frame.row] = of, frame.stamp, value

    def digest(self, sequence: Sequence) -> dict[str, KeptDigest]:
        """Return the digest of each stream of which every image was noted, all in the same way."""
        found = {}
        for stream in sequence.info.images:
            rows = range(len(sequence.image_stamps(stream)))
            noted = [self._images[stream, row] for row in rows if (stream, row) in self._images]
            kinds = {of for of, _, _ in noted} or _PIXELS
            if len(noted) == len(rows) and len(kinds) == 1:
                found[stream] = KeptDigest(
                    len(rows),
                    next(iter(kinds)),
                    digest_of_images((stamp, value) for _, stamp, value in noted),
                )
        for name, signal in _signals(sequence):
            found[name] = KeptDigest(len(signal), "rows", digest_of_rows(signal.stamps, signal.values))
        return found


def _signals(sequence: Sequence) -> Iterator[tuple[str, Accelerometer | Trajectory]]:
    if sequence.accelerometer is not None:
        yield "accelerometer", sequence.accelerometer
    if sequence.groundtruth is not None:
        yield "groundtruth", sequence.groundtruth


@dataclass(frozen=True, slots=True)
class Check:
    """A stream held against the digest that its file keeps.

    Attributes:
        stream: Its name.
        kept: What the file says; None for a stream that it does not mention.
        found: What is there; None for a stream that is not there.

    """

    stream: str
    kept: KeptDigest | None
    found: KeptDigest | None

    @property
    def same(self) -> bool:
        """Whether the stream is what was written."""
        return self.kept == self.found


class Watch:
    """Compares a sequence with the digest that its file keeps, while somebody else looks at its images.

    Args:
        sequence: Opened from a file that keeps one.
        kept: That digest.

    """

    def __init__(self, sequence: Sequence, kept: Mapping[str, KeptDigest]) -> None:
        self._sequence = sequence
        self._kept = kept
        self._noted = Noted()

    def frame(self, frame: Frame) -> Frame:
        """Return a frame whose image is noted when it is loaded; decoded already, if that took decoding."""
        return replace(frame, load=partial(self._load, frame))

    def _load(self, frame: Frame) -> Image:
        image = frame.load()
        wanted = self._kept.get(frame.stream)
        # A file that is none any more, or has another unit, cannot be what was written, whatever its pixels.
        as_file = wanted is not None and wanted.of == "files" and is_hashed_as_file(image)
        of: Kind = "files" if as_file else "pixels"
        if of == "pixels" and image.pixels is None:
            image = replace(image, pixels=pixels_of(image))
        self._noted.add(frame, of, image_digest(image, of))
        return image

    def checks(self) -> list[Check]:
        """Return the result for each stream, when all images have been loaded."""
        found = self._noted.digest(self._sequence)
        streams = sorted(self._kept.keys() | found.keys())
        return [Check(name, self._kept.get(name), found.get(name)) for name in streams]


def check(sequence: Sequence, *, jobs: int = 2, progress: Progress | None = None) -> list[Check]:
    """Compare a sequence with the digest that its file keeps, stream by stream.

    Args:
        sequence: Opened from a file that keeps one.
        jobs: Threads.
        progress: Told of each image.

    Raises:
        InputError: It keeps none, or an image is damaged.

    """
    if sequence.info.digest is None:
        raise InputError(
            "it carries no digest of its own",
            path=sequence.info.name,
            hint="what tumtools converts to mcap, rosbag1, rosbag2 or rawlog carries one, unless --no-digest",
        )
    watch = Watch(sequence, sequence.info.digest)

    def load(frame: Frame) -> int:
        return watch.frame(frame).load().nbytes

    for nbytes in ordered_map(load, sequence.images(), jobs, batch=batch_of(sequence)):
        if progress is not None:
            progress(1, nbytes)
    return watch.checks()
