# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What `--force` may replace: a file by a file, a folder with a sequence and nothing else by a folder."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Final

from tumtools.errors import InputError, UsageError
from tumtools.formats import registry

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

_HINT: Final = "name another target, or remove this one yourself"


def refuse_irreplaceable(target: Path, entry: registry.Format) -> None:
    """Refuse a target that is more than an older result of the same kind. A link is, and only it is replaced.

    Args:
        target: A file, a folder, or nothing.
        entry: The format to be written.

    Raises:
        UsageError: It is a folder and a file is written, or the other way round, or it is a folder with
            files that are no part of a sequence.

    """
    if target.is_symlink() or not target.exists():
        return
    if target.is_dir() != entry.makes_folder(target):
        is_one, gets_one = ("folder", "file") if target.is_dir() else ("file", "folder")
        raise UsageError(
            f"the target is a {is_one}, and a {gets_one} is to be written; it is not replaced",
            path=target,
            hint=_HINT,
        )
    if target.is_dir() and any(target.iterdir()):
        _refuse_foreign(target)


def _refuse_foreign(target: Path) -> None:
    try:
        own = set(_OWN_FILES[registry.detect(target).name](target))
    except InputError as error:
        raise UsageError(
            "the target is a folder that holds no sequence, or a damaged one; it is not replaced",
            path=target,
            hint=_HINT,
        ) from error
    foreign = min(set(_walk(target)) - own, default=None)
    if foreign is not None:
        raise UsageError(
            f"the target holds {foreign}, which is no part of its sequence; it is not replaced",
            path=target,
            hint=_HINT,
        )


def _walk(folder: Path) -> Iterator[str]:
    """Yield the name of everything that is no folder, relative, with `/`; links are not followed."""

    def fail(error: OSError) -> None:
        raise InputError(f"cannot read this folder: {error.strerror}", path=error.filename) from error

    for path, folders, names in os.walk(folder, onerror=fail):
        links = [name for name in folders if Path(path, name).is_symlink()]
        yield from (Path(path, name).relative_to(folder).as_posix() for name in [*names, *links])


def _tum_files(folder: Path) -> Iterator[str]:
    from tumtools.formats.tum.reader import TumSequence, open_tolerant  # noqa: PLC0415 - for its folders only

    with open_tolerant(folder) as sequence:
        if isinstance(sequence, TumSequence):
            yield from sequence.files.values()
            for names in sequence.names.values():
                yield from names


def _rawlog_files(folder: Path) -> Iterator[str]:
    from tumtools.formats.rawlog.externals import Folder  # noqa: PLC0415 - for its folders only
    from tumtools.formats.rawlog.signals import GROUNDTRUTH_FILE  # noqa: PLC0415 - as above
    from tumtools.formats.rawlog.survey import survey  # noqa: PLC0415 - as above

    yield GROUNDTRUTH_FILE
    for path in folder.glob("*.rawlog"):
        yield path.name
        images = Folder(path)
        for place in survey(path).places:
            if place.picture.file is not None and images.path is not None:
                yield Path(images.locate(place.picture.file)).relative_to(folder).as_posix()


def _rosbag2_files(folder: Path) -> Iterator[str]:
    from tumtools.formats.rosbag2.bag_info import FILE_NAME, read_bag_info  # noqa: PLC0415 - as above

    yield FILE_NAME
    for name in read_bag_info(folder / FILE_NAME).files:
        # As the reader looks for them: the first versions put the folder's own name before.
        for one in (name, Path(name).name):
            yield from (one, f"{one}.zstd")


_OWN_FILES: Final[dict[str, Callable[[Path], Iterator[str]]]] = {
    "tum": _tum_files,
    "rawlog": _rawlog_files,
    "rosbag2": _rosbag2_files,
}
"""Format of a folder -> the files that its sequence consists of."""
