# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Sequences made of sequences: a choice of streams and times, depth in other units.

Whatever a target cannot hold is taken out or changed here, before the writer, so that the writer itself
is lossless and can be checked to the last bit.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from threading import Lock
from typing import TYPE_CHECKING

import numpy as np

from tumtools.errors import UsageError
from tumtools.images.bayer import PATTERNS, demosaic
from tumtools.images.codec import image_of_pixels, pixels_of
from tumtools.images.depth import EXACT, Rounding, rescale_counts, to_counts
from tumtools.model.sequence import IMAGE_STREAMS, STREAMS, Frame, Loss, Sequence
from tumtools.model.time import parse_stamp

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator

    import numpy.typing as npt

    from tumtools.model.image import Image
    from tumtools.model.signals import Accelerometer, Trajectory


_THREE_YEARS_NS = 10**17


@dataclass(frozen=True, slots=True)
class Selection:
    """What to keep of a sequence.

    Attributes:
        streams: These only; None for all.
        start: First stamp, inclusive; None for no limit.
        end: Last stamp, inclusive; None for no limit.
        every: Keep each n-th image of each image stream, the first included.

    """

    streams: tuple[str, ...] | None = None
    start: int | None = None
    end: int | None = None
    every: int = 1

    @property
    def keeps_all(self) -> bool:
        """Whether nothing is taken out."""
        return self.streams is None and self.keeps_all_rows

    @property
    def keeps_all_rows(self) -> bool:
        """Whether nothing is taken out of a stream that is kept."""
        return self.start is None and self.end is None and self.every == 1

    def has(self, stream: str) -> bool:
        """Whether a stream is kept."""
        return self.streams is None or stream in self.streams

    def rows(self, stamps: npt.NDArray[np.int64]) -> npt.NDArray[np.intp]:
        """Return the rows within the time limits, in file order."""
        keep = np.ones(len(stamps), bool)
        if self.start is not None:
            keep &= stamps >= self.start
        if self.end is not None:
            keep &= stamps <= self.end
        return np.flatnonzero(keep)

    def image_rows(self, stamps: npt.NDArray[np.int64]) -> npt.NDArray[np.intp]:
        """Return the rows within the time limits, each n-th in order of stamps, in file order."""
        rows = self.rows(stamps)
        by_time = rows[np.argsort(stamps[rows], kind="stable")]
        return np.sort(by_time[:: self.every])


class Selected(Sequence):
    """A choice of streams, times and frames of another sequence; what is taken out was asked for."""

    def __init__(self, sequence: Sequence, selection: Selection) -> None:
        self.inner = sequence
        self._rows = {
            stream: selection.image_rows(sequence.image_stamps(stream))
            for stream in sequence.info.images
            if selection.has(stream)
        }
        signals: dict[str, npt.NDArray[np.intp]] = {}
        if sequence.groundtruth is not None and selection.has("groundtruth"):
            signals["groundtruth"] = selection.rows(sequence.groundtruth.stamps)
            self.groundtruth: Trajectory | None = sequence.groundtruth.take(signals["groundtruth"])
        if sequence.accelerometer is not None and selection.has("accelerometer"):
            signals["accelerometer"] = selection.rows(sequence.accelerometer.stamps)
            self.accelerometer: Accelerometer | None = sequence.accelerometer.take(signals["accelerometer"])
        rows = self._rows | signals
        self.cameras = {name: info for name, info in sequence.cameras.items() if selection.has(name)}
        self.info = replace(
            sequence.info,
            images={
                stream: replace(
                    info,
                    count=len(self._rows[stream]),
                    nbytes=info.nbytes * len(self._rows[stream]) // max(info.count, 1),
                )
                for stream, info in sequence.info.images.items()
                if stream in self._rows
            },
            text={
                stream: layout.select(rows[stream].tolist())
                for stream, layout in sequence.info.text.items()
                if stream in rows
            },
            digest=None,
        )

    def image_stamps(self, stream: str) -> npt.NDArray[np.int64]:
        """Return the stamps that are kept."""
        if stream not in self._rows:
            return np.empty(0, np.int64)
        return self.inner.image_stamps(stream)[self._rows[stream]]

    def images(
        self, streams: Collection[str] | None = None, start: int | None = None, end: int | None = None
    ) -> Iterator[Frame]:
        """Yield the images that are kept, their rows numbered anew."""
        wanted = [stream for stream in self._rows if streams is None or stream in streams]
        kept = {stream: {int(row): new for new, row in enumerate(self._rows[stream])} for stream in wanted}
        stamps = [self.image_stamps(stream) for stream in wanted if len(self._rows[stream])]
        if not stamps:
            return
        first = min(int(times.min()) for times in stamps)
        last = max(int(times.max()) for times in stamps)
        first = first if start is None else max(first, start)
        last = last if end is None else min(last, end)
        for frame in self.inner.images(wanted, first, last):
            new = kept[frame.stream].get(frame.row)
            if new is not None:
                yield replace(frame, row=new)

    def close(self) -> None:
        """Close the inner sequence."""
        self.inner.close()


