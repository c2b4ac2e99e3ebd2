# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Archives of a folder in every container and in any order of members."""

from __future__ import annotations

import gzip
import io
import random
import tarfile
import zipfile
from typing import TYPE_CHECKING, Final

import zstandard

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from pathlib import Path

SUFFIXES: Final = (".tgz", ".tar", ".tar.zst", ".zip")
Member = tuple[tarfile.TarInfo, bytes]


def _published(names: list[str]) -> list[str]:
    """Lists first, then colour and depth in order of time, as in the archives of the benchmark."""
    return sorted(names, key=lambda name: ("/" in name, name.rpartition("/")[2]))


def _shuffled(names: list[str]) -> list[str]:
    return random.Random(7).sample(sorted(names), len(names))


ORDERS: Final[dict[str, Callable[[list[str]], list[str]]]] = {
    "published": _published,
    "alphabetical": sorted,
    "reversed": lambda names: sorted(names, reverse=True),
    "random": _shuffled,
}


def files_of(folder: Path) -> dict[str, bytes]:
    """Return the files of a folder by their relative names."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def file(name: str, data: bytes = b"") -> Member:
    """Return a regular member of a tar archive."""
    member = tarfile.TarInfo(name)
    member.size = len(data)
    return member, data


def tar(members: Iterable[Member]) -> bytes:
    """Return a tar archive."""
    target = io.BytesIO()
    with tarfile.open(fileobj=target, mode="w") as archive:
        for member, data in members:
            archive.addfile(member, io.BytesIO(data))
    return target.getvalue()


def pack(folder: Path, target: Path, order: str = "published") -> Path:
    """Pack a folder; the suffix of the target decides how."""
    files = files_of(folder)
    names = ORDERS[order](list(files))
    if target.suffix == ".zip":
        with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
            for name in names:
                archive.writestr(f"{folder.name}/{name}", files[name])
        return target
    data = tar(file(f"{folder.name}/{name}", files[name]) for name in names)
    compress: Callable[[bytes], bytes] = {
        ".tgz": gzip.compress,
        ".zst": zstandard.ZstdCompressor(write_checksum=True).compress,
        ".tar": bytes,
    }[target.suffix]
    target.write_bytes(compress(data))
    return target
