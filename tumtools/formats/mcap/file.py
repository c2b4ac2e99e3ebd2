# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The structure of a MCAP file: by its summary where there is one, else by scanning its records."""

from __future__ import annotations

import mmap
import struct
from collections import Counter
from operator import attrgetter
from typing import TYPE_CHECKING, Final

from isal import isal_zlib

from tumtools.errors import InputError
from tumtools.formats.mcap.passed_over import PassedOver
from tumtools.formats.mcap.records import (
    FOOTER,
    FOOTER_RECORD_SIZE,
    MAGIC,
    MESSAGE_HEADER,
    RECORD_HEADER,
    Fields,
    Op,
)
from tumtools.formats.mcap.statistics import Statistics, read_statistics
from tumtools.formats.mcap.structure import ChunkPlace, RawChannel, Schema
from tumtools.formats.mcap.unpack import DAMAGED, records_of_chunk
from tumtools.formats.metadata import DIGEST_RECORD, RECORD
from tumtools.formats.ros.pages import Pages

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

_NOTES: Final = (RECORD, DIGEST_RECORD)
_ENDS: Final = frozenset({Op.FOOTER, Op.DATA_END})
LOOSE: Final = -1
"""Chunk number of messages that are in no chunk."""
_CHUNK_INDEX: Final = struct.Struct("<QQQQ")
"""First and last log time, offset and size of the chunk's record."""
_CUT_OFF: Final = "the file was cut off; --salvage reads what is there"


