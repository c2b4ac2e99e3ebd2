# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What each way of writing a sequence is expected to lose, computed from the sequence without our writers.

An empty answer means: everything is the same, to the last nanosecond, bit and character.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.images.codec import pixels_of
from tumtools.model.sequence import STREAMS

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy.typing as npt

    from tests.roundtrip.variants import Variant
    from tumtools.model.sequence import Loss, Sequence

HEADER_KINDS: Final = ("calibration", "camera", "frame id", "name", "licence")
"""Losses that leave the data and the text of their stream as they are."""


@dataclass(frozen=True)
class Expected:
    """What is expected of a conversion.

    Attributes:
        losses: (stream, what, count, largest error rounded to a nanosecond or nanometre).
        asked: (stream, what) of differences that the options ask for, which are no losses.

    """

    losses: Counter[tuple[str, str, int, float | None]] = field(default_factory=Counter)
    asked: frozenset[tuple[str, str]] = frozenset()

    @property
    def changed(self) -> frozenset[str]:
        """Streams whose data is not the same afterwards."""
        lost = {stream for stream, what, *_ in self.losses if not what.startswith((*HEADER_KINDS, "text"))}
        return frozenset(lost | {stream for stream, what in self.asked if what == "stream"})


def key_of(loss: Loss) -> tuple[str, str, int, float | None]:
    """Return what is compared of a loss."""
    error = None if loss.largest_error is None else round(loss.largest_error, 9)
    return loss.stream, loss.what, loss.count, error


def expected(variant: Variant, sequence: Sequence) -> Expected:
    """Return what writing a sequence is expected to lose."""
    losses: Counter[tuple[str, str, int, float | None]] = Counter()
    losses.update(_depth(variant, sequence))
    if variant.format == "tum" or variant.option("dialect") == "converter":
        losses.update(
            (stream, f"frame id {name}", 1, None) for stream, name in sequence.info.frame_ids.items()
        )
        told = variant.format == "tum" and _is_told(sequence, "rgbd_dataset_freiburg")
        if sequence.info.licence is not None and not told:
            losses["sequence", "licence and citation", 1, None] += 1
    if variant.format == "tum":
        losses.update((stream, "calibration", 1, None) for stream in sequence.cameras)
        camera = sequence.info.camera
        if camera is not None and not _is_told(sequence, f"freiburg{camera[-1]}_"):
            losses[next(iter(sequence.info.images), "sequence"), f"camera {camera}", 1, None] += 1
    if variant.option("dialect") == "converter":
        losses.update(_converter(sequence))
    return Expected(losses, frozenset(_asked(variant, sequence)))


def _is_told(sequence: Sequence, part: str) -> bool:
    """Tell whether the header lines of the text files name the sequence so; names of the targets do not."""
    signals = {"groundtruth": sequence.groundtruth, "accelerometer": sequence.accelerometer}
    streams = [*sequence.info.images, *(name for name, signal in signals.items() if signal is not None)]
    known = [sequence.info.text[stream].head for stream in streams if stream in sequence.info.text]
    named = [head for head in known if "# file: '" in head]
    if len(known) < len(streams):
        named.append(sequence.info.name)  # the header that is made for a file that has none yet
    return any(part in head for head in named)


def _asked(variant: Variant, sequence: Sequence) -> Iterator[tuple[str, str]]:
    if variant.option("groundtruth") == "none" and sequence.groundtruth is not None:
        yield "groundtruth", "stream"
    for stream in sequence.info.images if variant.format == "tum" else ():
        stamps = sequence.image_stamps(stream)
        if stream not in sequence.info.text and _differ_at_one_stamp(sequence, stream, stamps):
            yield stream, "text"  # the names of their files are made up so that they differ
    if variant.option("camera") is not None and variant.option("camera") != sequence.info.camera:
        yield next(iter(sequence.info.images), "sequence"), "camera"
    for stream, name in variant.write_options.frame_ids.items():
        if sequence.info.frame_ids.get(stream) != name:
            yield stream, "frame id"


def _differ_at_one_stamp(sequence: Sequence, stream: str, stamps: npt.NDArray[np.int64]) -> bool:
    if len(np.unique(stamps)) == len(stamps):
        return False
    seen: dict[int, set[bytes]] = {}
    for frame in sequence.images([stream]):
        seen.setdefault(frame.stamp, set()).add(pixels_of(frame.load()).tobytes())
    return any(len(images) > 1 for images in seen.values())


def _units(variant: Variant) -> float | None:
    """Return the unit of depth that a variant holds; None for one that holds any."""
    if variant.format == "rawlog":
        return 1000.0 if variant.option("dialect") == "converter" else None
    if variant.format == "tum" or variant.option("archive"):
        return 5000.0
    return {"png": 5000.0, "16UC1": 1000.0}.get(str(variant.option("depth_encoding")))


