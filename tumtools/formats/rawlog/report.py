# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What a user should know about a rawlog."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Final

from tumtools.formats.rawlog.entries import count_of
from tumtools.formats.rawlog.signals import GROUNDTRUTH, GROUNDTRUTH_FILE
from tumtools.formats.rawlog.stamps import Origin
from tumtools.printable import shortened

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from tumtools.formats.rawlog.comment import Notes
    from tumtools.formats.rawlog.entries import Entries
    from tumtools.formats.rawlog.survey import Survey

_TICK_DECIMALS: Final = 7


def warnings_of(path: Path, found: Survey, labels: Mapping[str, str]) -> Iterator[str]:
    """Tell what is odd in a rawlog.

    Args:
        path: The file.
        found: What is in it.
        labels: The sensor of each stream.

    """
    if found.damage is not None:
        yield f"{path}: {found.damage.message}; what is before it ({found.count} objects) is read"
    chosen = [label for stream, label in labels.items() if stream == "depth"]  # it may be empty
    if count := sum(found.euclidean[label] for label in chosen):
        yield (
            f"{path}: {count} depth images hold distances along the ray of each pixel "
            "(range_is_depth = 0), not depth along the optical axis; they are given as they are"
        )
    if count := sum(found.unitless[label] for label in chosen):
        yield (
            f"{path}: {count} depth images have a unit that no sensor has (rangeUnits zero, negative or "
            "absurd); their counts are taken for millimetres, as MRPT does by default"
        )
    for (stream, label), count in sorted(found.cameras_refused.items()):
        if labels.get(stream) == label:
            yield (
                f"{path}: the intrinsics of {stream} in {count} observations are no camera's (numbers that "
                "are infinite or none, a negative focal length or an absurd size), and are left out; "
                "name the camera with --camera"
            )


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
        yield f"{path}: {count} {stream} images are the one file {shortened(name or '')!r}{more}"


def warnings_of_groundtruth(path: Path, notes: Notes | None, *, there: bool) -> Iterator[str]:
    """Tell that the ground truth has been left behind."""
    if notes and not there and GROUNDTRUTH in notes.metadata.streams:
        yield (
            f"{path.parent / GROUNDTRUTH_FILE}: the file is missing; the rawlog was written with it, and "
            "without it there is no ground truth: copy it to the rawlog"
        )
