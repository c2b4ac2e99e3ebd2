# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Any text file whose rows begin with a stamp, as the benchmark's `associate.py` reads it.

Image lists, trajectories, accelerometer files, and lists of other people's with any number of
columns. What follows the stamp is kept as text.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tumtools.errors import InputError
from tumtools.model.signals import Trajectory
from tumtools.model.time import format_stamp, parse_stamp

if TYPE_CHECKING:
    import numpy.typing as npt

_SEPARATORS = re.compile(r"[,\t ]+")
_TEXT = bytes({7, 8, 9, 10, 12, 13, 27} | set(range(0x20, 0x100)) - {0x7F})
_HEAD_BYTES = 1024
_POSITION_COLUMNS = 4


@dataclass(frozen=True, slots=True, eq=False)
class Rows:
    """Rows of a stream.

    Attributes:
        stamps: ns, int64, shape [n].
        texts: What follows the stamp of each row, fields joined by a blank.
        notes: What the user should know.

    """

    stamps: npt.NDArray[np.int64]
    texts: tuple[str, ...]
    notes: tuple[str, ...] = ()


def is_text(path: str | Path) -> bool:
    """Tell whether a file looks like text."""
    target = Path(path)
    if not target.is_file():
        return False
    with target.open("rb") as file:
        return not file.read(_HEAD_BYTES).translate(None, _TEXT)


def read_rows(path: str | Path) -> Rows:
    """Read a text file.

    Fields are separated by blanks, tabs or commas. Lines that begin with `#`, blank ones, and those
    with a stamp and nothing else are no rows.

    Raises:
        InputError: A row does not begin with a stamp, or the file cannot be read.

    """
    try:
        lines = Path(path).read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"not a readable text file: {error}", path=path) from error
    stamps: list[int] = []
    texts: list[str] = []
    notes: list[str] = []
    for number, line in enumerate(lines, 1):
        fields = [field for field in _SEPARATORS.split(line) if field]
        if line.startswith("#") or len(fields) < 2:  # noqa: PLR2004 - as the script
            continue
        try:
            stamps.append(parse_stamp(fields[0]))
        except ValueError as error:
            if not stamps and fields[0][0].isalpha():
                notes.append(f"{path}, line {number}: taken for a header line without '#': {line!r}")
                continue
            raise InputError(
                f"{error}; expected a stamp and what belongs to it", path=path, location=f"line {number}"
            ) from error
        texts.append(" ".join(fields[1:]))
    return Rows(np.array(stamps, np.int64), tuple(texts), tuple(notes))


def read_positions(path: str | Path) -> Trajectory | None:
    """Read a text file of positions, `stamp x y z`, as `evaluate_ate.py` takes and saves them.

    Returns:
        Poses with zero quaternions, or None if the first row does not have four columns.

    Raises:
        InputError: A row is no position.

    """
    if not is_text(path) or _columns_of_first_row(path) != _POSITION_COLUMNS:
        return None
    rows = read_rows(path)
    positions = np.empty((len(rows.texts), 3))
    for row, text in enumerate(rows.texts):
        try:
            positions[row] = text.split(" ")
        except ValueError as error:
            raise InputError(
                f"the row of {format_stamp(int(rows.stamps[row]), 9)} is no position: {text!r}; "
                "expected 'timestamp tx ty tz'",
                path=path,
            ) from error
    return Trajectory(rows.stamps, positions, np.zeros((len(positions), 4)))


def _columns_of_first_row(path: str | Path) -> int:
    with Path(path).open(encoding="utf-8", errors="replace") as file:
        for line in file:
            if not line.startswith("#") and line.strip():
                return len([field for field in _SEPARATORS.split(line.strip()) if field])
    return 0