def _depth(variant: Variant, sequence: Sequence) -> Iterator[tuple[str, str, int, float | None]]:
    """Round every pixel to the unit of the target, in decimal arithmetic of integers and float64."""
    units = _units(variant)
    if units is None or "depth" not in sequence.info.images:
        return
    rounded, clipped, largest = 0, 0, 0.0
    stored = {b for _, b in _scans(sequence)} if variant.option("dialect") == "converter" else None
    for frame in sequence.images(["depth"]):
        if stored is not None and frame.stamp not in stored:
            continue
        image = frame.load()
        if image.depth_units_per_metre == units and image.encoding == "16UC1":
            continue
        metres = _metres(pixels_of(image), image.depth_units_per_metre or 1.0)
        metres = np.where(np.isnan(metres), 0.0, metres)
        counts = np.rint(metres * units)
        outside = (counts > 65535) | (metres < 0)
        clipped += int(outside.sum())
        found = counts / units
        if image.encoding == "32FC1":
            found = found.astype(np.float32).astype(np.float64)  # what float32 cannot tell apart is the same
        error = np.where(outside, 0.0, np.abs(found - metres))
        rounded += int((error > 0).sum())
        largest = max(largest, float(error.max(initial=0.0)))
    if rounded:
        yield "depth", "pixels rounded", rounded, round(largest, 9)
    if clipped:
        yield "depth", "pixels out of range, now without a reading", clipped, None


def _metres(pixels: npt.NDArray[np.generic], units: float) -> npt.NDArray[np.float64]:
    values: npt.NDArray[np.float64] = pixels.astype(np.float64) / units
    return values


def _scans(sequence: Sequence) -> list[tuple[int, int]]:
    """Return the stamps of each colour image that MRPT's converter keeps, and of its depth image."""
    rgb, depth = sequence.image_stamps("rgb"), sequence.image_stamps("depth")
    pairs = [(int(time), int(depth[np.argmin(np.abs(depth - time))])) for time in np.sort(rgb)]
    return [(a, b) for a, b in pairs if abs(a - b) * 60 <= 10**9]


def _converter(sequence: Sequence) -> Iterator[tuple[str, str, int, float | None]]:
    """Pair as MRPT's converter does, by brute force over all stamps."""
    rgb, depth = sequence.image_stamps("rgb"), sequence.image_stamps("depth")
    rows = np.empty(0, np.int64) if sequence.accelerometer is None else sequence.accelerometer.stamps
    scans = _scans(sequence)
    means = [round((a + b) / 2 / 1000) * 1000 for a, b in scans]
    samples = [int(rows[np.argmin(np.abs(rows - mean))]) for mean in means] if len(rows) else []
    near = [abs(a - sample) < 10**7 for (a, _), sample in zip(scans, samples, strict=False)]
    moved = {
        "rgb": [abs(mean - a) for mean, (a, _) in zip(means, scans, strict=True)],
        "depth": [abs(mean - b) for mean, (_, b) in zip(means, scans, strict=True)],
        "accelerometer": [
            abs(mean - sample) for mean, sample, taken in zip(means, samples, near, strict=False) if taken
        ],
    }
    samples = [sample for sample, taken in zip(samples, near, strict=True) if taken]
    for stream, count in (("rgb", len(rgb) - len(scans)), ("depth", len(depth) - len({b for _, b in scans}))):
        if count:
            yield stream, "images dropped", count, None
    if len(scans) != len({b for _, b in scans}):
        yield "depth", "images stored again", len(scans) - len({b for _, b in scans}), None
    if len(rows) != len(set(samples)):
        yield "accelerometer", "rows dropped", len(rows) - len(set(samples)), None
    if len(samples) != len(set(samples)):
        yield "accelerometer", "rows stored again", len(samples) - len(set(samples)), None
    for stream, changes in moved.items():
        if any(changes):
            yield stream, "stamps replaced", sum(map(bool, changes)), round(max(changes) / 1e9, 9)
    yield from _converter_headers(sequence)


def _converter_headers(sequence: Sequence) -> Iterator[tuple[str, str, int, float | None]]:
    for stream in STREAMS:
        if stream in sequence.info.text and stream != "groundtruth":
            yield stream, "text layout dropped", 1, None
    for stream in sequence.info.images:
        if stream in sequence.cameras or sequence.info.camera is not None:
            yield stream, "calibration replaced", 1, None
    # The targets here are called "sequence", which tells nothing.
    if sequence.info.name != "sequence":
        yield "sequence", f"name {sequence.info.name}", 1, None
    if sequence.info.camera is not None:
        yield next(iter(sequence.info.images), "sequence"), f"camera {sequence.info.camera}", 1, None
