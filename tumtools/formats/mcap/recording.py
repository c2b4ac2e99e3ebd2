# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A MCAP file as a recording: its channels, and messages in order of log time."""

from __future__ import annotations

import struct
from collections import OrderedDict
from contextlib import closing
from threading import Lock
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.errors import InputError
from tumtools.formats.mcap.channels import channels_of
from tumtools.formats.mcap.file import LOOSE, McapFile
from tumtools.formats.mcap.records import CHUNK_HEADER, INDEX_ENTRY, MESSAGE_HEADER, RECORD_HEADER, Fields, Op
from tumtools.formats.metadata import DIGEST_RECORD, RECORD
from tumtools.formats.ros.batches import BATCH, Batch, in_batches, is_interleaved, rows_at
from tumtools.formats.ros.recording import Channel, RawMessage, Recording
from tumtools.images.parallel import ordered_map
from tumtools.model.sequence import RECORDING, Loss, sum_losses

if TYPE_CHECKING:
    from collections.abc import Collection, Generator, Iterator, Mapping
    from pathlib import Path

    import numpy.typing as npt

_CACHED_CHUNKS: Final = 8
_CACHED_BYTES: Final = 1 << 25
_HEAD: Final = struct.Struct("<BQHIqq")
"""`RECORD_HEADER` and `MESSAGE_HEADER`."""
_HEADS: Final = np.dtype(
    [
        ("op", "u1"),
        ("length", "<u8"),
        ("channel", "<u2"),
        ("sequence", "<u4"),
        ("recorded", "<i8"),
        ("published", "<i8"),
    ]
)
"""The same as columns."""
_INDEX_HEAD: Final = struct.Struct("<BQHI")
"""Head of a message index: the record's, the channel, bytes of entries."""
_NO_CHUNK: Final = LOOSE - 1
_MESSAGE: Final = int(Op.MESSAGE)
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
        self._lock = Lock()
        self._closed = False
        self._index = self._read_index()
        self.metadata = self._file.notes.get(RECORD)
        self.digest = self._file.notes.get(DIGEST_RECORD)
        self._channel_of = channels_of(self._file.channels, self._file.schemas, _counts(self._index))
        self.channels = tuple({channel.id: channel for channel in self._channel_of.values()}.values())
        self.not_carried = tuple(self._besides())
        self.left_out = sum_losses(self._passed_over())
        self.warnings = tuple(self._file.warnings)

    def _besides(self) -> Iterator[Loss]:
        """Yield what is in the file besides messages."""
        if self._file.attachments:
            why = "attachments are no part of a sequence"
            yield Loss("attachments", "not carried over", self._file.attachments, why)
        for name, count in sorted(self._file.other_notes.items()):
            why = "a sequence has no place for the metadata records of others"
            yield Loss(f"metadata {name}", "record not carried over", count, why)
        unknown = sum(
            len(entries) for number, entries in self._index.items() if number not in self._file.channels
        )
        if unknown:
            why = "the file does not say of which topic they are"
            yield Loss(RECORDING, "messages of unknown channels not carried over", unknown, why)

    def _passed_over(self) -> Iterator[Loss]:
        """Yield what has been left out of a file that is salvaged."""
        file = self._file
        topics = {number: channel.topic for number, channel in file.channels.items()}
        records = len(file.notes) + file.other_notes.total()
        return file.passed_over.losses(_counts(self._index), topics, file.attachments, records)

    def _read_index(self) -> dict[int, npt.NDArray[np.int64]]:
        """Return log time, chunk and offset of the messages of each channel, shape [n, 3], in order."""
        file = self._file
        try:
            index: dict[int, npt.NDArray[np.int64]] = {}
            if not file.is_scanned:
                index = self._index_of_chunks()
                file.look_beside_the_index(_counts(index))
            index = self._with_scanned({} if file.is_scanned else index)
            self._check_places(index)
            file.check_counts(_counts(index))
        except InputError as error:
            file.read_without_index(error)
            index = self._with_scanned({})
        return {channel: self._sorted(entries) for channel, entries in index.items()}

    def _check_places(self, index: Mapping[int, npt.NDArray[np.int64]]) -> None:
        """Refuse an index that names one message twice, in place of another: no checksum covers it."""
        places = np.concatenate([_NO_ENTRIES, *index.values()])[:, 1:]
        places = places[np.lexsort((places[:, 1], places[:, 0]))]
        twice = np.flatnonzero((places[1:] == places[:-1]).all(axis=1))
        if len(twice):
            chunk, offset = places[twice[0]].tolist()
            message = f"the message index names the message at {offset} of this chunk twice"
            raise self._wrong(
                chunk, message, offset, "the file is damaged; --salvage reads it without its index"
            )

    def _index_of_chunks(self) -> dict[int, npt.NDArray[np.int64]]:
        found: dict[int, list[tuple[int, bytes]]] = {}
        for number, chunk in enumerate(self._file.chunks):
            for channel, entries in self._chunk_index(number, chunk.index):
                found.setdefault(channel, []).append((number, entries))
        return {channel: _with_chunks(parts) for channel, parts in found.items()}

    def _with_scanned(self, index: Mapping[int, npt.NDArray[np.int64]]) -> dict[int, npt.NDArray[np.int64]]:
        """Return an index together with what was found without one."""
        scanned = {channel: np.array(rows, np.int64) for channel, rows in self._file.scanned.items()}
        return {
            channel: np.concatenate([one[channel] for one in (index, scanned) if channel in one])
            for channel in sorted(index.keys() | scanned.keys())
        }

    def _sorted(self, entries: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
        """Return entries (log time, chunk and offset first) in order of log time and place in the file."""
        chunks, offsets = entries[:, 1], entries[:, 2]
        places = chunks
        if (chunks == LOOSE).any():  # else the order of chunks is that of their places
            starts = np.array([*(chunk.offset for chunk in self._file.chunks), 0], np.uint64)
            places = np.where(chunks == LOOSE, offsets.astype(np.uint64), starts[chunks])
        return entries[np.lexsort((offsets, places, entries[:, 0]))]

    def _chunk_index(self, number: int, offsets: Mapping[int, int]) -> Iterator[tuple[int, bytes]]:
        """Yield the message index of each channel: its entries as they are in the file."""
        if not offsets:
            yield from self._index_by_reading(number)
        data = self._file.data
        for channel, offset in offsets.items():
            # A file of an hour has a hundred thousand of these, so what is as usual takes few steps.
            if offset + _INDEX_HEAD.size <= len(data):
                op, length, of, nbytes = _INDEX_HEAD.unpack_from(data, offset)
                start = offset + _INDEX_HEAD.size
                usual = op == Op.MESSAGE_INDEX and length == nbytes + 6 and not nbytes % INDEX_ENTRY.size
                if usual and of == channel and start + nbytes <= len(data):
                    self._file.pages.read(offset, _INDEX_HEAD.size + nbytes)
                    yield channel, bytes(data[start : start + nbytes])
                    continue
            op, content, _ = self._file.record(offset, len(data))
            fields = Fields(content, offset + RECORD_HEADER.size, self.path)
            if op != Op.MESSAGE_INDEX or fields.number("H") != channel:
                raise self._file.error(f"there is no message index of channel {channel} here", offset)
            yield channel, bytes(fields.index_entries())

    def _index_by_reading(self, number: int) -> Iterator[tuple[int, bytes]]:
        found: dict[int, list[bytes]] = {}
        for op, content, place in self._file.inner(self._chunk(number), self._file.chunks[number].offset):
            if op == Op.MESSAGE:
                channel, _, time, _ = MESSAGE_HEADER.unpack_from(content)
                found.setdefault(channel, []).append(INDEX_ENTRY.pack(time, place))
        for channel, entries in found.items():
            yield channel, b"".join(entries)

    def log_times(self, channel: Channel) -> npt.NDArray[np.int64]:
        """Return the log times of a channel, from the index."""
        times = [self._index.get(number, _NO_ENTRIES)[:, 0] for number in self._numbers([channel])]
        return np.sort(np.concatenate([np.empty(0, np.int64), *times]), kind="stable")

    def messages(
        self, channels: Collection[Channel], start: int | None = None, end: int | None = None
    ) -> Iterator[RawMessage]:
        """Yield messages in order of (log time, chunk, offset); reads only chunks that hold some of them."""
        by_number = self._numbers(channels)
        entries = self._entries(by_number)
        if start is not None:
            entries = entries[entries[:, 0] >= start]
        if end is not None:
            entries = entries[entries[:, 0] <= end]
        for chunk, records, part in self._parts(entries):
            yield from self._messages_of(chunk, records, part, by_number)

    def batches(self, channels: Collection[Channel]) -> Iterator[Batch]:
        """Yield small messages many at a time; those of each channel in order of log time.

        Raises:
            InputError: As `messages`.

        """
        by_number = self._numbers(channels)
        groups: dict[int, list[int]] = {}
        for number, channel in by_number.items():
            groups.setdefault(channel.id, []).append(number)
        entries = self._entries(by_number)
        if is_interleaved(entries[:, 1]):
            yield from in_batches(self.messages(channels))
            return
        for chunk, records, part in self._parts(entries):
            data = np.frombuffer(records, np.uint8)
            # What is in no chunk may lie far apart, so its pages are given back message by message.
            heads = None if chunk == LOOSE else _heads(data, part)
            if heads is None:
                yield from in_batches(self._messages_of(chunk, records, part, by_number))
                continue
            lengths = heads["length"].astype(np.int64) - MESSAGE_HEADER.size
            for numbers in groups.values():
                own = np.flatnonzero(np.logical_or.reduce([part[:, 3] == number for number in numbers]))
                if len(own):
                    starts = part[own, 2] + _HEAD.size
                    yield Batch(by_number[numbers[0]], part[own, 0], data, starts, lengths[own])

    def _messages_of(
        self, chunk: int, records: memoryview, part: npt.NDArray[np.int64], by_number: Mapping[int, Channel]
    ) -> Iterator[RawMessage]:
        """Yield the messages that some entries name in one chunk."""
        for time, _, offset, channel in part.tolist():
            data = self._message(chunk, records, offset, time, channel)
            if chunk == LOOSE:
                self._file.pages.read(offset, len(data))
            yield RawMessage(by_number[channel], time, data)

    def _numbers(self, channels: Collection[Channel]) -> dict[int, Channel]:
        """Return some of the channels by the numbers that they have in the file."""
        by_id = {channel.id: channel for channel in channels}
        return {number: by_id[one.id] for number, one in self._channel_of.items() if one.id in by_id}

    def _entries(self, numbers: Collection[int]) -> npt.NDArray[np.int64]:
        """Return log time, chunk, offset and number of the channel of some messages, in order."""
        parts = [
            np.insert(self._index[number], 3, number, axis=1) for number in numbers if number in self._index
        ]
        return self._sorted(np.concatenate(parts)) if parts else np.empty((0, 4), np.int64)

    def _parts(
        self, entries: npt.NDArray[np.int64]
    ) -> Iterator[tuple[int, memoryview, npt.NDArray[np.int64]]]:
        """Yield the number of a chunk, its records, and some entries that follow each other there."""
        if not len(entries):
            return
        starts = np.flatnonzero(np.diff(entries[:, 1], prepend=_NO_CHUNK))
        chunks = entries[starts, 1].tolist()
        parts = np.split(entries, starts[1:])
        for chunk, records, part in zip(chunks, self._in_turn(chunks), parts, strict=True):
            for first in range(0, len(part), BATCH):
                yield chunk, records, part[first : first + BATCH]

    def _message(self, chunk: int, records: memoryview, offset: int, time: int, channel: int) -> memoryview:
        """Return the data of the message that the index names at an offset of a chunk."""
        if not 0 <= offset <= len(records) - _HEAD.size:
            raise self._wrong(chunk, f"the index names a message at {offset}, outside of the chunk", offset)
        op, length, found, _, recorded, _ = _HEAD.unpack_from(records, offset)
        end = offset + RECORD_HEADER.size + length
        if op != _MESSAGE or length < MESSAGE_HEADER.size or end > len(records):
            message = f"the index names a message at {offset} where there is none"
            raise self._wrong(chunk, message, offset)
        if found != channel or recorded != time:
            # No checksum covers an index of messages.
            message = (
                f"the message index is wrong: it says channel {channel} and {time} ns for the message at "
                f"{offset} of this chunk, which is of channel {found} and says {recorded} ns"
            )
            raise self._wrong(chunk, message, offset, "the file is damaged; get it again")
        return records[offset + _HEAD.size : end]

    def _wrong(self, chunk: int, message: str, offset: int, hint: str | None = None) -> InputError:
        """Return an error of the index of a chunk; its offset is that of the chunk if there is one."""
        return self._file.error(message, offset if chunk == LOOSE else self._file.chunks[chunk].offset, hint)

    def _in_turn(self, chunks: list[int]) -> Iterator[memoryview]:
        """Yield the records of chunks, or the whole file for messages that are in none."""
        packed = [chunk for chunk in chunks if chunk != LOOSE]
        turns = [chunk for chunk, before in zip(packed, [LOOSE, *packed], strict=False) if chunk != before]
        current, records = LOOSE, self._file.data
        with closing(self._ahead(turns)) as ahead:
            for chunk in chunks:
                if chunk not in {LOOSE, current}:
                    current, records = chunk, next(ahead)
                yield self._file.data if chunk == LOOSE else records

    def _ahead(self, chunks: list[int]) -> Generator[memoryview, None, None]:
        """Yield the records of chunks; while one is used, the next is read and checked by another thread."""
        yield from map(self._chunk, chunks[:1])
        jobs = 2 if all(map(self._is_small, chunks)) else 1
        yield from ordered_map(self._chunk, chunks[1:], jobs, window=2)

    def _is_small(self, number: int) -> bool:
        """Tell whether there is memory enough to read another chunk of this size ahead."""
        start = self._file.chunks[number].offset + RECORD_HEADER.size
        if start + CHUNK_HEADER.size > len(self._file.data):
            return False
        self._file.pages.read(start, CHUNK_HEADER.size)
        _, _, size, _ = CHUNK_HEADER.unpack_from(self._file.data, start)
        return int(size) <= _CACHED_BYTES // _CACHED_CHUNKS

    def _chunk(self, number: int) -> memoryview:
        """Return the records of a chunk."""
        with self._lock:
            if self._closed:
                raise ValueError("the recording is closed")
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
        with self._lock:  # no thread reads ahead any more: the file may be overwritten now
            self._closed = True
            self._chunks.clear()


def _heads(data: npt.NDArray[np.uint8], entries: npt.NDArray[np.int64]) -> npt.NDArray[np.void] | None:
    """Return the heads of the messages that an index names, shape [n]; None if one of them is wrong.

    None also if they have more bytes than there are: one that is named again and again would be copied as
    often.

    Args:
        data: The records of a chunk.
        entries: Log time, chunk, offset and channel, shape [n, 4].

    """
    times, offsets, channels = entries[:, 0], entries[:, 2], entries[:, 3]
    if offsets.min() < 0 or offsets.max() > len(data) - _HEAD.size:
        return None
    heads = rows_at(data, offsets, _HEAD.size).view(_HEADS)[:, 0]
    room = (len(data) - RECORD_HEADER.size - offsets).astype(np.uint64)
    right = (heads["op"] == _MESSAGE) & (heads["recorded"] == times) & (heads["channel"] == channels)
    right &= (heads["length"] >= MESSAGE_HEADER.size) & (heads["length"] <= room)
    return heads if right.all() and int(heads["length"].sum()) <= len(data) else None


def _with_chunks(parts: list[tuple[int, bytes]]) -> npt.NDArray[np.int64]:
    """Join the entries of several chunks; return log time, chunk and offset, shape [n, 3]."""
    pairs = np.frombuffer(b"".join([entries for _, entries in parts]), "<i8").reshape(-1, 2)
    counts = [len(entries) // INDEX_ENTRY.size for _, entries in parts]
    chunks = np.repeat(np.array([number for number, _ in parts], np.int64), counts)
    return np.stack([pairs[:, 0], chunks, pairs[:, 1]], axis=1)


def _counts(index: Mapping[int, npt.NDArray[np.int64]]) -> dict[int, int]:
    return {channel: len(entries) for channel, entries in index.items()}
