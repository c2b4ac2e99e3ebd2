# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Read a rawlog: ours, the published ones, and what other people recorded with MRPT."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.errors import InputError, MissingInputError
from tumtools.formats.cameras import own_calibrations
from tumtools.formats.rawlog import describe
from tumtools.formats.rawlog.besides import beside_the_streams, left_out
from tumtools.formats.rawlog.embedded import Embedded, pictures_in
from tumtools.formats.rawlog.externals import Folder
from tumtools.formats.rawlog.kept import read_kept
from tumtools.formats.rawlog.labels import choose_labels
from tumtools.formats.rawlog.survey import Place, Survey, survey
from tumtools.formats.tum.text import parse
from tumtools.model.camera import camera_of_name
from tumtools.model.sequence import (
    IMAGE_STREAMS,
    Frame,
    ImageStreamInfo,
    Loss,
    Sequence,
    SequenceInfo,
)
from tumtools.model.signals import Accelerometer, Trajectory
from tumtools.model.time import stamp_to_ticks

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping
    from pathlib import Path

    import numpy.typing as npt

    from tumtools.formats.options import ReadOptions
    from tumtools.formats.rawlog.pictures import Picture
    from tumtools.model.image import Image
    from tumtools.model.sequence import DetailRow
    from tumtools.model.text import TextLayout

SUFFIX: Final = ".rawlog"
GROUNDTRUTH_FILE: Final = "groundtruth.txt"
_GROUNDTRUTH: Final = "groundtruth"
ACCELEROMETER: Final = "accelerometer"
_FLOAT_TIME_ERROR_NS: Final = 1000
"""A time that went through float64 is off by less than this; the file name then tells it exactly."""
_METRES: Final = 1.0
"""Units per metre of depth that was in metres, not in counts."""


def open(path: Path, options: ReadOptions) -> Sequence:  # noqa: A001 - the verb of every format
    """Open a rawlog, or the folder that holds one.

    Raises:
        InputError: It is damaged, holds a class that is not read, or several sensors fit one stream.

    """
    return RawlogSequence(find(path), options)


def find(path: Path) -> Path:
    """Return the rawlog that a path means: itself, or the only one in a folder.

    Raises:
        MissingInputError: There is none.
        InputError: There are several.

    """
    if not path.is_dir():
        return path
    found = sorted(path.glob(f"*{SUFFIX}"))
    if len(found) == 1:
        return found[0]
    if not found:
        raise MissingInputError("there is no .rawlog file in this folder", path=path)
    names = ", ".join(file.name for file in found)
    raise InputError(
        f"there are {len(found)} rawlogs in this folder: {names}", path=path, hint="name one of them"
    )


@dataclass(frozen=True, slots=True)
class _Entry:
    """An image of the sequence."""

    stream: str
    stamp: int
    row: int
    place: Place


