# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What is in a ROS 1 bag that has no index, or a damaged one: found by reading all of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from tumtools.errors import InputError
from tumtools.formats.rosbag1.records import Block, Op, read_record
from tumtools.formats.rosbag1.structure import (
    ENTRY,
    BagIndex,
    Chunk,
    Connection,
    parse_chunk,
    parse_connection,
)
from tumtools.model.sequence import LEFT_OUT, RECORDING, Loss

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy.typing as npt


@dataclass(slots=True)
class Scan:
    """Finds what is in a bag by reading all of it.

    Attributes:
        file: The whole file.
        salvage: Leave out what is damaged instead of failing.
        data_end: Where the chunks should end and the index begin, if that is known; may be behind the end.
        damage: What is damaged.
        unread: Bytes of chunks that could not be read.

    """

    file: Block
    salvage: bool
    data_end: int | None = None
    connections: dict[int, Connection] = field(default_factory=dict)
    chunks: list[Chunk] = field(default_factory=list)
    entries: list[npt.NDArray[np.void]] = field(default_factory=list)
    damage: list[InputError] = field(default_factory=list)
    unread: int = 0

    def run(self, at: int) -> BagIndex:
        """Scan from this offset to the end."""
        while at < len(self.file.data):
            try:
                at = self._record(at)
            except InputError as error:
                self._damaged(error)
                if not self._cut_chunk(at):
                    self.unread += max(min(self.data_end or len(self.file.data), len(self.file.data)) - at, 0)
                break
        if at > len(self.file.data):
            self._damaged(self.file.damage("the file ends within the bag's header", len(self.file.data)))
        warnings = [
            f"damage at {error.location}: {error.message}; this is left out" for error in self.damage[:5]
        ]
        if len(self.damage) > len(warnings):
            warnings.append(f"damage at {len(self.damage) - len(warnings)} more places")
        entries = np.concatenate(self.entries) if self.entries else np.empty(0, ENTRY)
        known = np.isin(
            entries["connection"], np.fromiter(self.connections, np.uint32, len(self.connections))
        )
        if not known.all():
            unknown = sorted(set(entries["connection"][~known].tolist()))
            self._damaged(self.file.damage(f"messages of unknown connections {unknown[:5]}", at))
            warnings.append(
                f"{int((~known).sum())} messages of unknown connections {unknown[:5]} are left out"
            )
        losses = tuple(self._left_out(int((~known).sum())))
        return BagIndex(self.connections, self.chunks, entries[known], tuple(warnings), losses)

    def _left_out(self, unknown: int) -> Iterator[Loss]:
        if self.unread:
            first = self.damage[0]
            yield Loss(RECORDING, f"bytes {LEFT_OUT}", self.unread, f"{first.location}: {first.message}")
        if unknown:
            yield Loss(RECORDING, f"messages {LEFT_OUT}", unknown, "their connections are not known")
        missing = (self.data_end or 0) - len(self.file.data)
        if missing > 0:
            yield Loss(RECORDING, "bytes missing at its end", missing, "the file was cut or not finished")

    def _damaged(self, error: InputError) -> None:
        if not self.salvage:
            raise error
        self.damage.append(error)

    def _record(self, at: int) -> int:
        """Take in the record at an offset of the file, and return the offset of the next one."""
        record = read_record(self.file, at)
        if record.op == Op.CHUNK:
            if record.data_start == record.data_end:
                return self._open_chunk(record.data_end)
            self._content(parse_chunk(record))
        elif record.op == Op.CONNECTION:
            number, connection = parse_connection(record)
            self.connections[number] = connection
        elif record.op not in (Op.INDEX, Op.CHUNK_INFO, Op.BAG_HEADER):
            raise self.file.damage(f"a record with op {record.op} between the chunks", at)
        return record.data_end

    def _open_chunk(self, at: int) -> int:
        """Take in a chunk whose recorder was killed: its header still says 0 bytes."""
        end = len(self.file.data)
        try:
            if at < end and read_record(self.file, at).op not in (Op.CONNECTION, Op.MESSAGE):
                return at
        except InputError as error:
            self._damaged(error)
            self.unread += end - at
            return end
        self._content(Chunk(at, "none", end - at, at, end))
        return end

    def _cut_chunk(self, at: int) -> bool:
        """Take in the uncompressed chunk at the end of a file that was cut; tell whether there is one."""
        try:
            record = read_record(self.file, at, cut=True)
            if record.op == Op.CHUNK and record.text(b"compression") == "none":
                size = record.data_end - record.data_start
                self._content(Chunk(at, "none", size, record.data_start, record.data_end))
                return True
        except InputError:
            pass  # the damage at this place is known already
        return False

    def _content(self, chunk: Chunk) -> None:
        """Index the messages of a chunk; damage ends the chunk, not the scan."""
        rows: list[tuple[int, int, int, int]] = []
        at, size = 0, chunk.end - chunk.start
        try:
            block = chunk.load(self.file)
            size = len(block.data)
            while at < len(block.data):
                record = read_record(block, at)
                if record.op == Op.MESSAGE:
                    rows.append((record.time(b"time"), len(self.chunks), at, record.number(b"conn", 4)))
                elif record.op == Op.CONNECTION:
                    number, connection = parse_connection(record)
                    self.connections[number] = connection
                elif record.op not in (Op.INDEX, Op.CHUNK_INFO):  # these follow a chunk that was left open
                    raise block.damage(f"a record with op {record.op} inside a chunk", at)
                at = record.data_end
        except InputError as error:
            self._damaged(error)
            self.unread += size - at
        self.chunks.append(chunk)
        self.entries.append(np.array(rows, ENTRY))
