# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Write a mended copy of what can be mended without guessing; the source is never touched."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.convert import convert
from tumtools.errors import InputError, UsageError
from tumtools.formats import registry
from tumtools.formats.options import WriteOptions
from tumtools.formats.tum.reader import TumSequence, open_tolerant
from tumtools.model.sequence import IMAGE_STREAMS, Frame, Sequence, frame_order
from tumtools.model.signals import Trajectory
from tumtools.sources import locate
from tumtools.validate.engine import check
from tumtools.validate.load import gather
from tumtools.validate.rules.poses import better_reading
from tumtools.validate.settings import Settings

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator
    from pathlib import Path

    import numpy.typing as npt

    from tumtools.model.text import TextLayout

    Rows = npt.NDArray[np.intp]

_BOM: Final = "\ufeff"
_MENDED_TEXT: Final = "TUM006"
_NORMALISED: Final = "TUM401"
_REORDERED: Final = "TUM403"
_GRAVITY_RATIO: Final = 1.5
_GRAVITY_DEGREES: Final = 1.0


def fix(source: str | Path, target: Path, settings: Settings | None = None, *, jobs: int = 2) -> list[str]:
    """Write a mended copy: sorted rows, plain text, unit quaternions in the order x y z w, rows with files.

    Args:
        source: A sequence of format tum.
        target: Folder or .tgz to make.
        settings: Which rules run; what they do not find is not mended.
        jobs: Threads.

    Returns:
        Every change, as a sentence; empty when nothing had to be changed.

    Raises:
        UsageError: The source is of another format, or the target exists.
        InputError: A line cannot be read as a row: what it means would have to be guessed.

    """
    path = locate(source)
    if registry.detect(path).name != "tum":
        raise UsageError(
            "--fix mends sequences of format tum", hint="convert it first: tumtools convert --to tum"
        )
    sequence = open_tolerant(path)
    if not isinstance(sequence, TumSequence):
        raise UsageError("--fix mends a folder or an archive, not a single file", path=path)
    with sequence:
        _refuse_unreadable(sequence)
        found = check(gather(source, sequence, path), settings or Settings(), full=False)
        mended = Mended(sequence, {finding.code for finding in found.findings}, _w_first(sequence, path))
        convert(mended, target, "tum", WriteOptions(jobs=jobs))
        return mended.changes


def _refuse_unreadable(sequence: TumSequence) -> None:
    for error in sequence.damaged.values():
        raise error
    for stream, table in sequence.tables.items():
        for problem in table.problems:
            if not problem.is_header:
                raise InputError(
                    f"{problem.message}; what it means would have to be guessed",
                    path=sequence.files[stream],
                    location=f"line {problem.line}",
                    hint="correct the line by hand",
                )


def _w_first(sequence: TumSequence, path: Path) -> bool:
    """Whether it is certain that the quaternions have w first."""
    return better_reading(gather(path, sequence, path), _GRAVITY_RATIO, _GRAVITY_DEGREES) == ["w x y z"]


