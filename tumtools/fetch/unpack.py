# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Unpack an archive, streaming, into a staging folder: only safe members, no bombs, each file hashed."""

from __future__ import annotations

import gzip
import hashlib
import shutil
import tarfile
import zipfile
import zlib
from dataclasses import dataclass, field
from functools import partial
from typing import IO, TYPE_CHECKING, Final, Protocol, cast

import zstandard
from isal import igzip, isal_zlib

from tumtools.errors import InputError, OutputError
from tumtools.formats.tum.headers import StrictTarInfo, check_end
from tumtools.formats.tum.members import check_name, check_size, check_tar_member

if TYPE_CHECKING:
    from io import FileIO
    from pathlib import Path

BOMB_RATIO: Final = 20
"""Archives of sequences hold PNG files and unpack to 1.1 times their size."""
BOMB_FLOOR: Final = 64 << 20
"""Below so many unpacked bytes no ratio is suspicious."""
_MAX_HEADER: Final = 1 << 20
"""tarfile holds extended headers in memory."""
_COPY: Final = 1 << 18
_BAD: Final[tuple[type[Exception], ...]] = (
    tarfile.TarError,
    gzip.BadGzipFile,
    zlib.error,
    cast("type[Exception]", isal_zlib.error),  # isal has no types
    zstandard.ZstdError,
    zipfile.BadZipFile,
    EOFError,
    NotImplementedError,  # a compression of zip that is not there
    RuntimeError,  # an encrypted zip
)
_HEADERS: Final = (
    tarfile.XHDTYPE,
    tarfile.XGLTYPE,
    tarfile.SOLARIS_XHDTYPE,
    tarfile.GNUTYPE_LONGNAME,
    tarfile.GNUTYPE_LONGLINK,
)


class Source(Protocol):
    """Bytes of an archive that come one after the other."""

    @property
    def position(self) -> int:
        """Bytes that have been read."""

    def read(self, size: int = -1) -> bytes:
        """Return the next bytes, none at the end."""

    def readinto(self, buffer: bytearray | memoryview) -> int:
        """Fill a buffer with the next bytes; 0 at the end."""


@dataclass(slots=True)
class Unpacked:
    """What has been unpacked.

    Attributes:
        folder: Where; None if it was only checked.
        files: Relative name with `/` -> (bytes, sha256).
        nbytes: Bytes of all files.

    """

    folder: Path | None
    files: dict[str, tuple[int, str]] = field(default_factory=dict)
    nbytes: int = 0


class _LimitedInfo(StrictTarInfo):
    """Refuses extended headers that would fill the memory."""

    def _proc_member(self, archive: tarfile.TarFile) -> tarfile.TarInfo:
        if self.type in _HEADERS and self.size > _MAX_HEADER:
            msg = f"an extended header of {self.size} bytes"
            raise tarfile.ReadError(msg)
        member: tarfile.TarInfo = super()._proc_member(archive)  # type: ignore[misc]  # documented in tarfile.py as the method to override
        return member


class _Inflated:
    """The uncompressed stream; raises when there is too much of it."""

    def __init__(self, stream: IO[bytes] | Source, source: Source, label: str) -> None:
        self._stream = stream
        self._source = source
        self._label = label
        self.position = 0

    def read(self, size: int = -1) -> bytes:
        data = self._stream.read(size)
        self.position += len(data)
        check_ratio(self.position, self._source.position, self._label)
        return data


def check_ratio(unpacked: int, packed: int, label: str) -> None:
    """Refuse an archive that unpacks to absurdly much.

    Raises:
        InputError: It does.

    """
    if unpacked > BOMB_FLOOR and unpacked > BOMB_RATIO * packed:
        raise InputError(
            f"{packed} bytes unpack to more than {unpacked}: a decompression bomb (a sequence unpacks to "
            "about as much as it has)",
            path=label,
            hint="do not use this archive; get it again from a source that you trust",
        )


def unpack_tar(source: Source, kind: str, folder: Path | None, label: str) -> Unpacked:
    """Unpack a tar archive that is read from its beginning to its end.

    Args:
        source: The archive.
        kind: `tgz`, `tar` or `tar.zst`.
        folder: New folder for its content; None to check it only.
        label: What to call the archive in messages.

    Raises:
        InputError: It is damaged or not safe.
        OutputError: It cannot be written.

    """
    result = _start(folder)
    stream = _Inflated(_inflate(source, kind), source, label)
    last = "the beginning"
    try:
        with tarfile.open(
            fileobj=cast("IO[bytes]", stream), mode="r|", bufsize=_COPY, tarinfo=_LimitedInfo
        ) as archive:
            for member in archive:
                archive.members = []  # type: ignore[attr-defined]  # they would all be kept
                last = f"member {member.name}"
                name = check_tar_member(member, label)
                if member.isfile():
                    content = archive.extractfile(member)
                    _write(result, name, cast("IO[bytes]", content), member.size, label)
                else:
                    _make_folder(result, name, label)
            # To the end: the checksum of gzip is there.
            tail = cast("IO[bytes]", archive.fileobj)
            check_end(tail.read, tail.tell())
    except _BAD as error:
        raise InputError(
            f"the archive is damaged or cut off: {error}", path=label, location=f"after {last}"
        ) from error
    return result


