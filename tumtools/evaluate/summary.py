# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Statistics of a sequence: its motion and its streams, frame counts, rates, drops and coverage."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from tumtools.evaluate.associate import MAX_DIFFERENCE, associate, closest, last_rows
from tumtools.evaluate.motion import Motion, motion
from tumtools.model.sequence import IMAGE_STREAMS
from tumtools.model.time import NANOSECONDS_PER_SECOND

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy.typing as npt

    from tumtools.model.sequence import Sequence


@dataclass(frozen=True, slots=True)
class Stream:
    """When the items of a stream come.

    Attributes:
        count: Items.
        repeated: Items whose stamp comes again.
        first: First stamp, ns; None without items.
        last: Last stamp, ns; None without items.
        duration: Last minus first stamp, seconds.
        median_rate: Items per second, from the median step; None below two stamps.
        mean_rate: Items per second over the duration; None below two stamps.
        dropped: Items that are missing, if they should come at the median step: each longer step
            counts as the whole number of steps nearest to it, less one. None for the accelerometer,
            whose rows come in bursts.
        largest_gap: Longest step, seconds.
        with_groundtruth: Items with a ground-truth pose nearer than 20 ms; None without ground truth.

    """

    count: int
    repeated: int
    first: int | None
    last: int | None
    duration: float
    median_rate: float | None
    mean_rate: float | None
    dropped: int | None
    largest_gap: float
    with_groundtruth: int | None = None


@dataclass(frozen=True, slots=True)
class Summary:
    """Statistics of a sequence.

    Attributes:
        name: Name of the sequence.
        streams: By name, those that are there.
        pairs: Colour and depth images that the benchmark's rule pairs; None if one is missing.
        motion: Of the ground truth; None if there is none or it has no usable row.
        notes: What the user should know.

    """

    name: str
    streams: Mapping[str, Stream] = field(default_factory=dict)
    pairs: int | None = None
    motion: Motion | None = None
    notes: tuple[str, ...] = ()


def summarise(sequence: Sequence) -> Summary:
    """Sum up a sequence without reading its images."""
    images = {name: sequence.image_stamps(name) for name in IMAGE_STREAMS}
    images = {name: stamps for name, stamps in images.items() if len(stamps)}
    truth = sequence.groundtruth
    poses = None if truth is None or not len(truth) else truth.stamps[last_rows(truth.stamps)]
    streams = {name: stream_statistics(stamps, poses) for name, stamps in images.items()}
    for name, signal in (("accelerometer", sequence.accelerometer), ("groundtruth", truth)):
        if signal is not None:
            found = stream_statistics(signal.stamps)
            streams[name] = replace(found, dropped=None) if name == "accelerometer" else found
    both = "rgb" in images and "depth" in images
    moved = motion(truth) if truth is not None and len(truth) else None
    return Summary(
        name=sequence.info.name,
        streams=streams,
        pairs=len(associate(images["rgb"], images["depth"])) if both else None,
        motion=moved,
        notes=() if moved is None else moved.notes,
    )


def stream_statistics(
    stamps: npt.NDArray[np.int64], groundtruth: npt.NDArray[np.int64] | None = None
) -> Stream:
    """Sum up the stamps of a stream.

    Args:
        stamps: ns, int64, shape [n], in any order.
        groundtruth: Ascending stamps of the ground truth, ns, if coverage is wanted.

    """
    times = np.unique(stamps)
    if not len(times):
        return Stream(len(stamps), 0, None, None, 0.0, None, None, 0, 0.0)
    steps = np.diff(times)
    median = float(np.median(steps)) if len(steps) else 0.0
    duration = (int(times[-1]) - int(times[0])) / NANOSECONDS_PER_SECOND
    return Stream(
        count=len(stamps),
        repeated=len(stamps) - len(times),
        first=int(times[0]),
        last=int(times[-1]),
        duration=duration,
        median_rate=NANOSECONDS_PER_SECOND / median if len(steps) else None,
        mean_rate=len(steps) / duration if len(steps) else None,
        dropped=int(np.sum(np.maximum(np.rint(steps / median) - 1, 0))) if len(steps) else 0,
        largest_gap=int(steps.max()) / NANOSECONDS_PER_SECOND if len(steps) else 0.0,
        with_groundtruth=None if groundtruth is None else covered(stamps, groundtruth),
    )


def covered(stamps: npt.NDArray[np.int64], groundtruth: npt.NDArray[np.int64]) -> int:
    """Count the stamps that have a ground-truth pose nearer than 20 ms."""
    if not len(groundtruth):
        return 0
    near = closest(groundtruth, stamps)
    return int(np.count_nonzero(np.abs(groundtruth[near] - stamps) < MAX_DIFFERENCE))
