# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Is an archive that stays packed whole? Told from its end, where possible, since inflating is slow.

Needed only where no checksum is known: a server that has a cut-off file announces its length truly.
"""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Final

from tumtools.fetch.unpack import BOMB_RATIO, unpack_tar, unpack_zip

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

_TAR_BLOCK: Final = 512
_TAR_END: Final = bytes(2 * _TAR_BLOCK)
_GZIP_SIZE_MODULUS: Final = 1 << 32


def check_whole(path: Path, kind: str, label: str) -> None:
    """Refuse an archive that is cut off or damaged at its end.

    Args:
        path: The archive.
        kind: `tgz`, `tar`, `tar.zst` or `zip`.
        label: What to call it in messages.

    Raises:
        InputError: It is; the message says after which member.

    """
    if kind == "zip":
        unpack_zip(path, None, label)
    elif not _ENDS.get(kind, _never)(path):
        with _Packed(path) as source:
            unpack_tar(source, kind, None, label)


class _Packed(io.FileIO):
    """A file as a source to unpack from."""

    @property
    def position(self) -> int:
        """Bytes that have been read."""
        return self.tell()


def _tgz_ends_well(path: Path) -> bool:
    """Look at the last four bytes: the size of the tar, which is a multiple of 512 and not absurd.

    What stands at the end of a cut-off file passes by chance once in thousands.
    """
    packed = path.stat().st_size
    size = int.from_bytes(_tail(path, 4), "little")
    while size < packed // 2:  # it is kept modulo 2 to the 32
        size += _GZIP_SIZE_MODULUS
    return size % _TAR_BLOCK == 0 and size <= BOMB_RATIO * packed


def _tar_ends_well(path: Path) -> bool:
    return path.stat().st_size % _TAR_BLOCK == 0 and _tail(path, len(_TAR_END)) == _TAR_END


def _never(path: Path) -> bool:
    del path
    return False


def _tail(path: Path, size: int) -> bytes:
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - size))
        return file.read()


_ENDS: Final[dict[str, Callable[[Path], bool]]] = {"tgz": _tgz_ends_well, "tar": _tar_ends_well}
