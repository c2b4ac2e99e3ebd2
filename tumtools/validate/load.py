# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Open a source for checking, and look at each of its images once."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from tumtools.errors import InputError, UsageError
from tumtools.formats import registry
from tumtools.formats.options import Progress, ReadOptions, no_progress
from tumtools.formats.rawlog.reader import RawlogSequence
from tumtools.formats.ros.incoming import RosSequence
from tumtools.formats.ros.inspection import inspect
from tumtools.formats.tum.reader import TrajectoryFile, TumSequence, open_tolerant
from tumtools.images.parallel import batch_of, ordered_map
from tumtools.kept_digest import Watch
from tumtools.sources import locate
from tumtools.validate.frames import FrameFacts, measure
from tumtools.validate.subject import Subject, TextFile

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    import numpy as np
    import numpy.typing as npt

    from tumtools.model.sequence import Frame, Sequence


def load(
    source: str | Path,
    options: ReadOptions | None = None,
    *,
    full: bool = True,
    jobs: int = 2,
    progress: Progress = no_progress,
) -> Subject:
    """Open a source and gather all that the rules look at; what cannot be read is in `Subject.damage`.

    Args:
        source: A path in any format, or a catalogue name.
        options: How to read it.
        full: Decode every image; else only text, listings and headers.
        jobs: Threads that decode.
        progress: Told of each image.

    """
    options = options or ReadOptions()
    subject = Subject(str(source), str(source), salvage=options.salvage)
    try:
        path = locate(source)
        subject.path, subject.is_folder = str(path), path.is_dir()
        entry = registry.detect(path)
        subject.format = entry.name
        if entry.name == "tum":
            sequence: Sequence = open_tolerant(path)
        else:
            sequence = _open(entry, path, options, subject)
    except InputError as error:
        _note(subject, error)
        return subject
    except UsageError as error:
        # That several topics could be meant, or none of those asked for, is about this source only.
        subject.unclear = error
        return subject
    with sequence:
        _describe(subject, sequence)
        if full:
            _measure(subject, sequence, jobs, progress)
        else:
            _read_headers(subject, sequence)
    return subject


def gather(source: str | Path, sequence: Sequence, path: Path) -> Subject:
    """Return what the rules at the level `quick` look at, of a sequence that is open."""
    subject = Subject(str(source), str(path), path.is_dir(), sequence.info.format)
    _describe(subject, sequence)
    _read_headers(subject, sequence)
    return subject


def _open(entry: registry.Format, path: Path, options: ReadOptions, subject: Subject) -> Sequence:
    """Open a recording; a damaged one as far as it can be read, with the damage noted in any case."""
    try:
        return entry.reader.open(path, replace(options, salvage=False))
    except InputError as error:
        _note(subject, error)
        return entry.reader.open(path, replace(options, salvage=True))


def _note(subject: Subject, error: InputError) -> None:
    """Note damage, that which is found again with `salvage` once only."""
    if str(error) not in map(str, subject.damage):
        subject.damage.append(error)


def _describe(subject: Subject, sequence: Sequence) -> None:
    subject.info = sequence.info
    subject.stamps = {stream: sequence.image_stamps(stream) for stream in sequence.info.images}
    subject.groundtruth, subject.accelerometer = sequence.groundtruth, sequence.accelerometer
    if isinstance(sequence, TrajectoryFile):
        subject.texts = {"groundtruth": TextFile("", sequence.table)}
        head = sequence.table.layout.head.lower()
        subject.is_estimate = "groundtruth" not in sequence.info.name.lower() and "ground truth" not in head
    elif isinstance(sequence, TumSequence):
        subject.texts = {
            stream: TextFile(name, sequence.tables[stream], sequence.damaged.get(stream))
            for stream, name in sequence.files.items()
        }
        subject.sizes, subject.names = sequence.sizes, sequence.names
    elif isinstance(sequence, RawlogSequence):
        for one in sequence.missing:
            name = one.place.picture.file or ""
            subject.missing.setdefault(one.stream, []).append((one.row, one.stamp, name))
    elif isinstance(sequence, RosSequence):
        try:
            subject.recording = inspect(sequence)
        except InputError as error:
            subject.damage.append(error)


def _measure(subject: Subject, sequence: Sequence, jobs: int, progress: Progress) -> None:
    """Look at every image, decoded by several threads."""
    watch = None if sequence.info.digest is None else Watch(sequence, sequence.info.digest)

    def look(frame: Frame) -> tuple[FrameFacts, npt.NDArray[np.int64] | None]:
        return measure(frame if watch is None else watch.frame(frame), decode=True)

    for measured, histogram in ordered_map(look, _images(subject, sequence), jobs, batch=batch_of(sequence)):
        facts = measured
        if facts.error is not None and isinstance(sequence, TumSequence) and facts.stream == "depth":
            facts = _kind_of_depth(sequence, facts)
        subject.frames.setdefault(facts.stream, []).append(facts)
        if histogram is not None:
            subject.depth_histogram += histogram
        progress(1, 0)
    subject.digests = [] if watch is None else watch.checks()


def _kind_of_depth(sequence: TumSequence, facts: FrameFacts) -> FrameFacts:
    """Tell an image that is no depth image, which the reader refuses, from one that is damaged."""
    header = _header_facts(sequence, facts.stream, facts.row, facts.stamp)
    return facts if header.error is not None or header.encoding == "16UC1" else header


def _images(subject: Subject, sequence: Sequence) -> Iterator[Frame]:
    """Yield the images up to where the source is damaged."""
    try:
        # What is missing is told by name and does not stop the rest.
        yield from sequence.present_images() if isinstance(sequence, RawlogSequence) else sequence.images()
    except InputError as error:
        subject.damage.append(error)


def _read_headers(subject: Subject, sequence: Sequence) -> None:
    """Look at the PNG headers of a TUM folder; other formats have theirs in `SequenceInfo`."""
    if not isinstance(sequence, TumSequence) or not subject.is_folder:
        return
    for stream, names in sequence.names.items():
        stamps = subject.stamps[stream].tolist()
        subject.frames[stream] = [
            _header_facts(sequence, stream, row, stamps[row])
            for row in range(len(names))
            if names[row] in sequence.sizes
        ]


def _header_facts(sequence: TumSequence, stream: str, row: int, stamp: int) -> FrameFacts:
    try:
        header = sequence.png_header(stream, row)
    except InputError as error:
        return FrameFacts(stream, row, stamp, error=error)
    kind = (header.bit_depth, header.colour_type)
    return FrameFacts(stream, row, stamp, header.width, header.height, header.encoding, kind)
