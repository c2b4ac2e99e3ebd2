# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The objects of a rawlog, one after another, whatever container and compression they are in."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from tumtools.errors import InputError
from tumtools.formats.rawlog import archive
from tumtools.formats.rawlog.alike import Alike
from tumtools.formats.rawlog.archive import Input, Record
from tumtools.formats.rawlog.classes import CODEC
from tumtools.formats.rawlog.compression import Container, Pieces
from tumtools.formats.rawlog.runs import Run, read_run

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path


@dataclass(slots=True)
class Progress:
    """Where the reading of a rawlog stands; filled in as it goes on.

    Attributes:
        container: Compression of the file.
        stored: Bytes of the file.
        inflated: Bytes of it read so far, inflated.
        objects: Objects read so far.

    """

    container: Container = "none"
    stored: int = 0
    inflated: int = 0
    objects: int = 0


@dataclass(slots=True)
class Objects:
    """The top-level objects of a rawlog as an iterable that starts anew each time.

    A file that is one `CRawlog` object is treated as what it contains, so that it is streamed too.

    Attributes:
        path: The file.
        progress: Where the latest reading stands.

    """

    path: Path
    progress: Progress = field(default_factory=Progress)

    def __iter__(self) -> Iterator[Record]:
        """Yield the objects; raises as `in_runs` does."""
        for item in self._read(runs=False):
            if isinstance(item, Record):
                yield item

    def in_runs(self) -> Iterator[Record | Run]:
        """Yield the objects; those that are like the one before them together.

        Raises:
            MissingInputError: There is no such file.
            InputError: Damage, with number and offset of the object; those before it have been given.
            UnsupportedInputError: A class that is not read.

        """
        return self._read(runs=True)

    def _read(self, *, runs: bool) -> Iterator[Record | Run]:
        with closing(Pieces(self.path)) as pieces:
            source = Input(pieces, str(self.path))
            self.progress = Progress(pieces.container, pieces.size)
            for item in top_level(source, runs=runs):
                self.progress.objects += len(item) if isinstance(item, Run) else 1
                self.progress.inflated = source.offset
                yield item
            self.progress.inflated = source.offset


def top_level(source: Input, *, runs: bool = False) -> Iterator[Record | Run]:
    """Yield the objects of a stream, a `CRawlog` as what it contains.

    Args:
        source: The stream.
        runs: Read objects that are like the one before them together, outside of a `CRawlog`.

    Raises:
        InputError: Damage, with number and offset of the object.

    """
    number, alike = 0, Alike()
    while not source.at_end():
        source.begin(f"object {number}")
        if runs and (record := alike.read(source)):
            yield record
            number += 1
            continue
        header = archive.read_header(source)
        if archive.class_of(header.name) != "CRawlog":
            record = CODEC.read_body(source, header)
            alike.remember(source, record)
            yield record
            number += 1
            if runs and (run := read_run(source, record)):
                yield run
                number += len(run)
            continue
        CODEC.check(header, source)
        for _ in range(source.u32()):
            yield CODEC.read(source)
            number += 1
            source.begin(f"object {number}")
        yield CODEC.read(source)
        archive.read_end(source, header)
        number += 1
    if number == 0:
        raise InputError("the file is empty; a rawlog has at least one object", path=source.path)
