# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Write a sequence in the benchmark's layout, as a folder or a .tgz archive."""

from __future__ import annotations

import io
import re
import tarfile
from abc import ABC, abstractmethod
from contextlib import ExitStack, closing
from dataclasses import replace
from itertools import chain, count
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from isal import igzip

from tumtools.errors import OutputError
from tumtools.formats.options import Needs, Plan
from tumtools.formats.tum.members import check_listed_name
from tumtools.formats.tum.text import fit_layout, name_in_headers, parse_literal, render, render_rows
from tumtools.images.codec import png_of
from tumtools.images.parallel import ordered_map
from tumtools.model.camera import camera_of_name
from tumtools.model.sequence import (
    IMAGE_STREAMS,
    TUM_DEPTH_UNITS_PER_METRE,
    WHOLE_SEQUENCE,
    Frame,
    Loss,
    Sequence,
    licence_of_name,
)
from tumtools.model.text import TextLayout, default_layout
from tumtools.model.time import format_stamp

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    import numpy.typing as npt

    from tumtools.formats.options import Progress, WriteOptions

_ARCHIVE_SUFFIXES: Final = (".tgz", ".tar.gz")
_PLAIN_NAME: Final = re.compile(r"\w[\w.+-]*")
_PNG_SHARE: Final = {"32FC1": 0.11, "16UC1": 0.22, "mono16": 0.4}
"""Typical size of a PNG file as a share of the raw pixels, by encoding; colour is about half."""


def write(sequence: Sequence, target: Path, options: WriteOptions, progress: Progress) -> tuple[Loss, ...]:
    """Write text files and images.

    Args:
        sequence: Depth is in counts of 1/5000 m (see `convert`, which rescales).
        target: A folder to make, or a file whose name ends with .tgz or .tar.gz.
        options: None that matter here but `jobs`.
        progress: Told of each image.

    Returns:
        What the layout has no place for.

    """
    layouts = _layouts(sequence)
    texts = _texts(sequence, layouts)
    names = _names(sequence, layouts)
    sink: _Sink = (
        _Archive(target, sequence.info.name) if target.name.endswith(_ARCHIVE_SUFFIXES) else _Folder(target)
    )

    def encode(frame: Frame) -> tuple[str, bytes | memoryview]:
        name, data = names[frame.stream][frame.row], png_of(frame.load())
        if not sink.ordered:
            sink.add(name, data)
        return name, data

    with closing(sink), closing(ordered_map(encode, sequence.images(), options.jobs, join=True)) as encoded:
        for name, text in texts.items():
            sink.add(name, text)
        for stream in sequence.info.images:
            sink.add_folder(stream)
        for name, data in encoded:
            if sink.ordered:
                sink.add(name, data)
            progress(1, len(data))
    return tuple(_losses(sequence, layouts, target))


def needs(options: WriteOptions) -> Needs:
    """Depth is in counts of 1/5000 m; PNG files are kept."""
    del options
    return Needs(depth_units_per_metre=TUM_DEPTH_UNITS_PER_METRE)


def plan(sequence: Sequence, target: Path, options: WriteOptions) -> Plan:
    """Return the losses, and the estimated size."""
    del options
    layouts = _layouts(sequence)
    _names(sequence, layouts)
    size = sum(map(len, _texts(sequence, layouts).values()))
    for info in sequence.info.images.values():
        if info.compression == "png":
            size += info.nbytes
        else:
            size += int(info.nbytes * _PNG_SHARE.get(info.encoding or "", 0.5))
    return Plan(tuple(_losses(sequence, layouts, target)), size)


def _losses(sequence: Sequence, layouts: Mapping[str, TextLayout], target: Path) -> Iterator[Loss]:
    why = "the layout has no place for calibrations"
    for stream in sequence.cameras:
        yield Loss(stream, "calibration", 1, why, alters=("calibration",))
    why = "the layout has no place for frame ids"
    for stream, frame in sequence.info.frame_ids.items():
        yield Loss(stream, f"frame id {frame}", 1, why, alters=("frame id",))
    yield from _losses_of_name(
        sequence, name_in_headers(layout.head for layout in layouts.values()) or target.name
    )


