# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Headers and end of a tar archive, read so that damage is never taken for the end.

`tarfile` ends its list of members silently at a header with a wrong checksum and at the end of the file.
Here only the end marker of POSIX (pax, "ustar Interchange Format") ends it: two blocks of zeros.
"""

from __future__ import annotations

import tarfile
from typing import TYPE_CHECKING, Final, Self

if TYPE_CHECKING:
    from collections.abc import Callable

DAMAGED_HINT: Final = "the archive was damaged or cut off; get it again"
_PIECE: Final = 1 << 18
_TOLD = (tarfile.EOFHeaderError, tarfile.SubsequentHeaderError)  # type: ignore[attr-defined]  # the stubs leave them out
"""The end marker, and what `tarfile` reports itself."""
_SHORT = (tarfile.EmptyHeaderError, tarfile.TruncatedHeaderError)  # type: ignore[attr-defined]  # the stubs leave them out


class StrictTarInfo(tarfile.TarInfo):
    """A header that must be right.

    Raises:
        tarfile.ReadError: It is not, or the archive ends before its end marker.

    """

    @classmethod
    def fromtarfile(cls, archive: tarfile.TarFile) -> Self:
        """Return the next header."""
        offset = archive.fileobj.tell()
        try:
            return super().fromtarfile(archive)
        except tarfile.HeaderError as error:
            if isinstance(error, _TOLD):
                raise
            if isinstance(error, _SHORT):
                msg = "the archive ends without its end marker"
            else:
                msg = f"the header at offset {offset} of the unpacked archive is damaged: {error}"
            raise tarfile.ReadError(msg) from error


def check_end(read: Callable[[int], bytes], offset: int) -> None:
    """Read what follows the first zero block: another one, and then nothing but zeros.

    Args:
        read: Returns the next bytes, none at the end.
        offset: Where the next bytes are in the unpacked archive, for messages.

    Raises:
        tarfile.ReadError: It is something else.

    """
    first = offset
    while data := read(_PIECE):
        if rest := data.lstrip(b"\0"):
            place = offset + len(data) - len(rest)
            end = first - tarfile.BLOCKSIZE
            msg = f"there is data at offset {place} of the unpacked archive, behind its end marker at {end}"
            raise tarfile.ReadError(msg)
        offset += len(data)
    if offset - first < tarfile.BLOCKSIZE:
        msg = "the archive ends without its end marker"
        raise tarfile.ReadError(msg)
