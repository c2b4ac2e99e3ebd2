# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Compare the contents of two sequences of any formats: stamps, values, pixels, text, calibration."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from itertools import chain
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.digest import canonical_pixels, depth_in_metres
from tumtools.formats.cameras import chosen_calibration
from tumtools.formats.options import WriteOptions
from tumtools.formats.tum.text import fit_layout, render
from tumtools.images.parallel import batch_of, ordered_map
from tumtools.model.sequence import IMAGE_STREAMS, STREAMS, WHOLE_SEQUENCE
from tumtools.model.text import default_layout
from tumtools.model.time import format_stamp

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy.typing as npt

    from tumtools.formats.options import Progress
    from tumtools.model.image import Image
    from tumtools.model.sequence import Frame, Sequence

_LONGEST: Final = 2**64 - 1
_FLOAT32_ROUNDING: Final = 1e-6
"""Metres; half a unit in the last place of float32 at 13 m, the benchmark's largest depth, for each side."""

SIGNAL_UNITS: Final = {"accelerometer": ("m/s2",), "groundtruth": ("m", "1")}
"""Unit of the values of a signal: of positions and of quaternion components."""


@dataclass(frozen=True, slots=True)
class Tolerances:
    """How far apart values may be and still count as equal.

    Attributes:
        stamp: Nanoseconds.
        value: Metres, quaternion components, m/s2.
        depth: Metres.
        colour: Levels.

    """

    stamp: int = 0
    value: float = 0.0
    depth: float = 0.0
    colour: int = 0


@dataclass(frozen=True, slots=True)
class Difference:
    """One way in which two sequences differ.

    Attributes:
        stream: Which stream; `sequence` for what concerns all of it.
        what: `stream`, `count`, `stamps`, `values`, `size`, `encoding`, `pixels`, `text`, `calibration`,
            `camera`, `frame id`, `licence` or `citation`.
        count: How many rows, images, or (for pixels) images with differing pixels.
        first: Where the first difference is.
        largest: Largest difference, in `unit`; None where nothing is measured.
        unit: Its unit.

    """

    stream: str
    what: str
    count: int
    first: str
    largest: float | None = None
    unit: str = ""


@dataclass(frozen=True, slots=True)
class Comparison:
    """What was compared and what differs.

    Attributes:
        differences: Empty if the contents are the same.
        images: Pairs of images compared.
        pixels: Pixels compared, whether decoded or known to be equal from equal files.
        rows: Rows of signals compared.

    """

    differences: tuple[Difference, ...]
    images: int
    pixels: int
    rows: int

    @property
    def same(self) -> bool:
        """Whether nothing differs."""
        return not self.differences


def diff(
    a: Sequence,
    b: Sequence,
    tolerances: Tolerances | None = None,
    *,
    jobs: int = 2,
    progress: Progress | None = None,
) -> Comparison:
    """Compare two sequences.

    Rows and images are compared in file order; where the numbers differ, as far as both go.

    Args:
        a: One.
        b: The other.
        tolerances: What still counts as equal; nothing unless told.
        jobs: Threads.
        progress: Told of each pair of images.

    Raises:
        InputError: One of them is damaged.

    """
    limits = tolerances or Tolerances()
    found: list[Difference] = []
    streams: list[str] = []
    for stream in STREAMS:
        has = [_has(sequence, stream) for sequence in (a, b)]
        if has[0] != has[1]:
            found.append(
                Difference(stream, "stream", 1, f"only in {'the first' if has[0] else 'the second'}")
            )
        elif has[0]:
            streams.append(stream)
    rows = 0
    for stream in streams:
        (stamps_a, values_a), (stamps_b, values_b) = _columns(a, stream), _columns(b, stream)
        found += _diff_rows(stream, stamps_a, stamps_b, limits)
        if stream not in IMAGE_STREAMS:
            rows += min(len(stamps_a), len(stamps_b))
            found += _diff_values(stream, stamps_a, values_a, values_b, limits)
        found += _diff_text(a, b, stream)
    images, pixels, image_differences = _diff_images(
        a, b, [stream for stream in streams if stream in IMAGE_STREAMS], limits, jobs, progress
    )
    found += image_differences
    found += _diff_headers(a, b)
    order = [WHOLE_SEQUENCE, *STREAMS]
    return Comparison(tuple(sorted(found, key=lambda one: order.index(one.stream))), images, pixels, rows)


