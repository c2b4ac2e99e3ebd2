# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Which sequences lie in a folder that is none itself."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from tumtools.errors import InputError
from tumtools.formats import registry

SUFFIXES: Final = (".bag", ".mcap", ".rawlog", ".tgz", ".tar", ".tar.gz", ".tar.zst", ".zip")
"""Files that are taken for recordings and archives of sequences."""
_MAX_DEPTH: Final = 4


def discover(source: str) -> list[str]:
    """Return the sources that are meant: the source itself, or all sequences in a folder that is none.

    Folders are searched to a depth of four, but not below a sequence; hidden ones are left out. If
    nothing is found, the source itself is returned, so that it is reported as what it is.

    Args:
        source: A path or a catalogue name.

    """
    path = Path(source)
    if not source or not path.is_dir() or _is_sequence(path):
        return [source]
    return [str(found) for found in _below(path, _MAX_DEPTH)] or [source]


def _below(folder: Path, depth: int) -> list[Path]:
    found: list[Path] = []
    for path in sorted(folder.iterdir()):
        if path.name.startswith("."):
            continue
        if path.is_dir():
            if _is_sequence(path):
                found.append(path)
            elif depth > 1:
                found.extend(_below(path, depth - 1))
        elif path.name.endswith(SUFFIXES):
            found.append(path)
    return found


def _is_sequence(folder: Path) -> bool:
    try:
        registry.detect(folder)
    except InputError:
        return False
    return True
