# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Folders for files on their way; what a killed process left is removed by the next."""

from __future__ import annotations

import errno
import fcntl
import os
import shutil
import tempfile
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Final

from tumtools.errors import OutputError, TumtoolsError
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
        raise OutputError(
            f"no scratch folder: {_words(error)}", path=parent, hint="name another folder with --scratch"
        ) from error
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        os.close(lock)


def check_scratch(parent: Path) -> None:
    """See that a scratch folder can be written to, and make it if need be.

    Raises:
        OutputError: It cannot.

    """
    with scratch_folder(parent):
        pass


@contextmanager
def scratch_errors(path: Path) -> Iterator[None]:
    """Name the scratch folder that a file is in where the block fails because it is full or not writable."""
    try:
        yield
    except OSError as error:
        cause = error.__cause__ if isinstance(error, TumtoolsError) else error
        full = isinstance(cause, OSError) and cause.errno in {errno.ENOSPC, errno.EDQUOT}
        if isinstance(error, TumtoolsError) and not full:
            raise
        parents = (folder.parent for folder in path.parents if folder.name.startswith(_PREFIX))
        raise OutputError(
            "the scratch folder is full" if full else f"the scratch folder: {_words(error)}",
            path=next(parents, path.parent),
            hint="free some space there, or name another folder with --scratch",
        ) from error


def _words(error: OSError) -> str:
    """Say what the system said, which an error of ours has as its cause."""
    cause = error.__cause__ if isinstance(error.__cause__, OSError) else error
    return cause.strerror or str(error).partition("\n")[0]


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
