# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A file that has its final name is complete: stage beside the target, flush, fsync, rename.

The work is done in a hidden folder beside the target, which holds a locked file while its process lives.
What a killed process left there is removed by the next one that writes the same target.
"""

from __future__ import annotations

import errno
import fcntl
import os
import shutil
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, suppress
from typing import IO, TYPE_CHECKING, Final

from tumtools.errors import OutputError, TumtoolsError, UsageError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

_LOCK: Final = ".tumtools-lock"
_OLD: Final = ".tumtools-old"
_FSYNC_THREADS: Final = 8


@contextmanager
def staged(target: Path, *, force: bool = False) -> Iterator[Path]:
    """Give a path to write to; when the block ends well, it is the target.

    Args:
        target: A file or a folder. The path given has the same base name and does not exist yet.
        force: Replace the file or folder that is there.

    Raises:
        UsageError: The target exists, or is neither a file nor a folder.
        OutputError: It cannot be written.

    """
    refuse_existing(target, force=force)
    folder = _new_name(target)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        remove_stale(target)
        while (lock := _make_locked(folder)) is None:
            folder = _new_name(target)
        with lock:
            path = folder / target.name
            yield path
            fsync_tree(path)
            _move_into_place(path, target, force=force)
    except TumtoolsError:
        raise
    except OSError as error:
        raise output_error(error, target) from error
    finally:
        shutil.rmtree(folder, ignore_errors=True)


@contextmanager
def staged_file(target: Path, *, force: bool = False) -> Iterator[Path]:
    """Give a path to write a file to, as `staged`; a folder that is there is never replaced by it.

    Raises:
        UsageError: The target exists, or is no file.
        OutputError: It cannot be written.

    """
    refuse_folder(target)
    with staged(target, force=force) as path:
        yield path
        refuse_folder(target)


def refuse_folder(target: Path) -> None:
    """Refuse a folder where a file is to be written.

    Raises:
        UsageError: It is a folder.

    """
    if target.is_dir():
        raise UsageError("this is a folder; a file is to be written", path=target, hint="name a file in it")


def _new_name(target: Path) -> Path:
    # Known before the folder is made, so that it is removed wherever an interrupt comes in between.
    return target.parent / f"{_prefix(target)}{os.urandom(8).hex()}"


def _make_locked(folder: Path) -> IO[str] | None:
    """Make a folder with its locked file; None if another process took it for stale before it was locked."""
    folder.mkdir(mode=0o700)
    with ExitStack() as stack:
        try:
            lock = stack.enter_context((folder / _LOCK).open("a"))
        except FileNotFoundError:
            return None
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not _is_same_file(lock, folder / _LOCK):
            return None
        stack.pop_all()
        return lock


def _is_same_file(file: IO[str], path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(file.fileno()), path.stat())
    except FileNotFoundError:
        return False


def refuse_existing(target: Path, *, force: bool) -> None:
    """Refuse a target that exists, unless it may be replaced; devices and the like never are.

    Nor are links to them: `/dev/stdout` is one.

    Raises:
        UsageError: It exists.

    """
    if target.exists() and not (target.is_file() or target.is_dir()):
        raise UsageError(
            "the target is neither a file nor a folder", path=target, hint="name a file or folder to make"
        )
    if os.path.lexists(target) and not force:
        raise UsageError(
            "the target exists", path=target, hint="name another one, or replace it with --force"
        )


def output_error(error: OSError, target: Path) -> OutputError:
    """Say in words why a target cannot be written."""
    if error.errno in {errno.EEXIST, errno.ENOTDIR}:
        for parent in target.parents:
            if os.path.lexists(parent) and not parent.is_dir():
                return OutputError(
                    f"cannot write {target.name} below it: this is no folder",
                    path=parent,
                    hint="move it away, or name another target",
                )
    hint = None
    if error.errno in {errno.ENOSPC, errno.EDQUOT}:
        hint = "free some space or name a target on another disk; nothing was left behind"
    return OutputError(f"cannot write: {error.strerror or error}", path=target, hint=hint)


def _prefix(target: Path) -> str:
    return f".{target.name}.tumtools-"


def remove_stale(target: Path) -> None:
    """Remove the staging folders of processes that were killed."""
    prefix = _prefix(target)
    for name in os.listdir(target.parent):  # noqa: PTH208 - names only: there may be a million outputs
        if name.startswith(prefix) and (folder := target.parent / name).is_dir():
            # Locked while it is removed, so that its owner, if it is just starting, sees that it has gone.
            # Folders that are in use or other people's stay.
            with suppress(OSError), (folder / _LOCK).open("a") as lock:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                shutil.rmtree(folder, ignore_errors=True)


def fsync_tree(path: Path) -> None:
    """Bring a file, or all of a folder, to the disk."""
    if not path.is_dir():
        fsync(path)
        return
    folders: list[str] = []
    files: list[str] = []
    for name, _, names in os.walk(path):
        folders.append(name)
        files.extend(f"{name}/{file}" for file in names)
    # A thread has many files: to hand one over takes longer than to find it on the disk already.
    shares = [files[number::_FSYNC_THREADS] for number in range(_FSYNC_THREADS)]
    with ThreadPoolExecutor(_FSYNC_THREADS) as pool:
        list(pool.map(_fsync_all, shares))
    for folder in reversed(folders):
        fsync(folder)


def _fsync_all(files: list[str]) -> None:
    for file in files:
        fsync(file)


def fsync(path: str | Path) -> None:
    """Bring a file, or the names in a folder, to the disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _move_into_place(path: Path, target: Path, *, force: bool) -> None:
    refuse_existing(target, force=force)
    if os.path.lexists(target) and (path.is_dir() or target.is_dir()):
        _swap(path, target)
    else:
        path.rename(target)
    fsync(target.parent)


def _swap(path: Path, target: Path) -> None:
    """Replace where one of the two is a folder, which takes two steps; the old one goes with the staging."""
    old = path.parent / _OLD
    try:
        target.rename(old)
        path.rename(target)
    except BaseException:
        if not os.path.lexists(target):
            old.rename(target)
        raise
