# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Open any source: a path in any format, or the name of a sequence of the catalogue."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from tumtools.formats import registry
from tumtools.formats.options import ReadOptions

if TYPE_CHECKING:
    from tumtools.model.sequence import Sequence


def locate(source: str | Path) -> Path:
    """Return the path of a source.

    Raises:
        MissingInputError: There is nothing of that name.

    """
    return Path(source)


def open_source(source: str | Path, options: ReadOptions | None = None) -> Sequence:
    """Open a source for reading.

    Args:
        source: A path in any format, or a catalogue name.
        options: How to read it.

    Raises:
        InputError: It is missing, damaged, or of no known format.

    """
    path = locate(source)
    return registry.detect(path).reader.open(path, options or ReadOptions())
