# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Open any source: a path in any format, or the name of a sequence of the catalogue."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from tumtools.errors import MissingInputError
from tumtools.formats import registry
from tumtools.formats.options import ReadOptions

if TYPE_CHECKING:
    from tumtools.model.sequence import Sequence


def locate(source: str | Path) -> Path:
    """Return the path of a source: a file or folder of this name, or else what the cache has.

    Raises:
        MissingInputError: There is nothing of that name; the hint says how to get it.

    """
    if not str(source):
        raise MissingInputError("the name of the source is empty", hint="is a variable of a script not set?")
    path = Path(source)
    if isinstance(source, Path) or os.path.lexists(path):
        return path
    # Only now: a path needs no catalogue.
    from tumtools.fetch.locate import locate_name  # noqa: PLC0415

    return locate_name(source)


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
