# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What a sequence is: a header and small signals as arrays, images as a lazy stream in time order."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final, Literal, Self, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
    from types import TracebackType

    import numpy as np
    import numpy.typing as npt

    from tumtools.model.camera import CameraInfo
    from tumtools.model.digest import KeptDigest
    from tumtools.model.image import Image
    from tumtools.model.signals import Accelerometer, Trajectory
    from tumtools.model.text import TextLayout

IMAGE_STREAMS: Final = ("rgb", "depth", "ir")
"""Names of the image streams, in the order that equal stamps are sorted in."""
SIGNAL_STREAMS: Final = ("accelerometer", "groundtruth")
WHOLE_SEQUENCE: Final = "sequence"
"""Stands for a stream where a loss concerns them all: the name, the licence."""
RECORDING: Final = "recording"
"""Stands for a stream where a loss concerns a whole file, and what of it is not known."""
LEFT_OUT: Final = "left out as damaged"
"""What a loss says of all that a salvage passes over."""
STREAMS: Final = IMAGE_STREAMS + SIGNAL_STREAMS

TUM_DEPTH_UNITS_PER_METRE: Final = 5000.0
DATA_LICENCE: Final = "CC BY 4.0"
DATA_CITATION: Final = (
    "J. Sturm, N. Engelhard, F. Endres, W. Burgard, D. Cremers: "
    "A Benchmark for the Evaluation of RGB-D SLAM Systems. IROS 2012."
)
_OFFICIAL_PREFIX: Final = "rgbd_dataset_freiburg"


def licence_of_name(name: str) -> tuple[str | None, str | None]:
    """Return licence and citation of the data of a sequence, which are known for those of the benchmark."""
    return (DATA_LICENCE, DATA_CITATION) if name.startswith(_OFFICIAL_PREFIX) else (None, None)


Part: TypeAlias = Literal[
    "rows dropped",
    "rows repeated",
    "stamps",
    "pixels",
    "text",
    "calibration",
    "camera",
    "frame id",
    "name",
    "licence",
]
"""What of a stream, or of the whole sequence, a loss can alter. All else can still be verified."""

DetailRow: TypeAlias = "Mapping[str, str | int | float | None]"
"""A row of `Sequence.details`: column -> value; stamps as integer nanoseconds in a string."""


@dataclass(frozen=True, slots=True)
class Loss:
    """One way in which a conversion changes or drops something.

    Attributes:
        stream: Which stream, topic or file.
        what: What is changed or dropped, in a few words; the same words for the same kind of loss.
        count: How many items (frames, rows, pixels, files).
        why: Why the target or the model cannot hold it.
        largest_error: The largest change of a value, in `unit`, or None where nothing is measured.
        unit: Unit of `largest_error`.
        alters: What of the stream differs for it; nothing for what never was part of a stream.

    """

    stream: str
    what: str
    count: int
    why: str
    largest_error: float | None = None
    unit: str = ""
    alters: tuple[Part, ...] = ()


def sum_losses(losses: Iterable[Loss]) -> tuple[Loss, ...]:
    """Join the entries that differ in nothing but their count and their error, in a stable order."""
    sums: dict[Loss, Loss] = {}
    for loss in losses:
        key = replace(loss, count=0, largest_error=None)
        if key in sums:
            before = sums[key]
            errors = [one.largest_error for one in (before, loss) if one.largest_error is not None]
            sums[key] = replace(
                before, count=before.count + loss.count, largest_error=max(errors, default=None)
            )
        else:
            sums[key] = loss
    return tuple(sums.values())


@dataclass(frozen=True, slots=True)
class ImageStreamInfo:
    """What is known of an image stream without decoding it.

    Attributes:
        count: Number of images.
        encoding: Encoding of the first image as it will be delivered; None if there is no image.
        width: Columns of the first image.
        height: Rows of the first image.
        depth_units_per_metre: Of the first image, where it is depth.
        frame_id: Coordinate frame, where the source names one.
        nbytes: Bytes of all images as they are stored in the source (compressed if they are).
        compression: `png`, `jpeg`, or None for raw pixels.
        source: The topic or folder that it comes from.
        is_uniform: Whether all images have the encoding and the unit of the first because the format knows
            no other; where it does, each image may be another.

    """

    count: int
    encoding: str | None = None
    width: int = 0
    height: int = 0
    depth_units_per_metre: float | None = None
    frame_id: str | None = None
    nbytes: int = 0
    compression: str | None = None
    source: str | None = None
    is_uniform: bool = False