class RawlogSequence(Sequence):
    """A sequence in a rawlog.

    What is external is loaded by name; what is embedded is read in a second pass through the file, in
    which an image is held from where it stands to where its turn is.
    """

    def __init__(self, path: Path, options: ReadOptions) -> None:
        self._path = path
        self._folder = Folder(path)
        found = survey(path)
        if found.damage is not None and not options.salvage:
            raise found.damage
        self._survey = found
        self._kept = read_kept(path, found, salvage=options.salvage)
        self._warnings = list(self._kept.warnings)
        self._notes = self._kept.notes
        self._metadata = self._notes.metadata if self._notes else None
        labels = choose_labels(path, found, options, self._warnings)
        places = [place for place in found.places if labels.get(place.picture.stream) == place.picture.label]
        self._entries = self._make_entries(places)
        self._stamps = {
            stream: np.array([entry.stamp for entry in entries], np.int64)
            for stream, entries in self._entries.items()
        }
        self.accelerometer = self._make_accelerometer(found, labels.get(ACCELEROMETER))
        self._drop_stale_notes()
        self.groundtruth, text = self._read_groundtruth()
        self._missing = [
            entry for entries in self._entries.values() for entry in entries if not self._is_there(entry)
        ]
        self._add_warnings(found, labels)
        self.info = self._make_info(found, labels, text)
        cameras = {
            stream: one for (stream, label), one in found.cameras.items() if labels.get(stream) == label
        }
        kept = self._notes.cameras if self._notes else cameras
        self.cameras = own_calibrations(kept, self.info.camera, self.info.images)

    # --- the header -----------------------------------------------------------------------------------

    def _make_entries(self, places: list[Place]) -> dict[str, list[_Entry]]:
        """Give every image its stamp and its row; in the order of the rows."""
        listed = self._notes.counts if self._notes else ()
        by_stream: dict[str, list[Place]] = {stream: [] for stream in IMAGE_STREAMS if stream in listed}
        for place in places:
            by_stream.setdefault(place.picture.stream, []).append(place)
        entries = {}
        for stream, group in by_stream.items():
            if self._notes:
                group.sort(key=lambda place: place.picture.named or (self._stamp(place.picture), 0))
            entries[stream] = [
                _Entry(stream, self._stamp(place.picture), row, place) for row, place in enumerate(group)
            ]
        for stream, order in (self._metadata.row_order if self._metadata else {}).items():
            if stream in entries and sorted(order) == list(range(len(entries[stream]))):
                moved = [replace(entry, row=row) for entry, row in zip(entries[stream], order, strict=True)]
                entries[stream] = sorted(moved, key=lambda entry: entry.row)
        return {stream: entries[stream] for stream in IMAGE_STREAMS if stream in entries}

    def _stamp(self, picture: Picture) -> int:
        named = picture.named
        if named is not None and (self._notes or abs(named[0] - picture.stamp) <= _FLOAT_TIME_ERROR_NS):
            return named[0]
        return picture.stamp

    def _make_accelerometer(self, found: Survey, label: str | None) -> Accelerometer | None:
        rows = found.accelerations.get(label) if label is not None else None
        if rows is None:
            return Accelerometer.empty() if self._notes and ACCELEROMETER in self._notes.counts else None
        ticks = np.array(rows.ticks, np.uint64).astype(np.int64)
        stamps = (ticks - stamp_to_ticks(0)) * 100
        values = np.array(rows.values).reshape(-1, 3)
        if self._notes is None:
            # An object at the time of a frame has its time from the same float.
            exact = {
                entry.place.picture.ticks: entry.stamp
                for entries in self._entries.values()
                for entry in entries
                if entry.stamp != entry.place.picture.stamp
            }
            for row in np.flatnonzero(np.isin(ticks, list(exact))).tolist() if exact else ():
                stamps[row] = exact[int(ticks[row])]
            return Accelerometer(stamps, values)
        remainders = self._notes.accelerometer_remainders_ns
        if len(remainders) == len(stamps):
            stamps += np.array(remainders, np.int64)
        order = np.array(self._notes.metadata.row_order.get(ACCELEROMETER, ()), np.int64)
        if np.array_equal(np.sort(order), np.arange(len(stamps))):
            back = np.argsort(order)
            stamps, values = stamps[back], values[back]
        return Accelerometer(stamps, values)

    def _drop_stale_notes(self) -> None:
        """Forget what the comment says of single rows of streams that have been cut since."""
        if self._notes is None or self._metadata is None:
            return
        counts = self._counts()
        text = dict(self._metadata.text)
        for stream, layout in self._metadata.text.items():
            if stream == _GROUNDTRUTH:
                continue
            now, written = counts.get(stream, 0), self._notes.counts.get(stream, 0)
            if now != written:
                text[stream] = replace(layout, overrides={}, tail="", final_newline=True)
                reason = "" if self._survey.damage else "; the rawlog has been edited since it was written"
                self._warnings.append(
                    f"{self._path}: {now} of the {written} rows of {stream} are there{reason}"
                )
        self._metadata = replace(self._metadata, text=text)

    def _read_groundtruth(self) -> tuple[Trajectory | None, dict[str, TextLayout]]:
        """Read the text file beside the rawlog."""
        path = self._path.parent / GROUNDTRUTH_FILE
        text = dict(self._metadata.text) if self._metadata else {}
        try:
            data = path.read_bytes()
        except FileNotFoundError:
            return None, text
        except OSError as error:
            raise InputError(f"cannot be read ({error.strerror})", path=path) from error
        table = parse(data, _GROUNDTRUTH, str(path))
        return Trajectory(table.stamps, table.values[:, :3], table.values[:, 3:]), {
            **text,
            _GROUNDTRUTH: table.layout,
        }

    def _is_there(self, entry: _Entry) -> bool:
        name = entry.place.picture.file
        if name is None:
            return True
        self._folder.check(name)
        return self._folder.size(name) is not None

    def _add_warnings(self, found: Survey, labels: dict[str, str]) -> None:
        warn, path = self._warnings.append, self._path
        if found.damage is not None:
            warn(f"{path}: {found.damage.message}; what is before it ({found.count} objects) is read")
        if count := found.euclidean.get(labels.get("depth", ""), 0):
            warn(
                f"{path}: {count} depth images hold distances along the ray of each pixel "
                "(range_is_depth = 0), not depth along the optical axis; they are given as they are"
            )
        if self._missing:
            name = self._missing[0].place.picture.file
            warn(f"{path}: {len(self._missing)} external files are missing, the first is {name}")

    def _make_info(self, found: Survey, labels: dict[str, str], text: dict[str, TextLayout]) -> SequenceInfo:
        meta, stem = self._metadata, self._path.name.removesuffix(SUFFIX)
        return SequenceInfo(
            name=meta.name if meta else stem,
            format="rawlog",
            camera=meta.camera if meta else camera_of_name(stem),
            images={stream: self._image_info(stream, labels.get(stream, "")) for stream in self._entries},
            sources={
                **({ACCELEROMETER: labels[ACCELEROMETER]} if ACCELEROMETER in labels else {}),
                **({_GROUNDTRUTH: GROUNDTRUTH_FILE} if self.groundtruth is not None else {}),
            },
            text=text,
            frame_ids=dict(self._notes.frame_ids) if self._notes else {},
            licence=meta.licence if meta else None,
            citation=meta.citation if meta else None,
            digest=self._kept.digest,
            not_carried=tuple(self._not_carried(found, labels)),
            warnings=tuple(self._warnings),
        )

    def _image_info(self, stream: str, label: str) -> ImageStreamInfo:
        entries = self._entries[stream]
        info = ImageStreamInfo(count=len(entries), source=label)
        sizes = (entry.place.nbytes or self._folder.size(entry.place.picture.file or "") for entry in entries)
        info = replace(info, nbytes=sum(size or 0 for size in sizes))
        picture = self._survey.first.get((stream, label))
        try:
            image = None if picture is None else self._load(picture)
        except InputError:
            # Reading the images will say so in its place; the header of a sequence stays readable.
            return info
        if image is None:
            return info
        return replace(
            info,
            encoding=image.encoding,
            width=image.width,
            height=image.height,
            depth_units_per_metre=image.depth_units_per_metre,
            compression=image.compression,
        )

    def _not_carried(self, found: Survey, labels: dict[str, str]) -> Iterator[Loss]:
        if found.damage is not None:
            yield from left_out(found.damage, self._notes.counts if self._notes else {}, self._counts())
        yield from self._kept.losses
        yield from beside_the_streams(found, labels, is_ours=self._notes is not None)

    def _counts(self) -> dict[str, int]:
        """Return how many images or rows each stream of the rawlog has."""
        counts = {stream: len(stamps) for stream, stamps in self._stamps.items()}
        if self.accelerometer is not None:
            counts[ACCELEROMETER] = len(self.accelerometer)
        return counts

    def details(self) -> Mapping[str, tuple[DetailRow, ...]]:
        """Return what is in the rawlog: the file, its classes, its sensors."""
        return describe.tables(describe.description_of(self._survey))

    # --- the images -----------------------------------------------------------------------------------

    def image_stamps(self, stream: str) -> npt.NDArray[np.int64]:
        """Return the stamps of a stream in the order of its rows."""
        return self._stamps.get(stream, np.empty(0, np.int64))

    def images(
        self, streams: Collection[str] | None = None, start: int | None = None, end: int | None = None
    ) -> Iterator[Frame]:
        """Yield the images.

        Raises:
            MissingInputError: An external file is missing; before the first frame is yielded.
            InputError: The rawlog is damaged.

        """
        wanted = [
            entry
            for stream, entries in self._entries.items()
            if streams is None or stream in streams
            for entry in entries
            if (start is None or entry.stamp >= start) and (end is None or entry.stamp <= end)
        ]
        wanted.sort(key=lambda entry: (entry.stamp, IMAGE_STREAMS.index(entry.stream), entry.row))
        self._check_present(wanted)
        return self._frames(wanted)

    def _check_present(self, wanted: list[_Entry]) -> None:
        missing = [entry for entry in wanted if not self._is_there(entry)]
        if missing:
            name = missing[0].place.picture.file or ""
            raise MissingInputError(
                f"the external file is missing; object {missing[0].place.number} of {self._path.name} "
                f"names it, as {len(missing)} of its {len(wanted)} images are",
                path=self._folder.locate(name),
                hint="copy the folder of the images to the rawlog",
            )

    def _frames(self, wanted: list[_Entry]) -> Iterator[Frame]:
        embedded = Embedded(
            self._survey, {entry.place.key for entry in wanted if entry.place.picture.file is None}
        )
        frame_ids = self._notes.frame_ids if self._notes else {}
        for entry in wanted:
            place = entry.place
            picture = place.picture if place.picture.file is not None else embedded.take(place)
            load = partial(self._load, picture) if picture else partial(self._load_again, place)
            yield Frame(entry.stream, entry.stamp, entry.row, load, frame_ids.get(entry.stream))

    def _load(self, picture: Picture) -> Image:
        units = self._metadata.depth_units_per_metre if self._metadata else None
        return picture.load(self._folder, None if units == _METRES else units)

    def _load_again(self, place: Place) -> Image:
        """Read an embedded image that was not held, from the beginning of the file."""
        for key, picture in pictures_in(self._survey):
            if key == place.key:
                return self._load(picture)
        raise InputError(f"object {place.number} is not there any more", path=self._path)