def _has(sequence: Sequence, stream: str) -> bool:
    if stream in IMAGE_STREAMS:
        return stream in sequence.info.images
    return (sequence.groundtruth if stream == "groundtruth" else sequence.accelerometer) is not None


def _columns(sequence: Sequence, stream: str) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float64]]:
    signal = {"groundtruth": sequence.groundtruth, "accelerometer": sequence.accelerometer}.get(stream)
    if signal is None:
        stamps = sequence.image_stamps(stream)
        return stamps, np.empty((len(stamps), 0))
    return signal.stamps, signal.values


def _diff_rows(
    stream: str, a: npt.NDArray[np.int64], b: npt.NDArray[np.int64], limits: Tolerances
) -> Iterator[Difference]:
    if len(a) != len(b):
        yield Difference(stream, "count", abs(len(a) - len(b)), f"{len(a)} and {len(b)} rows")
    common = min(len(a), len(b))
    a, b = a[:common], b[:common]
    # Unsigned, as stamps may be three centuries apart.
    error = np.where(a > b, a - b, b - a).view(np.uint64)
    rows = np.flatnonzero(error > np.uint64(min(limits.stamp, _LONGEST)))
    if len(rows):
        first = int(rows[0])
        place = f"row {first}: {format_stamp(int(a[first]), 9)} and {format_stamp(int(b[first]), 9)}"
        yield Difference(stream, "stamps", len(rows), place, int(error.max()) / 1e9, "s")


def _diff_values(
    stream: str,
    stamps: npt.NDArray[np.int64],
    a: npt.NDArray[np.float64],
    b: npt.NDArray[np.float64],
    limits: Tolerances,
) -> Iterator[Difference]:
    common = min(len(a), len(b))
    a, b = a[:common], b[:common]
    for number, unit in enumerate(SIGNAL_UNITS[stream]):
        columns = slice(3 * number, 3 if number == 0 else None)
        with np.errstate(invalid="ignore"):
            error = np.abs(a[:, columns] - b[:, columns])
        one_is_nan = np.isnan(a[:, columns]) != np.isnan(b[:, columns])
        # inf - inf is NaN although both are the same.
        error = np.where(one_is_nan, np.inf, np.where(np.isnan(error), 0.0, error))
        differing = error > limits.value
        if not limits.value:
            differing |= (np.signbit(a[:, columns]) != np.signbit(b[:, columns])) & ~np.isnan(a[:, columns])
        rows = np.flatnonzero(differing.any(axis=1))
        if len(rows):
            place = f"row {rows[0]} at {format_stamp(int(stamps[rows[0]]), 9)}"
            yield Difference(stream, "values", len(rows), place, float(error.max()), unit)


def _diff_text(a: Sequence, b: Sequence, stream: str) -> Iterator[Difference]:
    """Compare what the text files of a stream are, or would be.

    A header that neither has yet is made of the same name for both: how a file is called is not its content.
    """
    bare = not any(stream in sequence.info.text for sequence in (a, b))
    texts = []
    for sequence in (a, b):
        stamps, values = _columns(sequence, stream)
        layout = sequence.info.text.get(stream)
        if layout is None:
            name = a.info.name if bare else sequence.info.name
            layout = fit_layout(default_layout(stream, name), stamps, values)
        texts.append(render(layout, stream, stamps, values).split(b"\n"))
    differing = [number for number, lines in enumerate(zip(*texts, strict=False), 1) if lines[0] != lines[1]]
    extra = abs(len(texts[0]) - len(texts[1]))
    if differing or extra:
        line = differing[0] if differing else min(map(len, texts)) + 1
        yield Difference(stream, "text", len(differing) + extra, f"line {line}")


def _diff_images(
    a: Sequence, b: Sequence, streams: list[str], limits: Tolerances, jobs: int, progress: Progress | None
) -> tuple[int, int, list[Difference]]:
    """Compare the images of each stream pair by pair."""

    def work(pair: tuple[Frame, Frame]) -> tuple[Frame, _Pair]:
        images = pair[0].load(), pair[1].load()
        if progress is not None:
            progress(1, images[0].nbytes + images[1].nbytes)
        return pair[0], _diff_pair(images[0], images[1], limits)

    pairs = chain.from_iterable(zip(a.images([one]), b.images([one]), strict=False) for one in streams)
    gathered: dict[tuple[str, str], list[tuple[str, _Pair]]] = {}
    images = pixels = 0
    for frame, result in ordered_map(work, pairs, jobs, batch=batch_of(a)):
        images += 1
        pixels += result.pixels
        if result.what:
            place = f"row {frame.row} at {format_stamp(frame.stamp, 9)}{result.detail}"
            gathered.setdefault((frame.stream, result.what), []).append((place, result))
    differences = []
    for (stream, what), hits in gathered.items():
        largest = max((hit.largest for _, hit in hits if hit.largest is not None), default=None)
        differences.append(Difference(stream, what, len(hits), hits[0][0], largest, hits[0][1].unit))
    return images, pixels, differences