def _losses_of_name(sequence: Sequence, name: str) -> Iterator[Loss]:
    """Tell of what the layout keeps only by a name: that in a header, or else that of the target."""
    info = sequence.info
    if info.camera is not None and camera_of_name(name) != info.camera:
        why = "the layout tells the camera only by the name of the sequence"
        stream = next(iter(info.images), WHOLE_SEQUENCE)
        yield Loss(stream, f"camera {info.camera}", 1, why, alters=("camera",))
    if info.licence is not None and licence_of_name(name) != (info.licence, info.citation):
        why = "the layout has no place for it"
        yield Loss(WHOLE_SEQUENCE, "licence and citation", 1, why, alters=("licence",))


def _layouts(sequence: Sequence) -> dict[str, TextLayout]:
    """Return the layout of each text file to write, fitted so that it prints every value exactly."""
    info = sequence.info
    layouts = {}
    for stream, stamps, values in _columns(sequence):
        layout = info.text.get(stream) or default_layout(stream, info.name)
        layouts[stream] = fit_layout(layout, stamps, values)
        if stream in IMAGE_STREAMS:
            layouts[stream] = _name_repeats_apart(sequence, stream, layouts[stream])
    return layouts


def _name_repeats_apart(sequence: Sequence, stream: str, layout: TextLayout) -> TextLayout:
    """Give different images with the same stamp different file names; equal ones share their file.

    Rows that say their name literally keep it; nobody else gets it.
    """
    stamps = sequence.image_stamps(stream)
    unique, counts = np.unique(stamps, return_counts=True)
    overrides = dict(layout.overrides)
    taken = {parse_literal(text, stream)[2][0] for text in overrides.values()}
    for stamp in unique[counts > 1].tolist():
        text = format_stamp(stamp, layout.stamp_decimals)
        names: dict[bytes, str] = {}
        for frame in sequence.images([stream], stamp, stamp):
            if frame.row in layout.overrides:
                continue
            data = bytes(png_of(frame.load()))
            if data not in names:
                names[data] = _free_name(f"{stream}/{text}", taken)
                taken.add(names[data])
            if names[data] != f"{stream}/{text}.png":
                overrides[frame.row] = f"{text}{layout.separator}{names[data]}{layout.newline[:-1]}"
    return replace(layout, overrides=overrides)


def _free_name(stem: str, taken: set[str]) -> str:
    """Return the first of `STEM.png`, `STEM-1.png`, `STEM-2.png` and so on that is not taken."""
    names = chain([f"{stem}.png"], (f"{stem}-{number}.png" for number in count(1)))
    return next(name for name in names if name not in taken)


def _columns(
    sequence: Sequence,
) -> list[tuple[str, npt.NDArray[np.int64], npt.NDArray[np.float64]]]:
    columns: list[tuple[str, npt.NDArray[np.int64], npt.NDArray[np.float64]]] = []
    for stream in IMAGE_STREAMS:
        if stream in sequence.info.images:
            stamps = sequence.image_stamps(stream)
            columns.append((stream, stamps, np.empty((len(stamps), 0))))
    if sequence.accelerometer is not None:
        columns.append(("accelerometer", sequence.accelerometer.stamps, sequence.accelerometer.values))
    if sequence.groundtruth is not None:
        columns.append(("groundtruth", sequence.groundtruth.stamps, sequence.groundtruth.values))
    return columns


def _texts(sequence: Sequence, layouts: dict[str, TextLayout]) -> dict[str, bytes]:
    return {
        f"{stream}.txt": render(layouts[stream], stream, stamps, values)
        for stream, stamps, values in _columns(sequence)
    }


