# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Files and folders as one: how large, whether changed, and their hash."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tumtools.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from pathlib import Path


@dataclass(frozen=True, slots=True)
class Measure:
    """What is known of a file or folder without reading it.

    Attributes:
        files: How many.
        bytes: Their size.
        fingerprint: Hash of names, sizes, and times or ETags; equal means unchanged.

    """

    files: int
    bytes: int
    fingerprint: str


def measure(path: Path) -> Measure | None:
    """Look at a file or folder without reading it; None if there is none.

    Raises:
        InputError: It cannot be looked at.

    """
    try:
        if not os.path.lexists(path):
            return None
        return summary((name, file.stat().st_size, str(file.stat().st_mtime_ns)) for name, file in walk(path))
    except OSError as error:
        raise InputError(f"cannot be looked at: {error.strerror}", path=path) from error


def summary(files: Iterable[tuple[str, int, str]]) -> Measure:
    """Sum up files given as name, size and something that changes with the content."""
    sha = hashlib.sha256()
    count = total = 0
    for name, size, mark in files:
        sha.update(f"{size} {mark} {name}\n".encode("utf-8", "surrogateescape"))
        count += 1
        total += size
    return Measure(count, total, sha.hexdigest()[:32])


def sha256_of(path: Path) -> str:
    """Return the SHA-256 of a file; of a folder, that of the lines `sha256sum` prints, sorted by name.

    Raises:
        InputError: It cannot be read.

    """
    try:
        if path.is_file():
            return _file_sha256(path)
        return sha256_of_listing((name, _file_sha256(file)) for name, file in walk(path))
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", path=path) from error


def sha256_of_listing(files: Iterable[tuple[str, str]]) -> str:
    """Return the SHA-256 of a folder from those of its files, which are given sorted by name."""
    sha = hashlib.sha256()
    for name, value in files:
        sha.update(f"{value}  {name}\n".encode("utf-8", "surrogateescape"))
    return sha.hexdigest()


def walk(path: Path) -> Iterator[tuple[str, Path]]:
    """Yield the files of a folder with their relative names, sorted; or a file itself, without a name."""
    if not path.is_dir():
        yield "", path
        return
    files = (file for file in path.rglob("*") if not file.is_dir())
    yield from sorted(((file.relative_to(path).as_posix(), file) for file in files), key=lambda item: item[0])


def _file_sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
