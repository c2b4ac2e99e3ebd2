# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What a rawlog holds and a sequence has no place for."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Final

from tumtools.formats.rawlog.pictures import EMPTY_DEPTH_IMAGE, EMPTY_IMAGE
from tumtools.formats.rawlog.signals import GROUNDTRUTH, GROUNDTRUTH_FILE
from tumtools.model.sequence import IMAGE_STREAMS, LEFT_OUT, RECORDING, Loss

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from tumtools.errors import InputError
    from tumtools.formats.rawlog.comment import Notes
    from tumtools.formats.rawlog.survey import Survey

_NO_PLACE: Final = "a sequence has no stream for it"
_EMPTY: Final = "it is empty in the rawlog"
_UNLABELLED: Final = "rawlog"
"""Stands for the label of a sensor that has none, which is MRPT's default."""


def beside_the_streams(found: Survey, labels: Mapping[str, str], *, is_ours: bool) -> Iterator[Loss]:
    """Yield what is not read.

    Args:
        found: What is in the rawlog.
        labels: Sensor of each stream.
        is_ours: Whether the intrinsics of an image follow from its size, as in what tumtools writes.

    """
    for (label, what), count in sorted(found.not_carried.items()):
        why = _EMPTY if what in {EMPTY_IMAGE, EMPTY_DEPTH_IMAGE} else _NO_PLACE
        yield Loss(label or _UNLABELLED, what, count, why)
    for (label, what), count in sorted(found.nameless.items()):
        yield Loss(label or _UNLABELLED, what, count, "it is said to be in a file whose name is empty")
    others = Counter(
        (place.picture.label, f"{place.picture.stream} image")
        for place in found.places
        if labels.get(place.picture.stream) != place.picture.label
    )
    for (label, what), count in sorted(others.items()):
        yield Loss(label or _UNLABELLED, what, count, "no or another sensor was chosen for the stream")
    for (stream, label), count in sorted(found.cameras_refused.items()):
        if labels.get(stream) == label:
            why = "no camera has them: numbers that are infinite, none or of a wrong sign, or an absurd size"
            yield Loss(stream, "intrinsics", count, why)
    why = "a sequence has one calibration for each image stream, that of its first observation"
    for (stream, label), count in sorted(found.cameras_changed.items()):
        if labels.get(stream) == label and not is_ours:
            yield Loss(stream, "calibrations that differ from the first", count, why)


def left_behind(notes: Notes | None, missing: Iterable[str], *, has_groundtruth: bool) -> Iterator[Loss]:
    """Yield what should be beside the rawlog and is not.

    Args:
        notes: What a comment of ours says.
        missing: Stream of each image that is passed over, as its file is missing.
        has_groundtruth: Whether its file is there.

    """
    for stream, count in sorted(Counter(missing).items()):
        yield Loss(stream, "images without their file", count, "their external files are missing")
    if notes and not has_groundtruth and GROUNDTRUTH in notes.metadata.streams:
        yield Loss(GROUNDTRUTH, "ground truth", 1, f"{GROUNDTRUTH_FILE} is not beside the rawlog")


def left_out(damage: InputError, promised: Mapping[str, int], found: Mapping[str, int]) -> Iterator[Loss]:
    """Yield what a salvage passes over.

    Args:
        damage: Where the reading ended.
        promised: Images or rows of each stream as our notes count them; empty in rawlogs of others.
        found: Those that are there.

    """
    why = f"{damage.location}: {damage.message}" if damage.location else damage.message
    missing = {stream: count - found.get(stream, 0) for stream, count in promised.items()}
    for stream, count in missing.items():
        if count > 0:
            kind = "images" if stream in IMAGE_STREAMS else "rows"
            yield Loss(stream, f"{kind} {LEFT_OUT}", count, why)
    if not any(count > 0 for count in missing.values()):
        yield Loss(RECORDING, "end missing", 1, why)
