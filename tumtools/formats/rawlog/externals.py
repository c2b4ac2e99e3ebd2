# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The files beside a rawlog: where MRPT looks for them, and depth in all forms that it has had.

A depth file is a gzip or Zstandard file of either 16-bit counts (scan versions 9 and later) or a float32
matrix of metres (before), or a text matrix of one of them. MRPT 2.x writes old rawlogs anew as version 10
and leaves the files as they are, so the content tells which it is, not the version.
"""

from __future__ import annotations

import os
import struct
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.errors import InputError, MissingInputError, UnsupportedInputError
from tumtools.formats.rawlog import archive
from tumtools.formats.rawlog.compression import Content, read_file
from tumtools.images.limits import check_size
from tumtools.images.parallel import take_room
from tumtools.printable import shortened

if TYPE_CHECKING:
    from pathlib import Path

    import numpy.typing as npt

IMAGES_SUFFIX: Final = "_Images"
"""What the name of the folder of the files adds to the name of the rawlog."""
_SUFFIXES: Final = (IMAGES_SUFFIX, "_images", "_IMAGES")
_SHARED_FOLDER: Final = "Images"
_MAX_FILE: Final = archive.MAX_FIELD
_MOST_HEADER: Final = 1 + archive.MAX_NAME + 1 + 8
_COUNTS: Final = 2**16
_U16_HEADER: Final = struct.Struct("<II")


@dataclass(slots=True)
class Folder:
    """Looks external files up as MRPT does.

    Args:
        rawlog: The rawlog that names them.

    """

    rawlog: Path
    _found: Path | None = field(default=None, init=False)
    _sizes: dict[str, int | None] = field(default_factory=dict, init=False)

    @property
    def _stem(self) -> str:
        """The name of the rawlog without its extension, whichever it is: MRPT cuts any."""
        stem, dot, _ = self.rawlog.name.rpartition(".")
        return stem if dot else self.rawlog.name

    @property
    def path(self) -> Path | None:
        """The folder of the external files, if there is one."""
        if self._found is None:
            # Beside those of MRPT, tumtools has long taken the whole name of what is no `.rawlog`.
            stems = self._stem, self.rawlog.name.removesuffix(".rawlog")
            names = (f"{stem}{suffix}" for stem in stems for suffix in _SUFFIXES)
            candidates = (self.rawlog.parent / name for name in (*names, _SHARED_FOLDER))
            self._found = next((path for path in candidates if path.is_dir()), None)
        return self._found

    def check(self, name: str) -> tuple[str, ...]:
        """Return the parts of a name.

        Raises:
            InputError: The name leads out of the folder.

        """
        parts = name.replace("\\", "/").split("/")
        if not name or "\0" in name:
            raise InputError(
                f"the external file name {name[:100]!r} is the name of no file", path=self.rawlog
            )
        if parts[0] == "" or parts[0].endswith(":") or ".." in parts:
            raise InputError(
                f"the external file name {name[:100]!r} leads out of the folder of the rawlog",
                path=self.rawlog,
                hint="external files are named relative to the folder <name>_Images beside the rawlog",
            )
        return tuple(parts)

    def locate(self, name: str) -> str:
        """Return where the file of a name should be; no `Path`, which takes as long as a small file.

        Raises:
            InputError: The name leads out of the folder.
            MissingInputError: There is no folder of external files.

        """
        parts = self.check(name)
        folder = self.path
        if folder is None:
            expected = f"{self._stem}{IMAGES_SUFFIX}"
            raise MissingInputError(
                f"the rawlog names the external file {shortened(name)!r}, "
                f"but there is no folder {expected!r} beside it",
                path=self.rawlog,
                hint="copy the folder of the images to the rawlog",
            )
        return "/".join((str(folder), *parts))

    def shown(self, name: str) -> str:
        """Return where the file of a name should be, for messages; raises as `locate` does."""
        path = self.locate(name)
        return f"{path[: -len(name)]}{shortened(path[-len(name) :])}"

    def read(self, name: str) -> bytes:
        """Read a file.

        Raises:
            MissingInputError: It is not there.
            InputError: It cannot be read, or is larger than any image.

        """
        path = self.locate(name)
        try:
            data = read_file(path, _MAX_FILE)
        except MissingInputError as error:
            raise MissingInputError(
                f"the external file of {self.rawlog.name} is missing",
                path=self.shown(name),
                hint="copy the folder of the images to the rawlog",
            ) from error
        if len(data) > _MAX_FILE:
            raise InputError(f"the external file has more than {_MAX_FILE} bytes", path=self.shown(name))
        return data

    def size(self, name: str) -> int | None:
        """Return the bytes that a file has when it is first asked for; None if it is missing.

        Raises:
            InputError: The name leads out of the folder.

        """
        if name not in self._sizes:
            try:
                self._sizes[name] = os.stat(self.locate(name)).st_size  # noqa: PTH116 - no Path, as above
            except OSError:
                self._sizes[name] = None
        return self._sizes[name]


def read_depth(folder: Folder, name: str) -> npt.NDArray[np.uint16] | npt.NDArray[np.float32]:
    """Read an external depth image.

    Returns:
        Counts as uint16, or metres as float32; shape [rows, columns].

    Raises:
        InputError: The file is damaged.

    """
    path = folder.locate(name)
    data = folder.read(name)
    if name.endswith(".txt"):
        return _text_depth(data, path)
    content = Content(data, path)
    head = content.read(_U16_HEADER.size)
    if any(head[2:4]):  # more rows than an image has, so these are letters of the name of a matrix
        head += content.read(_MOST_HEADER - len(head))
    start = _matrix_start(head)
    dtype, what = ("<u2", "pixels of 16 bits") if start == 0 else ("<f4", "numbers in a matrix")
    if len(head) < start + _U16_HEADER.size:
        raise InputError(f"a depth file of {len(head)} bytes has no header", path=path)
    rows, columns = _U16_HEADER.unpack_from(head, start)
    try:
        check_size(columns, rows)
    except UnsupportedInputError as error:
        raise UnsupportedInputError(f"the depth file announces {error.message}", path=path) from error
    take_room(4 * rows * columns)
    begin = start + _U16_HEADER.size
    body = head[begin:]
    size = np.dtype(dtype).itemsize * rows * columns + (1 if start else 0)
    body += content.read(max(size + 1 - len(body), 1))
    if len(body) != size or (start and body[-1] != archive.END_MARK):
        whole, found = begin + size, f"{begin + len(body)}"
        if len(body) > size:
            found = f"more than {whole}"
        raise InputError(
            f"the depth file announces {rows} x {columns} {what}, that is {whole} bytes; it has {found}",
            path=path,
        )
    return np.frombuffer(body, dtype, count=rows * columns).reshape(rows, columns)


def _matrix_start(head: bytes) -> int:
    """Return where the size of a float matrix stands, behind its name and version; 0 if this is none."""
    end = 1 + (head[0] & ~archive.MODERN_MARK) if head else 0
    if not end or not head[0] & archive.MODERN_MARK or head[end : end + 1] != b"\0":
        return 0
    return end + 1 if archive.class_of(head[1:end].decode("latin-1")) == "CMatrixF" else 0


def _text_depth(data: bytes, path: str) -> npt.NDArray[np.uint16] | npt.NDArray[np.float32]:
    """Decode a text matrix: counts if all are whole numbers that fit, else metres."""
    lines = [line for line in data.splitlines() if line.strip()]
    columns = len(lines[0].split()) if lines else 0
    check_size(columns, len(lines))
    take_room(len(data) + 4 * columns * len(lines))
    matrix = np.empty((len(lines), columns), np.float32)
    whole = bool(lines)
    for row, line in enumerate(lines):
        try:
            values = np.array(line.split(), np.bytes_).astype(np.float64).reshape(columns)
            matrix[row] = values
        except ValueError as error:
            raise InputError(
                f"the depth file is no text matrix ({error})", path=path, location=f"row {row}"
            ) from error
        whole = whole and bool(((values == np.rint(values)) & (values >= 0) & (values < _COUNTS)).all())
    return matrix.astype(np.uint16) if whole else matrix


def depth_payload(counts: npt.NDArray[np.uint16]) -> bytes:
    """Return 16-bit counts as in a depth file of scan versions 9 and later, not compressed."""
    return b"".join((_U16_HEADER.pack(*counts.shape), np.ascontiguousarray(counts, "<u2").data))


def metres_payload(metres: npt.NDArray[np.float32]) -> bytes:
    """Return metres, 0 where there is no reading, as in a depth file of scan versions before 9.

    It is not compressed.
    """
    head = b"\x87CMatrix\x00" + _U16_HEADER.pack(*metres.shape)
    return b"".join((head, np.ascontiguousarray(metres, "<f4").data, bytes([archive.END_MARK])))
