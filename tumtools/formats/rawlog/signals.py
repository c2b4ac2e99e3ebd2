# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The accelerometer of a rawlog, the ground truth beside it, and how the text files of a sequence look."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.formats import metadata
from tumtools.formats.rawlog.compression import read_file
from tumtools.formats.rawlog.stamps import FLOAT_TIME_ERROR_NS
from tumtools.formats.tum.text import parse
from tumtools.model.signals import Accelerometer, Trajectory
from tumtools.model.time import stamp_to_ticks

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    import numpy.typing as npt

    from tumtools.formats.rawlog.comment import Notes
    from tumtools.formats.rawlog.entries import Entries
    from tumtools.formats.rawlog.survey import Accelerations
    from tumtools.model.text import TextLayout

GROUNDTRUTH_FILE: Final = "groundtruth.txt"
GROUNDTRUTH: Final = "groundtruth"
ACCELEROMETER: Final = "accelerometer"


def make_accelerometer(
    rows: Accelerations | None, notes: Notes | None, entries: Entries, *, moved: bool
) -> Accelerometer | None:
    """Return the rows of an accelerometer with their exact stamps.

    Args:
        rows: As they are in the rawlog; None if there is no accelerometer.
        notes: What a comment of ours says of them.
        entries: The images; a row at the time of a frame has its time from the same float.
        moved: The times in the rawlog have been changed since the comment was written.

    """
    if rows is None:
        return Accelerometer.empty() if notes and ACCELEROMETER in notes.counts else None
    ticks = np.array(rows.ticks, np.uint64).astype(np.int64)
    stamps = (ticks - stamp_to_ticks(0)) * 100
    values = np.array(rows.values).reshape(-1, 3)
    if notes is None:
        exact = {
            entry.place.picture.ticks: entry.stamp
            for group in entries.values()
            for entry in group
            if 0 < abs(entry.stamp - entry.place.picture.stamp) <= FLOAT_TIME_ERROR_NS
        }
        for row in np.flatnonzero(np.isin(ticks, list(exact))).tolist() if exact else ():
            stamps[row] = exact[int(ticks[row])]
        return Accelerometer(stamps, values)
    remainders = notes.accelerometer_remainders_ns
    if len(remainders) == len(stamps) and not moved:
        stamps += np.array(remainders, np.int64)
    order = np.array(notes.metadata.row_order.get(ACCELEROMETER, ()), np.int64)
    if np.array_equal(np.sort(order), np.arange(len(stamps))):
        back = np.argsort(order)
        stamps, values = stamps[back], values[back]
    return Accelerometer(stamps, values)


def read_groundtruth(folder: Path) -> tuple[Trajectory, TextLayout] | None:
    """Read the text file beside a rawlog; None if there is none.

    Raises:
        InputError: It cannot be read.

    """
    path = folder / GROUNDTRUTH_FILE
    try:
        data = read_file(path)
    except FileNotFoundError:
        return None
    table = parse(data, GROUNDTRUTH, str(path))
    return Trajectory(table.stamps, table.values[:, :3], table.values[:, 3:]), table.layout


def fitting_layouts(
    path: Path,
    notes: Notes,
    stamps: Mapping[str, npt.NDArray[np.int64]],
    accelerometer: Accelerometer | None,
    warnings: list[str],
    *,
    damaged: bool,
) -> dict[str, TextLayout]:
    """Return how the text files look, without what the comment says of rows that are not as they were.

    Args:
        path: For messages.
        notes: The comment.
        stamps: Of each image stream.
        accelerometer: With its stamps.
        warnings: What is left out is added.
        damaged: Rows may be missing as they are behind the damage.

    """
    columns = {stream: (values, np.empty((len(values), 0))) for stream, values in stamps.items()}
    if accelerometer is not None:
        columns[ACCELEROMETER] = (accelerometer.stamps, accelerometer.values)
    layouts = dict(notes.metadata.text)
    for stream, layout in notes.metadata.text.items():
        if stream == GROUNDTRUTH:
            del layouts[stream]  # its file brings its own
            continue
        times, values = columns.get(stream, (np.empty(0, np.int64), np.empty((0, 0))))
        written = notes.counts.get(stream, 0)
        if len(times) != written:
            layouts[stream] = replace(layout, overrides={}, tail="", final_newline=True)
            why = "the others are behind the damage" if damaged else "it has been edited since it was written"
            warnings.append(f"{path}: {len(times)} of the {written} rows of {stream} are there; {why}")
            continue
        layouts[stream] = metadata.fitting(layout, stream, times, values)
        if dropped := len(layout.overrides) - len(layouts[stream].overrides):
            warnings.append(
                f"{path}: the text that the comment keeps for {dropped} rows of {stream} does not say what "
                "the rawlog says, and is left out"
            )
    return layouts
