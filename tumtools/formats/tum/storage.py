# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Where the files of a sequence lie: a folder or an archive, read without unpacking."""

from __future__ import annotations

import os
import posixpath
import stat
import zipfile
from abc import ABC, abstractmethod
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING, Final

from tumtools.errors import InputError, MissingInputError
from tumtools.formats.tum.members import check_name, check_size

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

LIST_FILES: Final = {
    "rgb.txt": "rgb",
    "depth.txt": "depth",
    "ir.txt": "ir",
    "groundtruth.txt": "groundtruth",
    "accelerometer.txt": "accelerometer",
    "imu.txt": "accelerometer",
}
"""The text files of a sequence and their streams; the paper calls the accelerometer's file imu.txt."""


_BESIDE: Final = "it lies beside the folder of the sequence in the archive"


class Storage(ABC):
    """The files of one sequence.

    Attributes:
        label: What to call it in messages.
        name: Base name of the folder that holds the files.
        files: Relative name, with `/` -> size in bytes.
        others: Relative name of what can be no file of the sequence -> why.
        sequential: Reading in another order than that of the archive is slow.

    """

    label: str
    name: str
    files: Mapping[str, int]
    others: Mapping[str, str] = {}
    sequential: bool = False

    @abstractmethod
    def read(self, name: str) -> bytes | memoryview:
        """Return a file; may be called from any thread.

        Raises:
            InputError: It is missing or damaged.

        """

    def read_head(self, name: str, size: int) -> bytes | memoryview:
        """Return the first bytes of a file.

        Raises:
            InputError: It is missing or damaged.

        """
        return self.read(name)[:size]

    def place(self, name: str) -> str:
        """Tell where a file is, for messages."""
        return f"{self.label}/{name}"

    def close(self) -> None:  # noqa: B027 - a folder holds nothing open
        """Release the archive."""


class Folder(Storage):
    """A folder on disk."""

    def __init__(self, path: Path) -> None:
        self.label = str(path)
        self.name = path.resolve().name
        self._path = path
        try:
            found = dict(_walk(path))
        except OSError as error:
            place = error.filename or path
            raise InputError(f"cannot read this folder: {error.strerror}", path=place) from error
        self.files = {name: size for name, size in found.items() if isinstance(size, int)}
        self.others = {name: why for name, why in found.items() if isinstance(why, str)}

    def read(self, name: str) -> bytes:
        """Return a file."""
        return self.read_head(name, -1)

    def read_head(self, name: str, size: int) -> bytes:
        """Return the first bytes of a file, all of it for -1."""
        try:
            check_size(self.files.get(name, 0), self.label, name)
            # Path takes as long as a small file.
            with open(f"{self._path}/{name}", "rb", buffering=0) as file:  # noqa: PTH123
                return file.read(size)
        except FileNotFoundError as error:
            raise MissingInputError("the file is missing", path=self.place(name)) from error
        except OSError as error:
            raise InputError(f"cannot read: {error.strerror}", path=self.place(name)) from error


def _walk(path: Path) -> Iterator[tuple[str, int | str]]:
    """Yield what is below a folder: the size of a file; why it is none of what is neither file nor folder.

    Links to folders are followed, but not to one that they lie in.
    """
    way = [_identity(path.stat())]
    levels = [("", _entries(str(path)))]
    while levels:
        prefix, entries = levels[-1]
        entry = next(entries, None)
        if entry is None:
            levels.pop()
            way.pop()
            continue
        name = prefix + entry.name
        try:
            is_folder, is_file = entry.is_dir(), entry.is_file()
        except OSError:
            is_folder = is_file = False  # a link to itself
        if is_folder and _identity(entry.stat()) in way:
            yield name, "a link to a folder that it lies in"
        elif is_folder:
            way.append(_identity(entry.stat()))
            levels.append((f"{name}/", _entries(entry.path)))
        elif is_file:
            yield name, entry.stat().st_size
        else:
            # Reading a pipe or a device might never end.
            nowhere = entry.is_symlink() and not Path(entry.path).exists()
            yield name, "a link that leads nowhere" if nowhere else "neither a file nor a folder"