def select(sequence: Sequence, selection: Selection) -> Sequence:
    """Return the chosen part of a sequence, itself if all is kept."""
    return sequence if selection.keeps_all else Selected(sequence, selection)


def without(sequence: Sequence, streams: Collection[str]) -> Sequence:
    """Return the sequence without some of its streams."""
    return Selected(sequence, Selection(streams=tuple(name for name in STREAMS if name not in streams)))


class RescaledDepth(Sequence):
    """A sequence whose depth is in counts of another unit. What the rounding changes is counted.

    Each image is looked at on its own: recordings may hold counts of several units, and metres.

    Args:
        sequence: With depth in counts or in metres.
        units_per_metre: Wanted; None if any counts will do.
        of_metres: The unit of depth that is in metres, where any counts will do; None to keep it.

    Attributes:
        is_expected: Whether the first image tells already that there is something to do.

    """

    def __init__(
        self, sequence: Sequence, units_per_metre: float | None, of_metres: float | None = None
    ) -> None:
        self.inner = sequence
        self._units = units_per_metre
        self._of_metres = of_metres
        self._lock = Lock()
        self._roundings: dict[int, tuple[float, Rounding]] = {}
        self.groundtruth = sequence.groundtruth
        self.accelerometer = sequence.accelerometer
        self.cameras = sequence.cameras
        images = dict(sequence.info.images)
        first = images["depth"]
        units = self._wanted(first.encoding, first.depth_units_per_metre)
        self.is_expected = units is not None
        if units is not None:
            images["depth"] = replace(first, encoding="16UC1", depth_units_per_metre=units, compression=None)
        self.info = replace(sequence.info, images=images)

    def _wanted(self, encoding: str | None, units_per_metre: float | None) -> float | None:
        """Return the unit that depth has to be brought into; None if it may stay as it is."""
        is_metres = encoding == "32FC1"
        units = self._units or (self._of_metres if is_metres else None)
        return None if units == units_per_metre and not is_metres else units

    def image_stamps(self, stream: str) -> npt.NDArray[np.int64]:
        """Return the stamps of the inner sequence."""
        return self.inner.image_stamps(stream)

    def images(
        self, streams: Collection[str] | None = None, start: int | None = None, end: int | None = None
    ) -> Iterator[Frame]:
        """Yield the images; depth is rescaled when it is loaded."""
        for frame in self.inner.images(streams, start, end):
            yield replace(frame, load=partial(self._load, frame)) if frame.stream == "depth" else frame

    def _load(self, frame: Frame) -> Image:
        image = frame.load()
        units = self._wanted(image.encoding, image.depth_units_per_metre)
        if units is None:
            return image
        pixels = pixels_of(image)
        if image.encoding == "32FC1":
            counts, rounding = to_counts(pixels.astype(np.float32, copy=False), units)
        else:
            counts, rounding = rescale_counts(
                pixels.astype(np.uint16, copy=False), image.depth_units_per_metre or 1.0, units
            )
        if rounding != EXACT:
            with self._lock:
                self._roundings[frame.row] = units, rounding
        return image_of_pixels(counts, "16UC1", units)

    def losses(self) -> tuple[Loss, ...]:
        """Return what has been changed in the frames loaded so far."""
        losses = []
        for units in sorted({units for units, _ in self._roundings.values()}):
            total = sum((one for of, one in self._roundings.values() if of == units), EXACT)
            if total.inexact:
                why = f"the target holds multiples of 1/{units:g} m"
                losses.append(
                    Loss("depth", "pixels rounded", total.inexact, why, total.largest_error, "m", ("pixels",))
                )
            if total.clipped:
                why = f"the target holds 0 to {65535 / units:.3f} m"
                what = "pixels out of range, now without a reading"
                losses.append(Loss("depth", what, total.clipped, why, alters=("pixels",)))
        return tuple(losses)

    def close(self) -> None:
        """Close the inner sequence."""
        self.inner.close()