@dataclass(frozen=True, slots=True)
class SequenceInfo:
    """The header of a sequence.

    Attributes:
        name: Official name if known (`rgbd_dataset_freiburg1_xyz`), or that of the file.
        format: Name of the format that it was read from.
        camera: `fr1`, `fr2`, `fr3`, `ros-default`, or None if unknown.
        images: The image streams that are there, by name, in the order of `IMAGE_STREAMS`.
        sources: The topic, sensor or file that ground truth and accelerations come from, by their names.
        text: Layout of the text file of each stream, where the source knew one.
        frame_ids: Coordinate frame of each stream, where the source names one.
        licence: Licence of the data, where known.
        citation: How to cite the data, where known.
        digest: Digest by stream that the source carries of itself, if any.
        not_carried: What the source holds and the model does not: other files, other topics.
        warnings: What the user should know about the source; each names its place.

    """

    name: str
    format: str
    camera: str | None = None
    images: Mapping[str, ImageStreamInfo] = field(default_factory=dict)
    sources: Mapping[str, str] = field(default_factory=dict)
    text: Mapping[str, TextLayout] = field(default_factory=dict)
    frame_ids: Mapping[str, str] = field(default_factory=dict)
    licence: str | None = None
    citation: str | None = None
    digest: Mapping[str, KeptDigest] | None = None
    not_carried: tuple[Loss, ...] = ()
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """One image of a stream, not loaded yet.

    Attributes:
        stream: `rgb`, `depth` or `ir`.
        stamp: Nanoseconds since 1970.
        row: Which row of its stream's list this is (0 = first), in file order.
        load: Read the image; may be called from any thread, and more than once.
        frame_id: Coordinate frame, where the source names one.

    """

    stream: str
    stamp: int
    row: int
    load: Callable[[], Image]
    frame_id: str | None = None


class Sequence(ABC):
    """A recording that can be read any number of times; a context manager.

    Attributes:
        info: The header.
        groundtruth: Poses of the colour optical frame, rows in file order; None if there is no such file.
        accelerometer: Rows in file order; None if there is no such file.
        cameras: Intrinsics that the source itself carries, by image stream.

    """

    info: SequenceInfo
    groundtruth: Trajectory | None = None
    accelerometer: Accelerometer | None = None
    cameras: Mapping[str, CameraInfo] = {}

    @abstractmethod
    def image_stamps(self, stream: str) -> npt.NDArray[np.int64]:
        """Return the stamps of an image stream, rows in file order; empty if there is none."""

    @abstractmethod
    def images(
        self, streams: Collection[str] | None = None, start: int | None = None, end: int | None = None
    ) -> Iterator[Frame]:
        """Yield the images in order of (stamp, stream as in `IMAGE_STREAMS`, row).

        Args:
            streams: Only these; None for all.
            start: First stamp wanted, inclusive.
            end: Last stamp wanted, inclusive.

        Raises:
            InputError: The source is damaged.

        """

    def details(self) -> Mapping[str, tuple[DetailRow, ...]]:
        """Return what only this format knows, for people: tables by title, rows with the same columns."""
        return {}

    def noted_digest(self) -> Mapping[str, KeptDigest] | None:
        """Return the digest of what has been loaded so far, for the writer to keep at the end of its file.

        None unless somebody notes it, as a conversion with `digest` does; then writers that can keep it do.
        """
        return None

    def close(self) -> None:  # noqa: B027 - most sequences hold nothing open
        """Release files; the sequence is not used afterwards."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def frame_order(frame: Frame) -> tuple[int, int, int]:
    """Sort key of frames: stamp, then stream, then row."""
    return frame.stamp, IMAGE_STREAMS.index(frame.stream), frame.row


def streams_of(sequence: Sequence) -> tuple[str, ...]:
    """Return the names of the streams that are there, in the order of `STREAMS`."""
    signals = {"groundtruth": sequence.groundtruth, "accelerometer": sequence.accelerometer}
    return tuple(name for name in STREAMS if name in sequence.info.images or signals.get(name) is not None)