def _names(sequence: Sequence, layouts: Mapping[str, TextLayout]) -> dict[str, list[str]]:
    """Return the file name of each image of each stream, as its list names it.

    Raises:
        OutputError: Two streams name the same file, which is to be made of pixels for one of them.

    """
    names: dict[str, list[str]] = {}
    for stream, info in sequence.info.images.items():
        names[stream] = _image_names(sequence, stream, layouts[stream])
        for other, known in names.items():
            kept = info.compression == "png" and sequence.info.images[other].compression == "png"
            if other != stream and not kept and (both := set(known).intersection(names[stream])):
                raise OutputError(
                    f"the lists of {other} and {stream} name the same file, {min(both)}, which is not "
                    "the same image for both any more",
                    path=sequence.info.name,
                    hint="write one of them with --streams, or keep the files with --archive",
                )
    return names


def _image_names(sequence: Sequence, stream: str, layout: TextLayout) -> list[str]:
    stamps = sequence.image_stamps(stream)
    rows = render_rows(replace(layout, separator=" "), stream, stamps, np.empty((len(stamps), 0)))
    names = [row.split(" ")[1] for row in rows]
    for row, text in layout.overrides.items():
        names[row] = parse_literal(text, stream)[2][0]
    # Literal rows come from the source, which may be anybody's.
    return [check_listed_name(name, f"the list of {stream} images") for name in names]


class _Sink(ABC):
    """Where files go.

    Attributes:
        ordered: Files must be added one after the other, in order; else by any thread.

    """

    ordered: bool

    @abstractmethod
    def add(self, name: str, data: bytes | memoryview) -> None: ...

    @abstractmethod
    def add_folder(self, name: str) -> None: ...

    @abstractmethod
    def close(self) -> None: ...


class _Folder(_Sink):
    ordered = False

    def __init__(self, path: Path) -> None:
        self._path = str(path)
        path.mkdir()
        self._folders = {""}

    def add(self, name: str, data: bytes | memoryview) -> None:
        folder = name.rpartition("/")[0]
        if folder not in self._folders:
            self.add_folder(folder)
        with open(f"{self._path}/{name}", "wb", buffering=0) as file:  # noqa: PTH123 - Path takes as long as a small file
            while data:
                data = data[file.write(data) :]

    def add_folder(self, name: str) -> None:
        if name not in self._folders:
            Path(self._path, name).mkdir(parents=True, exist_ok=True)
            self._folders.add(name)

    def close(self) -> None:
        pass


class _Archive(_Sink):
    """A .tgz with the same bytes on every day and machine: no times, no owners.

    The images are compressed already, so the archive is packed at the lowest level.
    """

    ordered = True

    def __init__(self, path: Path, name: str) -> None:
        self._files = ExitStack()  # closes all, whichever of them finds the disk full
        file = self._files.enter_context(path.open("wb"))
        # Ten times as fast as zlib at the same size.
        packed = igzip.IGzipFile("", "wb", compresslevel=1, fileobj=file, mtime=0)  # type: ignore[no-untyped-call]  # its stub has none
        self._files.callback(packed.close)
        self._tar = tarfile.TarFile(fileobj=packed, mode="w", format=tarfile.PAX_FORMAT)
        self._files.callback(self._tar.close)
        # The name may come from anybody's recording.
        self._root = name if _PLAIN_NAME.fullmatch(name) else path.name.split(".")[0]
        self._folders: set[str] = set()
        self.add_folder("")

    def add(self, name: str, data: bytes | memoryview) -> None:
        folder = name.rpartition("/")[0]
        if folder not in self._folders:
            self.add_folder(folder)
        member = tarfile.TarInfo(f"{self._root}/{name}")
        member.size = len(data)
        self._tar.addfile(member, io.BytesIO(data))
        self._tar.members.clear()  # type: ignore[attr-defined]  # they would all be kept in memory

    def add_folder(self, name: str) -> None:
        if name in self._folders:
            return
        member = tarfile.TarInfo(f"{self._root}/{name}".rstrip("/"))
        member.type, member.mode = tarfile.DIRTYPE, 0o755
        self._tar.addfile(member)
        self._folders.add(name)

    def close(self) -> None:
        self._files.close()
