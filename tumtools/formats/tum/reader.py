# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Read a sequence in the benchmark's layout, from a folder, an archive, or a single trajectory file."""

from __future__ import annotations

import heapq
from collections import Counter
from functools import partial
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.errors import InputError, MissingInputError, TumtoolsError
from tumtools.formats.tum.inflate import GZIP_MAGIC, ZSTD_MAGIC
from tumtools.formats.tum.members import check_listed_name, check_size
from tumtools.formats.tum.storage import LIST_FILES, Folder, Storage, Zip
from tumtools.formats.tum.tar import Tar
from tumtools.formats.tum.text import Table, name_in_headers, parse
from tumtools.images import png
from tumtools.images.codec import image_of_png
from tumtools.images.parallel import read_ahead
from tumtools.model.camera import camera_of_name
from tumtools.model.sequence import (
    IMAGE_STREAMS,
    TUM_DEPTH_UNITS_PER_METRE,
    Frame,
    ImageStreamInfo,
    Loss,
    Sequence,
    SequenceInfo,
    frame_order,
    licence_of_name,
)
from tumtools.model.signals import Accelerometer, Trajectory

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Iterator, Mapping
    from pathlib import Path

    import numpy.typing as npt

    from tumtools.formats.options import ReadOptions
    from tumtools.model.image import Image

_READ_AHEAD: Final = 4
_ZIP_MAGIC: Final = b"PK"
_TAR_MAGIC: Final = b"ustar"
_TAR_MAGIC_AT: Final = 257
_PAPERS_NAME: Final = "imu.txt"


def open(path: Path, options: ReadOptions) -> Sequence:  # noqa: A001 - the verb of every format
    """Open a folder, a .tgz, .tar, .tar.zst or .zip archive, or one trajectory text file.

    Raises:
        InputError: It is damaged, or no sequence.

    """
    # This layout has no topics, and nothing in it is salvaged by guessing.
    return _open(path, tolerant=False, scratch=options.scratch)


def open_tolerant(path: Path) -> TumSequence | TrajectoryFile:
    """Open like `open`, but collect what is wrong instead of failing at the first problem.

    Lines that are no rows are in the `problems` of their table, text files that are no text are in
    `damaged`, images that are not there are in `missing` and are passed over by `images`.

    Raises:
        InputError: It is no sequence at all, or a damaged archive.

    """
    return _open(path, tolerant=True)


def _open(path: Path, *, tolerant: bool, scratch: Path | None = None) -> TumSequence | TrajectoryFile:
    if path.is_dir():
        return TumSequence(Folder(path), tolerant=tolerant)
    try:
        with path.open("rb") as file:
            head = file.read(_TAR_MAGIC_AT + len(_TAR_MAGIC))
        if head.startswith(_ZIP_MAGIC):
            return TumSequence(Zip(path), tolerant=tolerant)
        if head.startswith((GZIP_MAGIC, ZSTD_MAGIC)) or head.endswith(_TAR_MAGIC):
            return TumSequence(Tar(path, scratch), tolerant=tolerant)
        return TrajectoryFile(path, tolerant=tolerant)
    except OSError as error:
        if isinstance(error, TumtoolsError):
            raise
        raise InputError(f"cannot read: {error.strerror}", path=path) from error


class TrajectoryFile(Sequence):
    """A trajectory text file on its own: a sequence with nothing but poses.

    Attributes:
        table: The parsed text.

    """

    def __init__(self, path: Path, *, tolerant: bool = False) -> None:
        check_size(path.stat().st_size, str(path), path.name)
        table = parse(path.read_bytes(), "groundtruth", str(path), tolerant=tolerant)
        self.table = table
        self.groundtruth = _trajectory(table)
        name = name_in_headers([table.layout.head]) or path.stem
        licence, citation = licence_of_name(name)
        self.info = SequenceInfo(
            name=name,
            format="tum",
            camera=camera_of_name(name),
            licence=licence,
            citation=citation,
            sources={"groundtruth": path.name},
            text={"groundtruth": table.layout},
            warnings=tuple(_header_warnings(table, str(path))),
        )

    def image_stamps(self, stream: str) -> npt.NDArray[np.int64]:
        """Return no stamps: there are no images."""
        del stream
        return np.empty(0, np.int64)

    def images(
        self, streams: Collection[str] | None = None, start: int | None = None, end: int | None = None
    ) -> Iterator[Frame]:
        """Yield nothing: there are no images."""
        del streams, start, end
        return iter(())