def unpack_zip(path: Path, folder: Path | None, label: str) -> Unpacked:
    """Unpack a zip archive; the same rules as for tar. To check it only, its directory is read."""
    result = _start(folder)
    last = "the beginning"
    try:
        with zipfile.ZipFile(path) as archive:
            for member in archive.infolist():
                last = f"member {member.filename}"
                name = check_name(member.filename, label)
                check_size(member.file_size, label, member.filename)
                if (member.external_attr >> 28) == 0o12:  # noqa: PLR2004 - S_IFLNK >> 12
                    raise InputError("the member is a link", path=label, location=last)
                check_ratio(result.nbytes + member.file_size, path.stat().st_size, label)
                if member.is_dir():
                    _make_folder(result, name, label)
                elif folder is not None:
                    with archive.open(member) as content:
                        _write(result, name, content, member.file_size, label)
    except _BAD as error:
        raise InputError(
            f"the archive is damaged or cut off: {error}", path=label, location=f"after {last}"
        ) from error
    return result


def content_root(unpacked: Unpacked) -> tuple[Path, dict[str, tuple[int, str]]]:
    """Return the folder that holds the content, and the files by their names relative to it.

    It is the only folder at the top, as in archives of the benchmark, or else the top itself.
    """
    folder = cast("Path", unpacked.folder)
    entries = list(folder.iterdir())
    if len(entries) != 1 or not entries[0].is_dir():
        return folder, unpacked.files
    prefix = f"{entries[0].name}/"
    return entries[0], {name.removeprefix(prefix): facts for name, facts in unpacked.files.items()}


def _inflate(source: Source, kind: str) -> IO[bytes] | Source:
    if kind == "tgz":
        return cast("IO[bytes]", igzip.IGzipFile(fileobj=source, mode="rb"))  # type: ignore[no-untyped-call]  # isal has no types
    if kind == "tar.zst":
        return cast(
            "IO[bytes]",
            zstandard.ZstdDecompressor().stream_reader(cast("IO[bytes]", source), read_across_frames=True),
        )
    return source


def _start(folder: Path | None) -> Unpacked:
    try:
        if folder is not None:
            if folder.exists():
                shutil.rmtree(folder)
            folder.mkdir(parents=True)
    except OSError as error:
        raise OutputError(f"cannot be made: {error.strerror}", path=folder) from error
    return Unpacked(folder)


def _make_folder(result: Unpacked, name: str, label: str) -> None:
    try:
        if result.folder is not None:
            (result.folder / name).mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError) as error:
        raise InputError(
            "the name is a file and a folder at once", path=label, location=f"member {name}"
        ) from error
    except OSError as error:
        raise _not_written(name, label, error) from error


def _write(result: Unpacked, name: str, content: IO[bytes], size: int, label: str) -> None:
    if name in result.files:
        raise InputError("the name occurs twice", path=label, location=f"member {name}")
    if result.folder is None:
        result.files[name] = (size, "")
        return
    digest = hashlib.sha256()
    count = 0
    with _create(result.folder / name, name, label) as file:
        for block in iter(partial(content.read, _COPY), b""):
            digest.update(block)
            view = memoryview(block)
            while view:
                try:
                    view = view[file.write(view) :]
                except OSError as error:
                    raise _not_written(name, label, error) from error
            count += len(block)
    if count != size:
        raise InputError(f"{count} of {size} bytes are there", path=label, location=f"member {name}")
    result.files[name] = (count, digest.hexdigest())
    result.nbytes += count


def _create(target: Path, name: str, label: str) -> FileIO:
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        return target.open("wb", buffering=0)
    except (FileExistsError, NotADirectoryError, IsADirectoryError) as error:
        raise InputError(
            "the name is a file and a folder at once", path=label, location=f"member {name}"
        ) from error
    except OSError as error:
        raise _not_written(name, label, error) from error


def _not_written(name: str, label: str, error: OSError) -> OutputError:
    return OutputError(
        f"cannot be unpacked: {error.strerror or error}",
        path=label,
        location=f"member {name}",
        hint="make room and run the same command again; what has been downloaded is kept",
    )
