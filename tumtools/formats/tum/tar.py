# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
""".tar, .tar.gz (.tgz) and .tar.zst archives, read without unpacking them.

One pass lists the members and keeps the text files. Images are then read at their offsets.
"""

from __future__ import annotations

import tarfile
from contextlib import suppress
from typing import TYPE_CHECKING, Final, Protocol

from tumtools.errors import InputError, MissingInputError
from tumtools.formats.tum.headers import DAMAGED_HINT, StrictTarInfo, check_end
from tumtools.formats.tum.inflate import GZIP_MAGIC, ZSTD_MAGIC, RandomAccess, SeekableStream
from tumtools.formats.tum.members import MAX_MEMBER_BYTES, check_tar_member
from tumtools.formats.tum.spool import NoRoomError, SpooledStream
from tumtools.formats.tum.storage import LIST_FILES, Storage, beside, find_root

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

_BLOCK: Final = 512
_MAX_HEADER_BYTES: Final = 1 << 20
"""Long names and such take a few hundred bytes."""


class _Bytes(Protocol):
    """Forward scan and random access over the bytes of a tar file."""

    @property
    def scanned(self) -> int: ...
    def scan(self, size: int) -> bytes: ...
    def skip_scan(self, position: int) -> None: ...
    def read_at(self, offset: int, size: int) -> bytes: ...
    def close(self) -> None: ...


class _Plain:
    """An uncompressed tar file."""

    def __init__(self, path: Path) -> None:
        self._file = RandomAccess(path)
        self.scanned = 0

    def scan(self, size: int) -> bytes:
        data = self._file.read_at(self.scanned, size)
        self.scanned += len(data)
        return data

    def skip_scan(self, position: int) -> None:
        self.scanned = min(position, self._file.size)

    def read_at(self, offset: int, size: int) -> bytes:
        return self._file.read_at(offset, size)

    def close(self) -> None:
        self._file.close()


class _ScanFile:
    """The first pass as the file object that `tarfile` reads headers from."""

    def __init__(self, source: _Bytes) -> None:
        self._source = source

    def read(self, size: int) -> bytes:
        if size > _MAX_HEADER_BYTES:
            raise InputError(f"a header of {size} bytes", location=f"offset {self._source.scanned} unpacked")
        return self._source.scan(size)

    def tell(self) -> int:
        return self._source.scanned

    def seek(self, position: int) -> None:
        if position < self._source.scanned:  # a size below zero
            raise InputError("the archive's headers point backward")
        self._source.skip_scan(position)


class Tar(Storage):
    """A tar archive, compressed or not.

    Args:
        path: The archive.
        scratch: Folder for a temporary file that a compressed archive is inflated to, which is fastest;
            without a folder, or room in it, images are inflated again where they are read.

    """

    def __init__(self, path: Path, scratch: Path | None = None) -> None:
        self.label = str(path)
        with path.open("rb") as file:
            magic = file.read(4)
        compressed = magic[:2] == GZIP_MAGIC or magic == ZSTD_MAGIC
        self._texts: dict[str, bytes] = {}
        members = None
        if compressed and scratch is not None:
            with suppress(NoRoomError):
                members = self._open(SpooledStream(path, scratch))
        self.sequential = compressed and members is None
        if members is None:
            members = self._open(SeekableStream(path) if compressed else _Plain(path))
        root = find_root(members, self.label)
        self.name = root.rstrip("/").rpartition("/")[2] or path.name.split(".")[0]
        self._places = {
            name.removeprefix(root): place for name, place in members.items() if name.startswith(root)
        }
        self._texts = {name.removeprefix(root): text for name, text in self._texts.items()}
        self.files = {name: size for name, (_, size) in self._places.items()}
        self.others = beside(members, root)

    def _open(self, source: _Bytes) -> dict[str, tuple[int, int]]:
        """Take the bytes and list the members; offset and size of each."""
        self._bytes = source
        self._texts.clear()
        try:
            members = dict(self._list_members())
            find_root(members, self.label)
        except BaseException:
            self.close()
            raise
        return members

    def _list_members(self) -> Iterator[tuple[str, tuple[int, int]]]:
        """Yield name, offset and size of each file; text files are kept on the way."""
        last = "its beginning"
        kept = 0
        try:
            archive = tarfile.TarFile(fileobj=_ScanFile(self._bytes), tarinfo=StrictTarInfo)  # type: ignore[arg-type]  # it only reads
            while (member := archive.next()) is not None:
                archive.members.clear()  # type: ignore[attr-defined]  # they would all be kept in memory
                name = check_tar_member(member, self.label)
                last = f"member {member.name}"
                if member.isfile():
                    is_text = name.rpartition("/")[2] in LIST_FILES and kept + member.size <= MAX_MEMBER_BYTES
                    kept += member.size if is_text else 0
                    self._pass_over(member, name if is_text else None)
                    yield name, (member.offset_data, member.size)
            check_end(self._bytes.scan, self._bytes.scanned)
        except InputError as error:
            if error.location and error.location.startswith("member"):
                raise
            place = ", ".join(part for part in (error.location, f"after {last}") if part)
            raise InputError(error.message, path=self.label, location=place, hint=error.hint) from error
        except (tarfile.TarError, ValueError, RecursionError) as error:
            message = f"not a readable tar archive: {error}"
            raise InputError(message, path=self.label, location=f"after {last}", hint=DAMAGED_HINT) from error

    def _pass_over(self, member: tarfile.TarInfo, name: str | None) -> None:
        """Move the first pass to the end of a member; its text is kept if a name is given for it."""
        # The last byte is left to tarfile, which reads it to see that it is there.
        end = member.offset_data + -(-member.size // _BLOCK) * _BLOCK - 1
        if name is not None:
            self._bytes.skip_scan(member.offset_data)
            self._texts[name] = self._bytes.scan(member.size)
        self._bytes.skip_scan(end)
        if self._bytes.scanned < end:
            raise InputError(
                f"the archive ends inside of this member, {end + 1 - self._bytes.scanned} bytes are missing",
                path=self.label,
                location=f"member {member.name}",
                hint="the file was cut off; get it again",
            )

    def read(self, name: str) -> bytes:
        """Return a member."""
        if name in self._texts:
            return self._texts[name]
        if name not in self._places:
            raise MissingInputError("the file is missing", path=self.label, location=f"member {name}")
        offset, size = self._places[name]
        data = self._bytes.read_at(offset, size)
        if len(data) != size:
            raise InputError(
                f"{len(data)} of {size} bytes are there", path=self.label, location=f"member {name}"
            )
        return data

    def place(self, name: str) -> str:
        """Tell where a member is."""
        return f"{self.label}, member {name}"

    def close(self) -> None:
        """Release the archive."""
        self._bytes.close()