def rescale_depth(
    sequence: Sequence, units_per_metre: float | None, of_metres: float | None = None
) -> Sequence:
    """Return the sequence with depth in counts of a unit, itself if all of it is known to be so.

    Args:
        sequence: Any.
        units_per_metre: The unit; None if any counts will do.
        of_metres: The unit of depth that is in metres (`32FC1`), where any counts will do; None to keep it.

    """
    depth = sequence.info.images.get("depth")
    if depth is None or depth.count == 0 or (units_per_metre is None and of_metres is None):
        return sequence
    rescaled = RescaledDepth(sequence, units_per_metre, of_metres)
    return sequence if depth.is_uniform and not rescaled.is_expected else rescaled


class Demosaiced(Sequence):
    """A sequence whose colour images came as Bayer mosaics, as colour.

    Args:
        sequence: With a mosaic in its stream `rgb`.

    """

    def __init__(self, sequence: Sequence) -> None:
        self.inner = sequence
        self.groundtruth = sequence.groundtruth
        self.accelerometer = sequence.accelerometer
        self.cameras = sequence.cameras
        images = dict(sequence.info.images)
        images["rgb"] = replace(images["rgb"], encoding="rgb8", nbytes=3 * images["rgb"].nbytes)
        self.info = replace(sequence.info, images=images)

    def image_stamps(self, stream: str) -> npt.NDArray[np.int64]:
        """Return the stamps of the inner sequence."""
        return self.inner.image_stamps(stream)

    def images(
        self, streams: Collection[str] | None = None, start: int | None = None, end: int | None = None
    ) -> Iterator[Frame]:
        """Yield the images; mosaics become colour when they are loaded."""
        for frame in self.inner.images(streams, start, end):
            yield replace(frame, load=partial(_demosaic, frame)) if frame.stream == "rgb" else frame

    def losses(self) -> tuple[Loss, ...]:
        """Say that colours were interpolated."""
        why = "each pixel of a Bayer mosaic has one colour; the two others are interpolated"
        count = self.info.images["rgb"].count
        return (Loss("rgb", "mosaics made to colour images", count, why, alters=("pixels",)),)

    def close(self) -> None:
        """Close the inner sequence."""
        self.inner.close()


def _demosaic(frame: Frame) -> Image:
    image = frame.load()
    if image.encoding not in PATTERNS:
        return image
    return image_of_pixels(demosaic(pixels_of(image).astype(np.uint8, copy=False), image.encoding), "rgb8")


def demosaiced(sequence: Sequence) -> Sequence:
    """Return the sequence with colour images, itself if they are no Bayer mosaics."""
    colour = sequence.info.images.get("rgb")
    return Demosaiced(sequence) if colour is not None and colour.encoding in PATTERNS else sequence


def transform_losses(sequence: Sequence) -> tuple[Loss, ...]:
    """Return what the transformations of this module have changed in the frames loaded so far."""
    losses: tuple[Loss, ...] = ()
    while isinstance(sequence, (Selected, Demosaiced, RescaledDepth)):
        if not isinstance(sequence, Selected):
            losses = sequence.losses() + losses
        sequence = sequence.inner
    return losses


def parse_selection(
    sequence: Sequence, start: str | None, end: str | None, every: int, streams: tuple[str, ...] | None
) -> Selection:
    """Return what to keep, from texts as users write them.

    Args:
        sequence: What it is taken from.
        start: Seconds from the first stamp, or since 1970; None for no limit.
        end: The same.
        every: Keep each n-th image.
        streams: Keep these only; None for all.

    Raises:
        UsageError: No number, or no such stream.

    """
    first = first_stamp(sequence) or 0
    limits = []
    for option, text in (("--start", start), ("--end", end)):
        try:
            stamp = None if text is None else parse_stamp(text)
        except ValueError as error:
            raise UsageError(f"{option}: {error}") from error
        # A small number is meant from the beginning, also where the clock of the recording starts near 0.
        relative = stamp is not None and abs(stamp) < max(first // 2, _THREE_YEARS_NS)
        limits.append(stamp + first if stamp is not None and relative else stamp)
    unknown = set(streams or ()) - set(STREAMS)
    if unknown:
        raise UsageError(
            f"--streams: no stream {', '.join(sorted(unknown))}", hint=f"streams: {', '.join(STREAMS)}"
        )
    return Selection(streams, limits[0], limits[1], every)


def first_stamp(sequence: Sequence) -> int | None:
    """Return the earliest stamp of the image streams, or of the signals if there are no images."""
    images = [sequence.image_stamps(stream) for stream in IMAGE_STREAMS]
    signals = [
        signal.stamps for signal in (sequence.groundtruth, sequence.accelerometer) if signal is not None
    ]
    for group in (images, signals):
        stamps = [times.min() for times in group if len(times)]
        if stamps:
            return int(min(stamps))
    return None