class Mended(Sequence):
    """A sequence with what was found mended.

    Attributes:
        changes: What differs from the source.

    """

    def __init__(self, sequence: TumSequence, codes: set[str], w_first: bool) -> None:
        self._inner = sequence
        self.changes: list[str] = []
        self._rows = {stream: self._choose(stream) for stream in sequence.tables}
        self.cameras = sequence.cameras
        if sequence.groundtruth is not None:
            poses = sequence.groundtruth.take(self._rows["groundtruth"])
            self.groundtruth = self._mend_poses(poses, codes, w_first and _REORDERED in codes)
        if sequence.accelerometer is not None:
            self.accelerometer = sequence.accelerometer.take(self._rows["accelerometer"])
        layouts = {stream: self._mend_layout(stream) for stream in sequence.tables}
        images = {
            stream: replace(info, count=len(self._rows[stream]))
            for stream, info in sequence.info.images.items()
        }
        self.info = replace(
            sequence.info, text=layouts, images=images, not_carried=(), warnings=(), digest=None
        )

    def _choose(self, stream: str) -> Rows:
        """Return the rows to keep, in order of their stamps if they were not."""
        stamps, name = self._inner.tables[stream].stamps, self._inner.files[stream]
        rows = np.arange(len(stamps))
        if stream in IMAGE_STREAMS:
            names = self._inner.names[stream]
            rows = np.array([row for row in rows.tolist() if names[row] in self._inner.sizes], np.intp)
            if len(rows) < len(names):
                self.changes.append(f"{name}: left out {len(names) - len(rows)} rows without a file")
        if (stamps[rows[1:]] < stamps[rows[:-1]]).any():
            self.changes.append(f"{name}: sorted the rows by their stamps")
            rows = rows[np.argsort(stamps[rows], kind="stable")]
        return rows

    def _mend_poses(self, poses: Trajectory, codes: set[str], w_first: bool) -> Trajectory:
        quaternions, name = poses.quaternions, self._inner.files["groundtruth"]
        if w_first:
            self.changes.append(f"{name}: put the quaternions from w x y z into the order x y z w")
            quaternions = quaternions[:, [1, 2, 3, 0]]
        if _NORMALISED in codes:
            lengths = np.linalg.norm(quaternions, axis=1, keepdims=True)
            usable = np.isfinite(lengths) & (lengths > 0)
            scaled = np.where(usable, quaternions / np.where(usable, lengths, 1), quaternions)
            quaternions = scaled.round(_decimals(self._inner.tables["groundtruth"].layout))
            self.changes.append(f"{name}: normalised the quaternions")
        return Trajectory(poses.stamps, poses.positions, quaternions)

    def _mend_layout(self, stream: str) -> TextLayout:
        """Return the layout for the rows kept, as plain text."""
        table = self._inner.tables[stream]
        layout = table.layout.select(self._rows[stream].tolist())
        if stream == "groundtruth" and self._inner.groundtruth is not None and self._values_changed():
            layout = replace(layout, overrides={})
        plain = _plain(layout, lists=stream in IMAGE_STREAMS)
        name = self._inner.files[stream]
        if any(problem.is_header for problem in table.problems):
            lines = {problem.text for problem in table.problems}
            head = "".join(
                f"# {line}" if line.strip() in lines else line
                for line in plain.head.splitlines(keepends=True)
            )
            plain = replace(plain, head=head)
            self.changes.append(f"{name}: put # before a header line")
        if replace(plain, head=layout.head) != layout or _plain_head(layout.head) != layout.head:
            self.changes.append(f"{name}: written as UTF-8 with single blanks and line feeds")
        return plain

    def _values_changed(self) -> bool:
        before, after = self._inner.groundtruth, self.groundtruth
        if before is None or after is None:
            return False
        rows = before.quaternions[self._rows["groundtruth"]]
        return not np.array_equal(rows, after.quaternions, equal_nan=True)

    def image_stamps(self, stream: str) -> npt.NDArray[np.int64]:
        """See `Sequence`."""
        if stream not in self._rows or stream not in IMAGE_STREAMS:
            return np.empty(0, np.int64)
        return self._inner.image_stamps(stream)[self._rows[stream]]

    def images(
        self, streams: Collection[str] | None = None, start: int | None = None, end: int | None = None
    ) -> Iterator[Frame]:
        """See `Sequence`."""
        new = {stream: {int(row): n for n, row in enumerate(rows)} for stream, rows in self._rows.items()}
        frames = (
            replace(frame, row=new[frame.stream][frame.row])
            for frame in self._inner.images(streams, start, end)
            if frame.row in new[frame.stream]
        )
        yield from sorted(frames, key=frame_order)


def _decimals(layout: TextLayout) -> int:
    match = re.fullmatch(r"%\.(\d+)f", layout.value_format)
    return int(match[1]) if match else 9


def _plain_head(head: str) -> str:
    return head.removeprefix(_BOM).replace("\r\n", "\n")


def _plain(layout: TextLayout, *, lists: bool) -> TextLayout:
    """Return the layout with single blanks, line feeds and a final line end."""
    overrides = {}
    for row, text in layout.overrides.items():
        *before, line = text.replace("\r", "").split("\n")
        fields = [field for field in re.split(r"[,\s]+", line) if field]
        if lists:
            fields = [fields[0], fields[1].replace("\\", "/")]
        if before or lists:
            overrides[row] = "\n".join([*before, " ".join(fields)])
    return replace(
        layout,
        head=_plain_head(layout.head),
        separator=" ",
        newline="\n",
        overrides=overrides,
        tail=layout.tail.replace("\r\n", "\n"),
        final_newline=True,
    )
