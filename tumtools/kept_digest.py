# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The digest that a file keeps of its own content: noted while it is written, compared whenever asked.

Where PNG files are passed through, the files are hashed and nothing is decoded for it; else the canonical
pixels. Defined in docs/reference/digest.md, "Kept in files".
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from tumtools.digest import digest_of_rows, pixel_digest
from tumtools.errors import InputError
from tumtools.images.parallel import ordered_map
from tumtools.model.digest import KeptDigest, Kind

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from tumtools.formats.options import Progress
    from tumtools.model.image import Image
    from tumtools.model.sequence import Frame, Sequence
    from tumtools.model.signals import Accelerometer, Trajectory


_PIXELS: Final[set[Kind]] = {"pixels"}
"""How the images of an empty stream are said to be hashed."""


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
                found[stream] = KeptDigest(len(rows), next(iter(kinds)), _joined(noted))
        for name, signal in _signals(sequence):
            found[name] = KeptDigest(len(signal), "rows", digest_of_rows(signal.stamps, signal.values))
        return found


def _joined(images: list[tuple[Kind, int, bytes]]) -> str:
    sha = hashlib.sha256()
    for _, stamp, value in images:
        sha.update(stamp.to_bytes(8, "little", signed=True) + value)
    return sha.hexdigest()


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


def check(sequence: Sequence, *, jobs: int = 2, progress: Progress | None = None) -> list[Check]:
    """Compare a sequence with the digest that its file keeps, stream by stream.

    Args:
        sequence: Opened from a file that keeps one.
        jobs: Threads.
        progress: Told of each image.

    Raises:
        InputError: It keeps none, or an image is damaged.

    """
    kept = sequence.info.digest
    if kept is None:
        raise InputError(
            "it carries no digest of its own",
            path=sequence.info.name,
            hint="convert with --digest, to mcap, rosbag1 or rosbag2, makes a file that does",
        )
    noted = Noted()

    def work(frame: Frame) -> int:
        image = frame.load()
        of = _kind(kept, frame, image)
        noted.add(frame, of, image_digest(image, of))
        return image.nbytes

    for nbytes in ordered_map(work, sequence.images(), jobs):
        if progress is not None:
            progress(1, nbytes)
    found: Mapping[str, KeptDigest] = noted.digest(sequence)
    return [Check(name, kept.get(name), found.get(name)) for name in sorted(kept.keys() | found.keys())]


def _kind(kept: Mapping[str, KeptDigest], frame: Frame, image: Image) -> Kind:
    """Return in which way an image is hashed: that of its file, unless it is no PNG file any more."""
    wanted = kept.get(frame.stream)
    return "files" if wanted is not None and wanted.of == "files" and image.png is not None else "pixels"
