# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What a user should know about a rawlog, and what of it a sequence cannot hold."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Final

from tumtools.formats.rawlog.comment import is_ours
from tumtools.formats.rawlog.entries import count_of
from tumtools.formats.rawlog.signals import GROUNDTRUTH, GROUNDTRUTH_FILE
from tumtools.formats.rawlog.stamps import Origin
from tumtools.model.sequence import Loss

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping
    from pathlib import Path

    from tumtools.formats.rawlog.comment import Notes
    from tumtools.formats.rawlog.entries import Entries
    from tumtools.formats.rawlog.survey import Survey

_TICK_DECIMALS: Final = 7
_NO_PLACE: Final = "a sequence has no stream for it"


def warnings_of(path: Path, found: Survey, labels: Mapping[str, str]) -> Iterator[str]:
    """Tell what is odd in a rawlog.

    Args:
        path: The file.
        found: What is in it.
        labels: The sensor of each stream.

    """
    if found.damage is not None:
        yield f"{path}: {found.damage.message}; what is before it ({found.count} objects) is read"
    if count := found.euclidean.get(labels.get("depth", ""), 0):
        yield (
            f"{path}: {count} depth images hold distances along the ray of each pixel "
            "(range_is_depth = 0), not depth along the optical axis; they are given as they are"
        )
    if count := found.unitless.get(labels.get("depth", ""), 0):
        yield (
            f"{path}: {count} depth images have a unit that no sensor has (rangeUnits zero, negative or "
            "absurd); their counts are taken for millimetres, as MRPT does by default"
        )
    if found.timeless:
        yield f"{path}: {found.timeless} observations have no time and are left out"
    for (stream, label), count in sorted(found.cameras_refused.items()):
        if labels.get(stream) == label:
            yield (
                f"{path}: the intrinsics of {stream} in {count} observations are no camera's (numbers that "
                "are infinite or none, or an absurd size), and are left out; name the camera with --camera"
            )
    for stream in sorted(found.cameras_changed):
        yield f"{path}: the intrinsics of {stream} change; those of the first observation are given"


def warnings_of_stamps(path: Path, entries: Entries, notes: Notes | None) -> Iterator[str]:
    """Tell of stamps that are not known exactly any more."""
    images = sum(map(len, entries.values()))
    if moved := count_of(entries, Origin.MOVED):
        yield (
            f"{path}: the times of {moved} of the {images} images are not those that their files are named "
            "after: they have been changed since; the stamps are those of the rawlog"
            + (f", and {GROUNDTRUTH_FILE} may have others" if notes else "")
        )
    if notes and (unknown := count_of(entries, Origin.PARTNER)):
        yield (
            f"{path}: the stamps of {unknown} depth images are lost, as their files have been renamed since; "
            "they are given those of the images beside them"
        )
    for stream, layout in notes.metadata.text.items() if notes else ():
        if layout.stamp_decimals > _TICK_DECIMALS and any(
            entry.origin is Origin.TIME for entry in entries.get(stream, ())
        ):
            yield f"{path}: the stamps of embedded {stream} images are known to 100 ns only"


def warnings_of_files(path: Path, entries: Entries) -> Iterator[str]:
    """Tell of files that several images share."""
    names = Counter(
        (stream, entry.place.picture.file)
        for stream, group in entries.items()
        for entry in group
        if entry.place.picture.file is not None
    )
    shared = [(stream, name, count) for (stream, name), count in names.items() if count > 1]
    if shared:
        stream, name, count = max(shared, key=lambda item: item[2])
        more = f"; {len(shared) - 1} more files are shared" if len(shared) > 1 else ""
        yield f"{path}: {count} {stream} images are the one file {name!r}{more}"


def losses_of_files(streams: Iterable[str]) -> Iterator[Loss]:
    """Yield the images that are left out because their files are missing, one by one in `streams`."""
    for stream, count in sorted(Counter(streams).items()):
        yield Loss(stream, "images without their file", count, "their external files are missing")


def warnings_of_groundtruth(path: Path, notes: Notes | None, *, there: bool) -> Iterator[str]:
    """Tell that the ground truth has been left behind."""
    if notes and not there and GROUNDTRUTH in notes.metadata.streams:
        yield (
            f"{path.parent / GROUNDTRUTH_FILE}: the file is missing; the rawlog was written with it, and "
            "without it there is no ground truth: copy it to the rawlog"
        )


def losses_of(
    found: Survey, labels: Mapping[str, str], notes: Notes | None, *, has_groundtruth: bool
) -> Iterator[Loss]:
    """Yield what is in a rawlog, or was, and is not in its sequence."""
    if found.damage is not None:
        yield Loss("rawlog", "part behind the damage", 1, found.damage.message)
    for (label, what), count in sorted(found.not_carried.items()):
        yield Loss(label or "rawlog", what, count, _NO_PLACE)
    for (label, what), count in sorted(found.nameless.items()):
        yield Loss(label, what, count, "it is said to be in a file whose name is empty")
    unchosen = Counter(
        (place.picture.label, f"{place.picture.stream} image")
        for place in found.places
        if labels.get(place.picture.stream) != place.picture.label
    )
    for (label, what), count in sorted(unchosen.items()):
        yield Loss(label, what, count, "no or another sensor was chosen for the stream")
    for (stream, label), count in sorted(found.cameras_refused.items()):
        if labels.get(stream) == label:
            why = "no camera has them: numbers that are infinite or none, or an absurd size"
            yield Loss(stream, "intrinsics", count, why)
    if others := sum(not is_ours(one.text) for one in found.comments):
        yield Loss("comment", "comment text", others, _NO_PLACE)
    if notes is None and (ours := len(found.comments) - others):
        why = "it is damaged" if ours == 1 else "each is about a part of the rawlog only"
        yield Loss("comment", "comment of tumtools", ours, why)
    if notes and not has_groundtruth and GROUNDTRUTH in notes.metadata.streams:
        yield Loss(GROUNDTRUTH, "ground truth", 1, f"{GROUNDTRUTH_FILE} is not beside the rawlog")