class TumSequence(Sequence):
    """A sequence in a folder or an archive.

    Attributes:
        tables: The parsed text file of each stream.
        files: The text file of each stream, relative to the folder.
        names: The file name of each row of the image lists, by stream.
        missing: Images that a list names and that are not there, in list order.
        damaged: Why a text file could not be read at all, by stream; only when opened tolerantly.

    """

    def __init__(self, storage: Storage, *, tolerant: bool = False) -> None:
        self._tolerant = tolerant
        self._storage = storage
        self.files: dict[str, str] = {}
        for name, stream in LIST_FILES.items():
            if name in storage.files:
                self.files.setdefault(stream, name)
        if not self.files:
            raise InputError(
                f"no sequence here: none of {', '.join(LIST_FILES)}",
                path=storage.label,
                hint="name the folder that holds rgb.txt and depth.txt",
            )
        self.damaged: dict[str, InputError] = {}
        self.tables = {stream: self._parse(stream, name) for stream, name in self.files.items()}
        self.names = {
            stream: tuple(self._check_name(stream, row, name) for row, name in enumerate(table.names))
            for stream, table in self.tables.items()
            if stream in IMAGE_STREAMS
        }
        self.missing = [name for names in self.names.values() for name in names if name not in storage.files]
        if "groundtruth" in self.tables:
            self.groundtruth = _trajectory(self.tables["groundtruth"])
        if "accelerometer" in self.tables:
            table = self.tables["accelerometer"]
            self.accelerometer = Accelerometer(table.stamps, table.values)
        self.info = self._make_info()

    @property
    def sizes(self) -> Mapping[str, int]:
        """Size in bytes of each file that is there, by its name relative to the folder."""
        return self._storage.files

    def _parse(self, stream: str, name: str) -> Table:
        data = bytes(self._storage.read(name))
        try:
            return parse(data, stream, self._storage.place(name), tolerant=self._tolerant)
        except InputError as error:
            if not self._tolerant:
                raise
            self.damaged[stream] = error
            return parse(b"", stream, self._storage.place(name))

    def _check_name(self, stream: str, row: int, name: str) -> str:
        try:
            line = f"line {self.tables[stream].lines[row]}"
            return check_listed_name(name, self._storage.place(self.files[stream]), line)
        except InputError:
            if not self._tolerant:
                raise
            return name  # no file has this name, so it counts as missing

    def _make_info(self) -> SequenceInfo:
        storage = self._storage
        # A name in no known coding cannot go into the fields of other formats.
        name = (
            name_in_headers(table.layout.head for table in self.tables.values())
            or storage.name.encode("utf-8", "replace").decode()
        )
        licence, citation = licence_of_name(name)
        streams = [stream for stream in IMAGE_STREAMS if stream in self.names]
        return SequenceInfo(
            name=name,
            format="tum",
            camera=camera_of_name(name),
            images={stream: self._image_info(stream) for stream in streams},
            sources={stream: name for stream, name in self.files.items() if stream not in IMAGE_STREAMS},
            text={stream: table.layout for stream, table in self.tables.items()},
            licence=licence,
            citation=citation,
            not_carried=tuple(self._other_files()),
            warnings=tuple(self._warnings()),
        )

    def _image_info(self, stream: str) -> ImageStreamInfo:
        names = self.names[stream]
        sizes = self._storage.files
        present = [name for name in names if name in sizes]
        nbytes = sum(sizes[name] for name in present)
        folder = names[0].rpartition("/")[0] if names else stream
        if not present:
            return ImageStreamInfo(count=len(names), compression="png", source=folder, is_uniform=True)
        try:
            found = png.check(self._storage.read(present[0]))
        except InputError:
            # Reading the images will say so with its name; the header of a sequence stays readable.
            return ImageStreamInfo(
                count=len(names), nbytes=nbytes, compression="png", source=folder, is_uniform=True
            )
        units = TUM_DEPTH_UNITS_PER_METRE if stream == "depth" else None
        encoding = "mono16" if units is None and found.encoding == "16UC1" else found.encoding
        return ImageStreamInfo(
            len(names), encoding, found.width, found.height, units, None, nbytes, "png", folder, True
        )

    def _other_files(self) -> Iterator[Loss]:
        known = {name for names in self.names.values() for name in names} | set(self.files.values())
        found = dict.fromkeys(self._storage.files, "no list of the sequence names it")
        found.update(self._storage.others)
        # The files of a folder are not in one piece: a/b lies between a.txt and a/b.txt.
        folders: Counter[tuple[str, str]] = Counter()
        for name in sorted(found.keys() - known):
            folder = name.rpartition("/")[0]
            if set(folder.split("/")) <= {"", ".."}:
                yield Loss(name, "file not carried over", 1, found[name])
            else:
                folders[folder, found[name]] += 1
        for (folder, why), count in sorted(folders.items()):
            yield Loss(f"{folder}/", "files not carried over", count, why)

    def _warnings(self) -> Iterator[str]:
        for stream, table in self.tables.items():
            yield from _header_warnings(table, self._storage.place(self.files[stream]))
        for stream, names in self.names.items():
            missing = self._missing_rows(stream, range(len(names)))
            if missing:
                place, line, message = self._describe_missing(stream, missing)
                yield f"{place}, {line}: {message}"
        if self.files.get("accelerometer") == _PAPERS_NAME:
            place = self._storage.place(_PAPERS_NAME)
            yield f"{place}: taken for accelerometer.txt, and written under that name"

    def image_stamps(self, stream: str) -> npt.NDArray[np.int64]:
        """Return the stamps of the list, in its order."""
        table = self.tables.get(stream)
        return table.stamps if table is not None and stream in self.names else np.empty(0, np.int64)

    def images(
        self, streams: Collection[str] | None = None, start: int | None = None, end: int | None = None
    ) -> Iterator[Frame]:
        """Yield the images that the lists name.

        Raises:
            MissingInputError: An image is missing; before the first frame is yielded.
            InputError: An image cannot be read; where its turn comes.

        """
        wanted = [stream for stream in self.names if streams is None or stream in streams]
        rows = {stream: self._rows(stream, start, end) for stream in wanted}
        self._check_present(rows)
        frames = [self._stream_frames(stream, rows[stream]) for stream in wanted]
        if self._storage.sequential:
            frames = [read_ahead(stream, _READ_AHEAD) for stream in frames]
        return heapq.merge(*frames, key=frame_order)

    def _rows(self, stream: str, start: int | None, end: int | None) -> list[int]:
        """Return the rows of an image list within the limits, in order of their stamps."""
        stamps, names = self.tables[stream].stamps, self.names[stream]
        chosen = np.ones(len(stamps), bool)
        if start is not None:
            chosen &= stamps >= start
        if end is not None:
            chosen &= stamps <= end
        ordered = np.flatnonzero(chosen)
        ordered = ordered[np.argsort(stamps[ordered], kind="stable")]
        return [row for row in ordered.tolist() if not self._tolerant or names[row] in self._storage.files]

    def _stream_frames(self, stream: str, rows: list[int]) -> Iterator[Frame]:
        stamps, names = self.tables[stream].stamps, self.names[stream]
        for row in rows:
            load = partial(self._load, stream, row)
            if self._storage.sequential:
                # Read here, in the order of the archive, not by whichever thread comes first.
                load = partial(self._wrap, stream, row, self._storage.read(names[row]))
            yield Frame(stream, int(stamps[row]), row, load)

    def _missing_rows(self, stream: str, rows: Iterable[int]) -> list[int]:
        names = self.names[stream]
        return [row for row in rows if names[row] not in self._storage.files]

    def _describe_missing(self, stream: str, missing: list[int]) -> tuple[str, str, str]:
        """Return the list, the line in it that names the first missing image, and what to say."""
        first, count = missing[0], len(self.names[stream])
        return (
            self._storage.place(self.files[stream]),
            f"line {self.tables[stream].lines[first]}",
            f"there is no image {self.names[stream][first]}; {len(missing)} of {count} are missing",
        )

    def _check_present(self, rows: Mapping[str, list[int]]) -> None:
        """Refuse to begin when images are missing; the first of them in time is named."""
        missing = {stream: found for stream in rows if (found := self._missing_rows(stream, rows[stream]))}
        if missing:
            first = min(missing, key=lambda stream: int(self.tables[stream].stamps[missing[stream][0]]))
            place, line, message = self._describe_missing(first, missing[first])
            hint = "get the sequence again, or take the rows without a file out of the list"
            raise MissingInputError(message, path=place, location=line, hint=hint)

    def png_header(self, stream: str, row: int) -> png.PngHeader:
        """Read nothing of an image but its header.

        Raises:
            InputError: It is missing, or no PNG file.

        """
        return png.header(self._storage.read_head(self.names[stream][row], png.HEADER_SIZE))

    def _load(self, stream: str, row: int) -> Image:
        return self._wrap(stream, row, self._storage.read(self.names[stream][row]))

    def _wrap(self, stream: str, row: int, data: bytes | memoryview) -> Image:
        units = TUM_DEPTH_UNITS_PER_METRE if stream == "depth" else None
        return image_of_png(data, units, self._storage.place(self.names[stream][row]))

    def close(self) -> None:
        """Close the archive."""
        self._storage.close()


def _trajectory(table: Table) -> Trajectory:
    return Trajectory(table.stamps, table.values[:, :3], table.values[:, 3:])


def _header_warnings(table: Table, place: str) -> Iterator[str]:
    for problem in table.problems:
        yield f"{place}, line {problem.line}: {problem.message}; it is kept and not read as a row"
