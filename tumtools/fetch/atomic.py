# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Small files that are replaced as a whole, and locks that end with their process."""

from __future__ import annotations

import fcntl
import os
import tempfile
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from tumtools.errors import OutputError
from tumtools.staging import fsync

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


def write_text(path: Path, text: str) -> None:
    """Write a file under its final name at once, or leave the old one.

    Raises:
        OutputError: It cannot be written.

    """
    temporary: Path | None = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(
            "w", encoding="utf-8", dir=path.parent, prefix=f".{path.name}.", suffix=".tmp", delete=False
        ) as file:
            temporary = Path(file.name)
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        temporary.chmod(0o644)
        temporary.replace(path)
        fsync(path.parent)
    except OSError as error:
        if temporary is not None:
            temporary.unlink(missing_ok=True)
        raise OutputError(f"cannot be written: {error.strerror}", path=path) from error


class BusyError(OutputError):
    """Another process works on it."""


@contextmanager
def exclusive(path: Path, on_wait: Callable[[], None] | None = None, *, wait: bool = True) -> Iterator[None]:
    """Hold the lock of a file or folder; the system releases it when the process ends, however it ends.

    Args:
        path: An existing folder, or a file that is made if need be (and stays).
        on_wait: Called once if somebody else holds the lock.
        wait: Whether to wait in that case.

    Raises:
        BusyError: Somebody else holds it, and `wait` is false.
        OutputError: It cannot be opened.

    """
    try:
        if path.is_dir():
            descriptor = os.open(path, os.O_RDONLY | os.O_DIRECTORY)
        else:
            path.parent.mkdir(parents=True, exist_ok=True)
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
    except OSError as error:
        raise OutputError(
            f"cannot be locked: {error.strerror}",
            path=path,
            hint="TUMTOOLS_CACHE names another folder for the cache, --dest one for this download",
        ) from error
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if not wait:
                raise BusyError("another process works on it; try again later", path=path) from None
            if on_wait is not None:
                on_wait()
            fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)