class McapFile:
    """The records of a MCAP file, apart from the messages.

    Args:
        path: The file.
        salvage: Read up to the damage and warn, where it would be an error.

    Attributes:
        data: The file, mapped.
        pages: To be told of what is read of it.
        schemas: By number.
        channels: By number.
        chunks: In the order of the file.
        statistics: What it says of how much it holds; None if it does not, or is salvaged.
        is_scanned: Whether all records were read for want of an index.
        scanned: Channel -> (log time, chunk, offset) of each message that was found without an index.
        notes: The metadata records named `tumtools` and `tumtools.digest`, as far as they are there.
        other_notes: How many metadata records there are besides, by name.
        attachments: How many there are.
        passed_over: What has been left out of a file that is salvaged.
        warnings: What was wrong and has been passed over.

    Raises:
        InputError: It is damaged, with the offset.

    """

    def __init__(self, path: Path, *, salvage: bool = False) -> None:
        self.path = str(path)
        try:
            with path.open("rb") as file:
                mapped = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        except OSError as error:
            raise InputError(f"cannot read: {error.strerror}", path=path) from error
        except ValueError as error:
            hint = "its recording or download was cut off"
            raise InputError("the file is empty (0 bytes)", path=path, hint=hint) from error
        self.data = memoryview(mapped)
        self.pages = Pages(mapped)
        self._salvage = salvage
        self.warnings: list[str] = []
        self.notes: dict[str, Mapping[str, str]] = {}
        self._notes_at: dict[str, int] = {}
        self.passed_over = PassedOver()
        self._start_again()
        if bytes(self.data[: len(MAGIC)]) != MAGIC:
            raise self.error("not a MCAP file", 0)
        try:
            # An index tells nothing of damage inside of a chunk, so a salvage reads them all.
            is_complete = self._read_summary()
            if self._salvage:
                self._scan_beyond_the_summary()
            elif not is_complete:
                self._scan()
        except InputError as error:
            self.read_without_index(error)

    def read_without_index(self, error: InputError) -> None:
        """Find the messages by reading the file from its beginning up to the damage, if that was asked for.

        Raises:
            InputError: The one given, unless the file is to be salvaged.

        """
        if not self._salvage:
            raise self._located(error) from error
        self.warnings.append(f"{self._told(error)}; what stands before the damage is used")
        self._scan()

    def check_counts(self, found: Mapping[int, int]) -> None:
        """Hold the number of messages of each channel against the statistics, which have a checksum.

        Raises:
            InputError: They differ.

        """
        if self.statistics is not None and (difference := self.statistics.difference(found)):
            raise self.error(
                f"the statistics count {difference}",
                self.statistics.offset,
                "the file is damaged; --salvage reads what is there",
            )

    def look_beside_the_index(self, found: Mapping[int, int]) -> None:
        """Look for messages that lie beside the chunks, if the statistics count more than an index names.

        Raises:
            InputError: The file is damaged.

        """
        if self.statistics is None or not self.statistics.difference(found):
            return
        if self.statistics.counts is None:
            # Then the summary need not describe the channels of messages that are in no chunk.
            self._scan()
            return
        offset, end = len(MAGIC), len(self.data)
        while offset < end:
            op, content, following = self.record(offset, end)
            if op in _ENDS:
                return
            self.pages.read(offset, RECORD_HEADER.size)
            if op == Op.MESSAGE:
                self._note_loose(content, offset)
            offset = following

    def _start_again(self) -> None:
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, RawChannel] = {}
        self.chunks: list[ChunkPlace] = []
        self._sound: set[int] = set()  # offsets of chunks whose CRC is right
        self.statistics: Statistics | None = None
        self.is_scanned = False
        self.scanned: dict[int, list[tuple[int, int, int]]] = {}
        self.attachments = 0
        self.other_notes: Counter[str] = Counter()
        self._metadata_records = 0

    def error(self, message: str, offset: int, hint: str | None = None) -> InputError:
        """Return an error at an offset of this file."""
        return InputError(message, path=self.path, location=f"offset {offset}", hint=hint)

    def _located(self, error: InputError) -> InputError:
        if error.path:
            return error
        return type(error)(error.message, path=self.path, location=error.location, hint=error.hint)

    def _told(self, error: InputError) -> str:
        """Return the error without its remedy, for a salvage."""
        return f"{self.path}, {error.location}: {error.message}"

    def record(self, offset: int, limit: int) -> tuple[int, memoryview, int]:
        """Return opcode, content and end of a record."""
        start = offset + RECORD_HEADER.size
        if start > limit:
            raise self.error(f"the file is cut off: a record needs {RECORD_HEADER.size} bytes", offset)
        op, length = RECORD_HEADER.unpack_from(self.data, offset)
        if length > limit - start:
            raise self.error(
                f"the record 0x{op:02x} says it has {length} bytes, {limit - start} are left",
                offset,
                _CUT_OFF,
            )
        return op, self.data[start : start + length], start + length

    def _read_summary(self) -> bool:
        """Read footer and summary; False if there is no index of chunks."""
        end = len(self.data) - len(MAGIC)
        if end < len(MAGIC) + FOOTER_RECORD_SIZE or bytes(self.data[end:]) != MAGIC:
            raise self.error(
                "the file has no footer: it does not end as a MCAP file does", len(self.data), _CUT_OFF
            )
        footer = end - FOOTER_RECORD_SIZE
        op, content, _ = self.record(footer, end)
        if op != Op.FOOTER:
            raise self.error(f"there is a record 0x{op:02x} where the footer should be", footer, _CUT_OFF)
        if len(content) != FOOTER.size:
            raise self.error(f"the footer says it has {len(content)} bytes, not {FOOTER.size}", footer)
        start, _, crc = FOOTER.unpack(content)
        if not start:
            return False
        if start > footer:
            raise self.error("the footer points outside of the file", footer)
        if crc and isal_zlib.crc32(self.data[start : end - 4]) != crc:
            raise self.error("the CRC of the summary is wrong", start, "the file is damaged; get it again")
        offset = start
        while offset < footer:
            op, content, following = self.record(offset, footer)
            self._take_record(op, content, offset)
            offset = following
        return self._is_complete()

    def _is_complete(self) -> bool:
        """Tell whether the summary repeats all that is needed; writers may leave out any part of it."""
        statistics = self.statistics
        if not self.chunks:
            return statistics is not None and statistics.counts == {}
        places = [chunk.offset for chunk in self.chunks]
        places += [offset for chunk in self.chunks for offset in chunk.index.values()]
        if len(set(places)) < len(places):
            raise self.error("the index of chunks names a place twice", min(places))
        self.chunks.sort(key=attrgetter("offset"))  # messages of one time come as they do in the file
        used = {channel for chunk in self.chunks for channel in chunk.index}
        schemas = {channel.schema for channel in self.channels.values()} - {0}
        return (
            statistics is not None  # else there may be messages in no chunk, which no index names
            and bool(self.channels)
            and used | set(statistics.counts or ()) <= self.channels.keys()
            and schemas <= self.schemas.keys()
            and (statistics.attachments, statistics.records) == (self.attachments, self._metadata_records)
        )

    def _scan_beyond_the_summary(self) -> None:
        """Read all records, and keep what the summary says of those that cannot be read."""
        channels, schemas = self.channels, self.schemas
        self.passed_over.promise(self.statistics, self.attachments, self._metadata_records)
        self._scan()
        self.channels, self.schemas = channels | self.channels, schemas | self.schemas

    def _scan(self) -> None:
        """Read all records of the data section, in order, for want of an index."""
        offset, end = len(MAGIC), len(self.data)
        statistics = None if self._salvage else self.statistics
        self._start_again()
        self.statistics, self.is_scanned = statistics, True
        while offset < end:
            try:
                op, content, following = self.record(offset, end)
                if op in _ENDS:
                    return
                if op == Op.CHUNK:
                    self._scan_chunk(offset, len(content))
                elif op == Op.MESSAGE:
                    self.pages.read(offset, following - offset)
                    self._note_loose(content, offset)
                else:
                    self._take_record(op, content, offset)
            except InputError as error:
                self._pass_over(error, end - offset, "what stands before is used")
                self.passed_over.is_cut = bytes(self.data[-len(MAGIC) :]) != MAGIC
                return
            offset = following
        self.passed_over.is_cut = True

    def _pass_over(self, error: InputError, nbytes: int, what_is_done: str) -> None:
        """Leave out so many bytes, if that was asked for.

        Raises:
            InputError: The one given, unless the file is to be salvaged.

        """
        if not self._salvage:
            raise error
        self.warnings.append(f"{self._told(error)}; {what_is_done}")
        self.passed_over.add(error, nbytes)

    def _take_record(self, op: int, content: memoryview, offset: int) -> None:
        fields = Fields(content, offset + RECORD_HEADER.size, self.path)
        if op == Op.SCHEMA:
            number = fields.number("H")
            name, encoding = fields.string(), fields.string()
            text = bytes(fields.blob()).decode("utf-8", "replace")
            self.schemas[number] = Schema(name, encoding, text)
        elif op == Op.CHANNEL:
            number, schema = fields.number("H"), fields.number("H")
            self.channels[number] = RawChannel(schema, fields.string(), fields.string(), fields.string_map())
        elif op == Op.CHUNK_INDEX:
            _, _, start, _ = fields.unpack(_CHUNK_INDEX)
            self.chunks.append(ChunkPlace(start, fields.number_map()))
        elif op == Op.STATISTICS:
            self.statistics = read_statistics(fields, offset)
        elif op == Op.METADATA_INDEX:
            self._metadata_records += 1
            place, _ = fields.number("Q"), fields.number("Q")
            name = fields.string()
            if name not in _NOTES:
                self.other_notes[name] += 1
            elif self._take_metadata(place) != name:
                raise self.error(f"the index names a metadata record {name!r} here", place)
        elif op == Op.METADATA:
            name = self._take_metadata(offset)
            self.other_notes.update([name] if name not in _NOTES else [])
        elif op in {Op.ATTACHMENT, Op.ATTACHMENT_INDEX}:
            self.attachments += 1

    def _take_metadata(self, offset: int) -> str:
        """Keep the metadata if the record is of our name; return the name."""
        op, content, _ = self.record(offset, len(self.data))
        if op != Op.METADATA:
            raise self.error(f"the index names a metadata record here, there is 0x{op:02x}", offset)
        fields = Fields(content, offset + RECORD_HEADER.size, self.path)
        name = fields.string()
        if name in _NOTES:
            if self._notes_at.setdefault(name, offset) == offset:
                self.notes[name] = fields.string_map()
            else:
                self.other_notes[name] += 1
        return name

    def _scan_chunk(self, offset: int, size: int) -> None:
        number = len(self.chunks)
        self.chunks.append(ChunkPlace(offset, {}))
        used, left = False, size
        try:
            records = self.chunk(number)
            left = len(records)
            for op, content, place in self.inner(records, offset):
                if op == Op.MESSAGE:
                    channel, _, time, _ = MESSAGE_HEADER.unpack_from(content)
                    self._note(channel, time, number, place)
                    used = True
                else:
                    self._take_record(op, content, offset)
                left = len(records) - place - RECORD_HEADER.size - len(content)
        except InputError as error:
            if not used:
                self.chunks.pop()
            self._pass_over(error, left, "the rest of this chunk is left out")

    def inner(self, records: memoryview, offset: int) -> Iterator[tuple[int, memoryview, int]]:
        """Yield opcode, content and offset of the records of a chunk."""
        place = 0
        while place < len(records):
            start = place + RECORD_HEADER.size
            length = 0
            if start <= len(records):
                op, length = RECORD_HEADER.unpack_from(records, place)
            if start + length > len(records) or (op == Op.MESSAGE and length < MESSAGE_HEADER.size):
                raise self.error(f"a record of this chunk does not fit into it, at {place}", offset)
            yield op, records[start : start + length], place
            place = start + length

    def _note(self, channel: int, time: int, chunk: int, offset: int) -> None:
        self.scanned.setdefault(channel, []).append((time, chunk, offset))

    def _note_loose(self, content: memoryview, offset: int) -> None:
        if len(content) < MESSAGE_HEADER.size:
            raise self.error("a message record without its header", offset)
        channel, _, time, _ = MESSAGE_HEADER.unpack_from(content)
        self._note(channel, time, LOOSE, offset)

    def chunk(self, number: int) -> memoryview:
        """Return the records of a chunk, uncompressed, their CRC checked when it is read first.

        Raises:
            InputError: The chunk is damaged.
            UnsupportedInputError: A compression that is not known.

        """
        offset = self.chunks[number].offset
        op, content, _ = self.record(offset, len(self.data))
        if op != Op.CHUNK:
            raise self.error(f"the index names a chunk here, there is a record 0x{op:02x}", offset)
        self.pages.read(offset, len(content))
        records, crc = records_of_chunk(content, offset, self.path)
        if crc and offset not in self._sound:
            if isal_zlib.crc32(records) != crc:
                raise self.error("the CRC of the chunk is wrong", offset, DAMAGED)
            self._sound.add(offset)
        return records