@dataclass(frozen=True, slots=True)
class _Pair:
    """Result for two images; `what` is empty if they are the same."""

    what: str
    pixels: int
    detail: str = ""
    largest: float | None = None
    unit: str = ""


def _diff_pair(a: Image, b: Image, limits: Tolerances) -> _Pair:
    pixels = a.width * a.height
    if a.png is not None and a.png == b.png and a.depth_units_per_metre == b.depth_units_per_metre:
        return _Pair("", pixels)
    if (a.width, a.height) != (b.width, b.height):
        return _Pair("size", 0, f": {a.width}x{a.height} and {b.width}x{b.height}")
    (kind_a, first), (kind_b, second) = canonical_pixels(a), canonical_pixels(b)
    if kind_a == kind_b and np.array_equal(first, second):
        return _Pair("", pixels)
    # Depth is float32 metres: what is as large as the limit but for rounding is within it.
    limit, unit = limits.depth + (_FLOAT32_ROUNDING if limits.depth else 0.0), "m"
    if a.depth_units_per_metre is not None and b.depth_units_per_metre is not None:
        first, second = depth_in_metres(a), depth_in_metres(b)
    elif kind_a != kind_b:
        return _Pair("encoding", 0, f": {a.encoding} and {b.encoding}")
    else:
        limit, unit = limits.colour, "levels"
    with np.errstate(invalid="ignore"):
        error = np.abs(first.astype(np.float64) - second.astype(np.float64))
    error[np.isnan(error)] = 0.0  # two infinities
    count = int(np.count_nonzero((error > limit).reshape(pixels, -1).any(axis=1)))
    if not count:
        return _Pair("", pixels)
    return _Pair("pixels", pixels, f" ({count} pixels)", float(error.max()), unit)


def _diff_headers(a: Sequence, b: Sequence) -> Iterator[Difference]:
    """Compare what is beside the data; how a sequence is called is not its content."""
    for stream in IMAGE_STREAMS:
        if stream in a.info.images and stream in b.info.images:
            yield from _diff_calibration(a, b, stream)
    if a.info.camera != b.info.camera:
        stream = next(iter(a.info.images), WHOLE_SEQUENCE)
        yield _header_difference(stream, "camera", a.info.camera, b.info.camera)
    for stream in STREAMS:
        names = a.info.frame_ids.get(stream), b.info.frame_ids.get(stream)
        if names[0] != names[1] and _has(a, stream) and _has(b, stream):
            yield _header_difference(stream, "frame id", *names)
    for what, one, other in (
        ("licence", a.info.licence, b.info.licence),
        ("citation", a.info.citation, b.info.citation),
    ):
        if one != other:
            yield _header_difference(WHOLE_SEQUENCE, what, one, other)


def _header_difference(stream: str, what: str, one: str | None, other: str | None) -> Difference:
    return Difference(stream, what, 1, f"{one or 'not told'} and {other or 'not told'}")


def _diff_calibration(a: Sequence, b: Sequence, stream: str) -> Iterator[Difference]:
    """Compare the intrinsics in effect, where they are more than those of a camera that both name."""
    sizes = [(info.width, info.height) for info in (a.info.images[stream], b.info.images[stream])]
    if sizes[0] != sizes[1] or not all(sizes[0]) or not any(stream in one.cameras for one in (a, b)):
        return
    first, second = (asdict(chosen_calibration(one, WriteOptions(), stream, *sizes[0])) for one in (a, b))
    for name, value in first.items():
        if value != second[name]:
            yield Difference(stream, "calibration", 1, f"{name} {_shown(value)} and {_shown(second[name])}")
            return


def _shown(value: object) -> str:
    return " ".join(f"{number:g}" for number in value) if isinstance(value, tuple) else str(value)
