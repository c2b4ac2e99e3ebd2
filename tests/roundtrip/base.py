# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The sequence that goes through the matrix, in every format."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Final

from tumtools.convert import ConvertOptions, convert
from tumtools.sources import open_source

if TYPE_CHECKING:
    from tests.roundtrip.variants import Variant

FIXTURE: Final = Path(__file__).parents[2] / "fixtures" / "full"
ROWS: Final = {"accelerometer.txt": 40, "groundtruth.txt": 12}
"""Rows of the signals that are kept, as the matrix has many cells."""
HEADER_LINES: Final = 3


def make_base(folder: Path) -> Path:
    """Write the sequence in the benchmark's layout: four images of each kind at 64x48, and a few rows."""
    target = folder / "sequence"
    shutil.copytree(FIXTURE, target)
    for name, rows in ROWS.items():
        lines = (FIXTURE / name).read_text().splitlines(keepends=True)
        step = (len(lines) - HEADER_LINES) // rows
        (target / name).write_text("".join(lines[:HEADER_LINES] + lines[HEADER_LINES::step][:rows]))
    return target


class Sources:
    """The sequence as each variant writes it, made once.

    Args:
        base: In the benchmark's layout.
        folder: Where to write.

    """

    def __init__(self, base: Path, folder: Path) -> None:
        self._base = base
        self._folder = folder
        self._made: dict[str, Path] = {"tum": base}

    def __getitem__(self, variant: Variant) -> Path:
        name = str(variant)
        if name not in self._made:
            target = self._folder / str(len(self._made)) / f"sequence{variant.suffix}"
            with open_source(self._base) as sequence:
                options = ConvertOptions(verify=False)
                convert(sequence, target, variant.format, variant.write_options, options)
            self._made[name] = target
        return self._made[name]
