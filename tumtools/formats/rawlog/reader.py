# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Read a rawlog: ours, the published ones, and what other people recorded with MRPT."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.errors import InputError, MissingInputError
from tumtools.formats.cameras import own_calibrations
from tumtools.formats.rawlog import describe, report
from tumtools.formats.rawlog.besides import beside_the_streams, left_behind, left_out
from tumtools.formats.rawlog.embedded import Embedded
from tumtools.formats.rawlog.entries import Entry, count_of, make_entries
from tumtools.formats.rawlog.externals import Folder
from tumtools.formats.rawlog.kept import read_kept
from tumtools.formats.rawlog.labels import choose_labels
from tumtools.formats.rawlog.signals import (
    ACCELEROMETER,
    GROUNDTRUTH,
    GROUNDTRUTH_FILE,
    fitting_layouts,
    make_accelerometer,
    read_groundtruth,
)
from tumtools.formats.rawlog.stamps import Origin
from tumtools.formats.rawlog.survey import Survey, survey
from tumtools.model.camera import camera_of_name
from tumtools.model.sequence import (
    IMAGE_STREAMS,
    Frame,
    ImageStreamInfo,
    Loss,
    Sequence,
    SequenceInfo,
)
from tumtools.printable import shortened

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


class RawlogSequence(Sequence):
    """A sequence in a rawlog.

    What is external is loaded by name; what is embedded is read in a second pass through the file, in
    which an image is held from where it stands to where its turn is.

    Attributes:
        missing: Images whose external file is missing. They are left out of a sequence that is salvaged.

    """

    def __init__(self, path: Path, options: ReadOptions) -> None:
        self._path = path
        self._folder = Folder(path)
        self._salvage = options.salvage
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
        self._entries = make_entries(places, self._notes)
        self._stamps = {
            stream: np.array([entry.stamp for entry in entries], np.int64)
            for stream, entries in self._entries.items()
        }
        moved = count_of(self._entries, Origin.MOVED) > 0
        self.accelerometer = make_accelerometer(
            found.accelerations.get(labels[ACCELEROMETER]) if ACCELEROMETER in labels else None,
            self._notes,
            self._entries,
            moved=moved,
        )
        text = self._fitting_layouts(found)
        groundtruth = read_groundtruth(path.parent)
        if groundtruth is not None:
            self.groundtruth, text[GROUNDTRUTH] = groundtruth
        self.missing = tuple(
            entry for entries in self._entries.values() for entry in entries if not self._is_there(entry)
        )
        self._add_warnings(found, labels)
        if options.salvage and self.missing:
            text = self._leave_out_missing(text)
        self.info = self._make_info(found, labels, text)
        cameras = {
            stream: one for (stream, label), one in found.cameras.items() if labels.get(stream) == label
        }
        kept = self._notes.cameras if self._notes else cameras
        self.cameras = own_calibrations(kept, self.info.camera, self.info.images)

    # --- the header -----------------------------------------------------------------------------------

    def _fitting_layouts(self, found: Survey) -> dict[str, TextLayout]:
        if self._notes is None:
            return {}
        return fitting_layouts(
            self._path,
            self._notes,
            self._stamps,
            self.accelerometer,
            self._warnings,
            damaged=found.damage is not None,
        )

    def _leave_out_missing(self, text: dict[str, TextLayout]) -> dict[str, TextLayout]:
        """Go on with the images that are there, their rows numbered anew; return the layouts for them."""
        missing = {(entry.stream, entry.row) for entry in self.missing}
        layouts = dict(text)
        for stream, entries in self._entries.items():
            kept = [entry for entry in entries if (stream, entry.row) not in missing]
            if stream in layouts:
                layouts[stream] = layouts[stream].select([entry.row for entry in kept])
            self._entries[stream] = [replace(entry, row=row) for row, entry in enumerate(kept)]
            self._stamps[stream] = np.array([entry.stamp for entry in kept], np.int64)
        return layouts

    def _is_there(self, entry: Entry) -> bool:
        name = entry.place.picture.file
        return name is None or self._folder.size(name) is not None

    def _add_warnings(self, found: Survey, labels: dict[str, str]) -> None:
        path, notes = self._path, self._notes
        self._warnings += report.warnings_of(path, found, labels)
        self._warnings += report.warnings_of_stamps(path, self._entries, notes)
        self._warnings += report.warnings_of_files(path, self._entries)
        self._warnings += report.warnings_of_groundtruth(path, notes, there=self.groundtruth is not None)
        if self.missing:
            name = self.missing[0].place.picture.file
            count = len(self.missing)
            what = "1 external file is" if count == 1 else f"{count} external files are"
            self._warnings.append(f"{path}: {what} missing, the first is {shortened(name or '')!r}")

    def _make_info(self, found: Survey, labels: dict[str, str], text: dict[str, TextLayout]) -> SequenceInfo:
        meta, stem = self._metadata, self._path.name.removesuffix(SUFFIX)
        return SequenceInfo(
            name=meta.name if meta else stem,
            format="rawlog",
            camera=meta.camera if meta else camera_of_name(stem),
            images={stream: self._image_info(stream, labels.get(stream, "")) for stream in self._entries},
            sources={
                **({ACCELEROMETER: labels[ACCELEROMETER]} if ACCELEROMETER in labels else {}),
                **({GROUNDTRUTH: GROUNDTRUTH_FILE} if self.groundtruth is not None else {}),
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
        if picture is None or picture.file is not None:
            place = next((entry.place for entry in entries if self._is_there(entry)), None)
            if place is not None:
                is_file = place.picture.file is not None
                picture = place.picture if is_file else Embedded(self._survey, [place]).take(place)
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
        missing = (entry.stream for entry in (self.missing if self._salvage else ()))
        yield from left_behind(self._notes, missing, has_groundtruth=self.groundtruth is not None)

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
        self._check_present(wanted)
        return self._frames(wanted)

    def present_images(self) -> Iterator[Frame]:
        """Yield the images that are there, in order of time; what is missing is in `missing`."""
        missing = {(entry.stream, entry.row) for entry in self.missing}
        every = [entry for entries in self._entries.values() for entry in entries]
        return self._frames([one for one in every if self._salvage or (one.stream, one.row) not in missing])

    def _check_present(self, wanted: list[Entry]) -> None:
        missing = [entry for entry in wanted if not self._is_there(entry)]
        if missing:
            name = missing[0].place.picture.file or ""
            raise MissingInputError(
                f"the external file is missing; object {missing[0].place.number} of {self._path.name} "
                f"names it, as {len(missing)} of its {len(wanted)} images are",
                path=self._folder.shown(name),
                hint="copy the folder of the images to the rawlog",
            )

    def _frames(self, entries: list[Entry]) -> Iterator[Frame]:
        wanted = sorted(entries, key=lambda one: (one.stamp, IMAGE_STREAMS.index(one.stream), one.row))
        embedded = Embedded(
            self._survey, [entry.place for entry in wanted if entry.place.picture.file is None]
        )
        frame_ids = self._notes.frame_ids if self._notes else {}
        for entry in wanted:
            place = entry.place
            picture = place.picture if place.picture.file is not None else embedded.take(place)
            load = partial(self._load, picture)
            yield Frame(entry.stream, entry.stamp, entry.row, load, frame_ids.get(entry.stream))

    def _load(self, picture: Picture) -> Image:
        units = self._metadata.depth_units_per_metre if self._metadata else None
        return picture.load(self._folder, None if units == _METRES else units)
