# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Folders for files on their way; what a killed process left is removed by the next."""

from __future__ import annotations

import fcntl
import os
import shutil
import tempfile
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Final

from tumtools.errors import OutputError
from tumtools.fetch.atomic import exclusive

if TYPE_CHECKING:
    from collections.abc import Iterator

_PREFIX: Final = "tumtools-batch-"


@contextmanager
def scratch_folder(parent: Path | None) -> Iterator[Path]:
    """Give a new folder for the time of the block.

    Args:
        parent: Where to make it; None for the system's folder of temporary files.

    Raises:
        OutputError: It cannot be made.

    """
    parent = parent or Path(tempfile.gettempdir())
    try:
        parent.mkdir(parents=True, exist_ok=True)
        with exclusive(parent):  # or else a folder could be taken for a left one before it is locked
            _remove_left(parent)
            folder = Path(tempfile.mkdtemp(prefix=_PREFIX, dir=parent))
            lock = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
            fcntl.flock(lock, fcntl.LOCK_EX)
    except OSError as error:
        raise OutputError(f"no scratch folder: {error.strerror or error}", path=parent) from error
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        os.close(lock)


def _remove_left(parent: Path) -> None:
    for folder in parent.glob(f"{_PREFIX}*"):
        try:
            lock = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
        except OSError:
            continue  # somebody else's, or gone by now
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            shutil.rmtree(folder, ignore_errors=True)
        except BlockingIOError:
            continue
        finally:
            os.close(lock)