def _entries(folder: str) -> Iterator[os.DirEntry[str]]:
    with os.scandir(folder) as entries:
        return iter(sorted(entries, key=lambda entry: entry.name))


def _identity(found: os.stat_result) -> tuple[int, int]:
    return found.st_dev, found.st_ino


class Zip(Storage):
    """A .zip archive; members are found through its directory."""

    def __init__(self, path: Path) -> None:
        self.label = str(path)
        try:
            self._archive = zipfile.ZipFile(path)
        except (zipfile.BadZipFile, OSError, ValueError) as error:
            raise InputError(f"not a readable .zip archive: {error}", path=path) from error
        self._lock = Lock()
        try:
            members = dict(self._list_members())
            root = find_root(members, self.label)
        except InputError:
            self._archive.close()
            raise
        self.name = root.rstrip("/").rpartition("/")[2] or path.stem
        self._members = {
            name.removeprefix(root): member for name, member in members.items() if name.startswith(root)
        }
        self.files = {name: member.file_size for name, member in self._members.items()}
        self.others = beside(members, root)

    def _list_members(self) -> Iterator[tuple[str, zipfile.ZipInfo]]:
        for member in self._archive.infolist():
            name = check_name(member.filename, self.label)
            check_size(member.file_size, self.label, member.filename)
            kind = stat.S_IFMT(member.external_attr >> 16)
            if kind not in {0, stat.S_IFREG, stat.S_IFDIR}:
                what = "a link" if kind == stat.S_IFLNK else "neither a file nor a folder"
                place = f"member {member.filename}"
                raise InputError(f"the member is {what}", path=self.label, location=place)
            if not member.is_dir():
                yield name, member

    def read(self, name: str) -> bytes:
        """Return a member, its CRC checked."""
        if name not in self._members:
            raise MissingInputError("the file is missing", path=self.label, location=f"member {name}")
        try:
            with self._lock, self._archive.open(self._members[name]) as member:
                data = member.read(self.files[name] + 1)
        except Exception as error:  # what zipfile, zlib, bz2 and lzma raise has no common base
            raise InputError(f"damaged: {error}", path=self.label, location=f"member {name}") from error
        if len(data) != self.files[name]:
            raise InputError(
                f"the member unpacks to {len(data)} bytes, the archive's directory says {self.files[name]}",
                path=self.label,
                location=f"member {name}",
            )
        return data

    def place(self, name: str) -> str:
        """Tell where a member is."""
        return f"{self.label}, member {name}"

    def close(self) -> None:
        """Close the archive."""
        self._archive.close()


def find_root(names: Iterable[str], archive: str) -> str:
    """Return the folder in an archive that holds the sequence, with `/` at the end, or an empty string.

    Raises:
        InputError: There is no sequence, or more than one.

    """
    roots = {}
    for name in names:
        folder, _, base = name.rpartition("/")
        if base in LIST_FILES:
            roots[f"{folder}/" if folder else ""] = name
    if not roots:
        wanted = ", ".join(LIST_FILES)
        raise InputError(f"no sequence in this archive: none of {wanted}", path=archive)
    shallowest = min(root.count("/") for root in roots)
    best = sorted(root for root in roots if root.count("/") == shallowest)
    if len(best) > 1:
        raise InputError(
            f"more than one sequence in this archive: {', '.join(best)}",
            path=archive,
            hint="unpack it and name one of the folders",
        )
    return best[0]


def beside(names: Iterable[str], root: str) -> dict[str, str]:
    """Return the files of an archive that are not in the folder of the sequence: relative name -> why."""
    # With / before them, so that the working folder is not asked for.
    return {posixpath.relpath(f"/{name}", f"/{root}"): _BESIDE for name in names if not name.startswith(root)}
