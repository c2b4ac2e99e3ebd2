# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A MCAP file as a recording: its channels, and messages in order of log time."""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.errors import InputError
from tumtools.formats.mcap.file import LOOSE, TOUCHED_BYTES, McapFile
from tumtools.formats.mcap.records import MESSAGE_HEADER, RECORD_HEADER, Fields, Op
from tumtools.formats.metadata import DIGEST_RECORD, RECORD
from tumtools.formats.ros.definitions import full_name
from tumtools.formats.ros.qos import is_latched
from tumtools.formats.ros.recording import Channel, MessageEncoding, RawMessage, Recording
from tumtools.model.sequence import Loss

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator
    from pathlib import Path

    import numpy.typing as npt

_CACHED_CHUNKS: Final = 8
_CACHED_BYTES: Final = 1 << 25
_ENCODINGS: Final[dict[tuple[str, str], MessageEncoding]] = {
    ("ros2msg", "cdr"): "cdr",
    ("ros1msg", "ros1"): "ros1",
}
_NO_ENTRIES: Final = np.empty((0, 3), np.int64)


class McapRecording(Recording):
    """An open MCAP file.

    Args:
        path: The file.
        salvage: Read up to the damage and warn, where it would be an error.

    Raises:
        InputError: It is damaged, with the offset.

    """

    format = "mcap"

    def __init__(self, path: Path, *, salvage: bool = False) -> None:
        self._file = McapFile(path, salvage=salvage)
        self.path = self._file.path
        self._chunks: OrderedDict[int, memoryview] = OrderedDict()
        self._index = self._read_index()
        self.metadata = self._file.notes.get(RECORD)
        self.digest = self._file.notes.get(DIGEST_RECORD)
        self.channels = tuple(self._make_channels())
        if self._file.attachments:
            why = "attachments are no part of a sequence"
            self.not_carried = (Loss("attachments", "not carried over", self._file.attachments, why),)
        self.warnings = tuple(self._file.warnings)

    def _make_channels(self) -> Iterator[Channel]:
        for number, channel in sorted(self._file.channels.items()):
            schema = self._file.schemas.get(channel.schema)
            name, kind, definition = (
                (schema.name, schema.encoding, schema.definition) if schema else ("", "", "")
            )
            encoding = _ENCODINGS.get((kind, channel.encoding))
            if encoding is None:
                # Not of ROS (protobuf, JSON, flatbuffer): named, and left alone.
                encoding, definition = "cdr", ""
                name = f"{kind or channel.encoding}/{name or 'unknown'}"
            if self._file.counts is not None:
                count = self._file.counts.get(number, 0)
            else:
                count = len(self._index.get(number, _NO_ENTRIES))
            qos = channel.extra.get("offered_qos_profiles", "")
            latched = is_latched(qos) or channel.extra.get("latching") == "1"
            yield Channel(number, channel.topic, full_name(name), encoding, definition, count, latched)

    def _read_index(self) -> dict[int, npt.NDArray[np.int64]]:
        """Return log time, chunk and offset of the messages of each channel, shape [n, 3], in order."""
        try:
            index = self._gather_index()
            self._file.check_counts({channel: len(entries) for channel, entries in index.items()})
        except InputError as error:
            self._file.read_without_index(error)
            return self._gather_index()
        return index

    def _gather_index(self) -> dict[int, npt.NDArray[np.int64]]:
        found: dict[int, list[npt.NDArray[np.int64]]] = {}
        for channel, rows in self._file.scanned.items():
            found.setdefault(channel, []).append(np.array(rows, np.int64))
        for number, chunk in enumerate(self._file.chunks):
            if not self._file.scanned:
                for channel, entries in self._chunk_index(number, dict(chunk.index)):
                    found.setdefault(channel, []).append(entries)
        return {channel: _sorted(np.concatenate(parts)) for channel, parts in found.items()}

    def _chunk_index(
        self, number: int, offsets: dict[int, int]
    ) -> Iterator[tuple[int, npt.NDArray[np.int64]]]:
        if not offsets:
            yield from self._index_by_reading(number)
        for channel, offset in offsets.items():
            self._file.note_read(TOUCHED_BYTES)
            op, content, _ = self._file.record(offset, len(self._file.data))
            fields = Fields(content, offset + RECORD_HEADER.size, self.path)
            if op != Op.MESSAGE_INDEX or fields.number("H") != channel:
                raise self._file.error(f"there is no message index of channel {channel} here", offset)
            pairs = np.frombuffer(fields.index_entries(), "<i8").reshape(-1, 2)
            entries = np.empty((len(pairs), 3), np.int64)
            entries[:, 0], entries[:, 1], entries[:, 2] = pairs[:, 0], number, pairs[:, 1]
            yield channel, entries

    def _index_by_reading(self, number: int) -> Iterator[tuple[int, npt.NDArray[np.int64]]]:
        found: dict[int, list[tuple[int, int, int]]] = {}
        for op, content, place in self._file.inner(self._chunk(number), self._file.chunks[number].offset):
            if op == Op.MESSAGE:
                channel, _, time, _ = MESSAGE_HEADER.unpack_from(content)
                found.setdefault(channel, []).append((time, number, place))
        for channel, rows in found.items():
            yield channel, np.array(rows, np.int64)

    def log_times(self, channel: Channel) -> npt.NDArray[np.int64]:
        """Return the log times of a channel, from the index."""
        return self._index.get(channel.id, _NO_ENTRIES)[:, 0].copy()

    def messages(
        self, channels: Collection[Channel], start: int | None = None, end: int | None = None
    ) -> Iterator[RawMessage]:
        """Yield messages in order of (log time, chunk, offset); reads only chunks that hold some of them."""
        by_id = {channel.id: channel for channel in channels}
        parts = [self._index[number] for number in by_id if number in self._index]
        if not parts:
            return
        entries = _sorted(np.concatenate(parts))
        if start is not None:
            entries = entries[entries[:, 0] >= start]
        if end is not None:
            entries = entries[entries[:, 0] <= end]
        for time, chunk, offset in entries.tolist():
            channel, recorded, data = self._message(chunk, offset)
            if channel not in by_id or recorded != time:
                # No checksum covers an index of messages.
                place = self._file.chunks[chunk].offset if chunk != LOOSE else offset
                raise self._file.error(
                    f"the message index is wrong: it says {time} ns for the message at {offset} of this "
                    f"chunk, which is of channel {channel} and says {recorded} ns",
                    place,
                    "the file is damaged; get it again",
                )
            yield RawMessage(by_id[channel], time, data)

    def _message(self, chunk: int, offset: int) -> tuple[int, int, memoryview]:
        records = self._file.data if chunk == LOOSE else self._chunk(chunk)
        start = offset + RECORD_HEADER.size
        place = offset if chunk == LOOSE else self._file.chunks[chunk].offset
        if not 0 <= offset <= len(records) - RECORD_HEADER.size - MESSAGE_HEADER.size:
            raise self._file.error(f"the index names a message at {offset}, outside of the chunk", place)
        op, length = RECORD_HEADER.unpack_from(records, offset)
        channel, _, time, _ = MESSAGE_HEADER.unpack_from(records, start)
        if op != Op.MESSAGE or length < MESSAGE_HEADER.size or start + length > len(records):
            raise self._file.error(f"the index names a message at {offset} where there is none", place)
        if chunk == LOOSE:
            self._file.note_read(length)
        return channel, time, records[start + MESSAGE_HEADER.size : start + length]

    def _chunk(self, number: int) -> memoryview:
        records = self._chunks.get(number)
        if records is None:
            records = self._chunks[number] = self._file.chunk(number)
            while len(self._chunks) > 1 and (
                len(self._chunks) > _CACHED_CHUNKS or sum(map(len, self._chunks.values())) > _CACHED_BYTES
            ):
                self._chunks.popitem(last=False)
        else:
            self._chunks.move_to_end(number)
        return records

    def close(self) -> None:
        """Forget what is cached; the mapping goes with the last view of it."""
        self._chunks.clear()


def _sorted(entries: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    return entries[np.lexsort((entries[:, 2], entries[:, 1], entries[:, 0]))]
