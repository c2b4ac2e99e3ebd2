# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What can be asked of readers and writers, the same for every format."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping
    from pathlib import Path

    from tumtools.model.camera import CameraInfo
    from tumtools.model.sequence import Loss


@dataclass(frozen=True, slots=True)
class ReadOptions:
    """How to read a source.

    Attributes:
        topics: Stream -> topic, for recordings where the streams cannot be told by type alone.
        salvage: Deliver what is readable of a damaged source before the damage, and warn, instead of
            failing.
        lenient: Leave streams out for which several topics could be meant, and warn, instead of failing.
        streams: Those that are wanted; that several topics could be meant by another one is no failure then,
            it is left out. None for all.
        scratch: A folder for a temporary file, for those who are going to read all images: a compressed
            archive is inflated once to a file without a name, if there is room. Without a folder or room
            it is inflated as often as the order of its members demands.

    """

    topics: Mapping[str, str] = field(default_factory=dict)
    salvage: bool = False
    lenient: bool = False
    streams: frozenset[str] | None = None
    scratch: Path | None = None

    def wants(self, stream: str) -> bool:
        """Whether a stream is wanted."""
        return self.streams is None or stream in self.streams


@dataclass(frozen=True, slots=True)
class WriteOptions:
    """How to write a target. None means the default of the format (`registry.Format.options`).

    Attributes:
        archive: Pass PNG files through byte for byte.
        layout: Topic and frame names: `published` or `modern`.
        profile: MCAP profile: `ros1` or `ros2`.
        storage: rosbag2 storage: `sqlite3` or `mcap`.
        ros_distro: ROS 2 release that must be able to read the result.
        color_encoding: `png`, `rgb8` or `bgr8`.
        depth_encoding: `png`, `32FC1` or `16UC1`.
        compression: `none`, `lz4`, `zstd`, `bz2` or `gzip`.
        dialect: rawlog dialect: `modern`, `legacy` or `converter`.
        groundtruth: `pose`, `tf`, `both` or `none`.
        camera: Name of a calibration (`tumtools.model.camera.CAMERAS`) to use instead of the sequence's.
        cameras: Intrinsics by image stream that overrule everything else.
        frame_ids: Stream -> coordinate frame.
        topics: Stream -> topic to write it to.
        jobs: Threads for decoding and encoding.

    """

    archive: bool = False
    layout: str | None = None
    profile: str | None = None
    storage: str | None = None
    ros_distro: str | None = None
    color_encoding: str | None = None
    depth_encoding: str | None = None
    compression: str | None = None
    dialect: str | None = None
    groundtruth: str | None = None
    camera: str | None = None
    cameras: Mapping[str, CameraInfo] = field(default_factory=dict)
    frame_ids: Mapping[str, str] = field(default_factory=dict)
    topics: Mapping[str, str] = field(default_factory=dict)
    jobs: int = 2


@dataclass(frozen=True, slots=True)
class Needs:
    """What a writer must be given, so that what it writes can be lossless.

    Attributes:
        depth_units_per_metre: Depth in counts of this unit; None if any depth will do.
        float_depth_units_per_metre: Depth in metres becomes counts of this unit, where other counts will do;
            None if it is kept.
        pixel_streams: Streams that are written from their pixels; others are kept as PNG if they are.
        metres: Depth is written in metres; counts may come as such, NaN for "no reading".
        drops: Streams that are not written.
        keeps_digest: Whether the target can hold a digest of its content.

    """

    depth_units_per_metre: float | None = None
    float_depth_units_per_metre: float | None = None
    pixel_streams: frozenset[str] = frozenset()
    metres: bool = False
    drops: frozenset[str] = frozenset()
    keeps_digest: bool = False


@dataclass(frozen=True, slots=True)
class Plan:
    """What a writer can tell before it writes, without looking at pixels.

    Attributes:
        losses: What would be lost.
        nbytes: Estimated size of the target.
        warnings: What it assumes.
        images: Image stream -> its rows that are written; streams that are not named are written whole.
        frames: Images that the target holds, those that it holds again included; None for all that are given.
        rows: Rows of the signals that it holds; None likewise.

    """

    losses: tuple[Loss, ...] = ()
    nbytes: int = 0
    warnings: tuple[str, ...] = ()
    images: Mapping[str, Collection[int]] = field(default_factory=dict)
    frames: int | None = None
    rows: int | None = None


class Progress(Protocol):
    """Told by readers and writers how far they are."""

    def __call__(self, frames: int, nbytes: int, /) -> None:
        """So many more frames and bytes are done."""


def no_progress(frames: int, nbytes: int) -> None:
    """Progress that nobody watches."""
