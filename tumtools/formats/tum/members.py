# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Which members of an archive are safe to look at."""

from __future__ import annotations

from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Final

from tumtools.errors import InputError
from tumtools.model.text import TITLES

if TYPE_CHECKING:
    import tarfile

MAX_MEMBER_BYTES: Final = 1 << 28
"""An image or text file of 256 MiB is none of the benchmark's; it would fill the memory."""
_TEXT_FILES: Final = {f"{stream}.txt" for stream in TITLES} | {"imu.txt"}


def check_name(name: str, archive: str) -> str:
    """Return the normalised name of a member: relative, with `/`, without `.` parts.

    Raises:
        InputError: The name is absolute or leads out of the archive's folder.

    """
    if "\0" in name:
        raise InputError("a file name with a zero byte", path=archive, location=f"member {name!r}")
    parts = _parts(name)
    if _leads_outside(name, parts):
        raise InputError(
            "the member's name leads outside of the archive",
            path=archive,
            location=f"member {name}",
            hint="do not unpack this archive; get it again from a source that you trust",
        )
    return str(PurePosixPath(*parts)) if parts else "."


def check_listed_name(name: str, place: str, line: str | None = None) -> str:
    """Return the normalised name of an image that a list names; see `check_name`.

    Raises:
        InputError: The name is absolute or leads out of the folder of the sequence.

    """
    parts = _parts(name)
    if "\0" in name or _leads_outside(name, parts):
        raise InputError(
            f"the image name {name} leads outside of the sequence's folder",
            path=place,
            location=line,
            hint="names are relative to the folder of the list, as rgb/1305031102.175304.png",
        )
    if len(parts) == 1 and parts[0] in _TEXT_FILES:
        raise InputError(
            f"the list names {parts[0]} as an image, which is the name of a text file of a sequence",
            path=place,
            location=line,
            hint="give the image another name",
        )
    return str(PurePosixPath(*parts)) if parts else "."


def _parts(name: str) -> list[str]:
    return [part for part in name.replace("\\", "/").split("/") if part not in {"", "."}]


def _leads_outside(name: str, parts: list[str]) -> bool:
    return name.startswith(("/", "\\")) or ".." in parts or bool(parts and parts[0].endswith(":"))


def check_tar_member(member: tarfile.TarInfo, archive: str) -> str:
    """Return the normalised name of a regular file or folder.

    Raises:
        InputError: A link, a device, an unsafe name, or a file too large to be of a sequence.

    """
    name = check_name(member.name, archive)
    if not (member.isfile() or member.isdir()) or member.issparse():
        kind = "a link" if member.issym() or member.islnk() else "neither a file nor a folder"
        raise InputError(f"the member is {kind}", path=archive, location=f"member {member.name}")
    check_size(member.size, archive, member.name)
    return name


def check_size(size: int, archive: str, name: str) -> None:
    """Refuse a member that is too large to be held in memory.

    Raises:
        InputError: It is larger than `MAX_MEMBER_BYTES`.

    """
    if not 0 <= size <= MAX_MEMBER_BYTES:
        raise InputError(
            f"the member has {size} bytes; a file of a sequence has 0 to {MAX_MEMBER_BYTES}",
            path=archive,
            location=f"member {name}",
        )
