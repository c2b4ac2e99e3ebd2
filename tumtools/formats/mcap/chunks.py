# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Gather messages to chunks: images one by one, the many small messages of signals in runs.

Payloads that are kept as they are stay buffers of their own, which nobody copies.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, NamedTuple

import lz4.frame
import numpy as np
import zstandard
from isal import isal_zlib

from tumtools.formats.mcap.records import MESSAGE_HEADER, RECORD_HEADER, Op

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    import numpy.typing as npt

    from tumtools.formats.ros.recording import OutMessage
    from tumtools.formats.ros.rows import Rows

CHUNK_BYTES: Final = 1 << 20
"""A chunk is closed before the message that would make it larger, unless it holds nothing else."""
_ZSTD_LEVEL: Final = 1
_LARGE: Final = 1 << 14
"""A buffer of this size is not copied."""
_BLOCK: Final = 2048
"""Messages of signals that are serialised at a time."""
_HEAD: Final = np.dtype(
    [
        ("op", "u1"),
        ("length", "<u8"),
        ("channel", "<u2"),
        ("sequence", "<u4"),
        ("log_time", "<i8"),
        ("publish_time", "<i8"),
    ]
)
"""`RECORD_HEADER` and `MESSAGE_HEADER`."""

Buffer = bytes | bytearray | memoryview


class _Run(NamedTuple):
    """Records of consecutive messages, in order.

    Attributes:
        channels: Number of the channel of each.
        stamps: Log times.
        starts: Where each begins in `data`; one more entry tells where the last one ends.
        data: The records.

    """

    channels: npt.NDArray[np.int64]
    stamps: npt.NDArray[np.int64]
    starts: npt.NDArray[np.int64]
    data: memoryview

    def cut(self, start: int, end: int) -> _Run:
        return _Run(
            self.channels[start:end],
            self.stamps[start:end],
            self.starts[start : end + 1] - self.starts[start],
            self.data[int(self.starts[start]) : int(self.starts[end])],
        )


@dataclass(slots=True)
class Chunk:
    """Messages that are written together.

    Attributes:
        stored: Whether they are written as they are, because they are compressed already.
        size: Bytes of the records.
        first: Least log time.
        last: Greatest log time.
        frames: Images.
        payload: Bytes of the messages without what MCAP adds.
        index: Channel -> its entries in the index of the chunk, packed; complete when it is finished.
        compression: Name; empty for none.
        crc: Of the records.
        body: What is written.
        body_size: Bytes of it.
        body_crc: Of it.

    """

    stored: bool = False
    size: int = 0
    first: int = 0
    last: int = 0
    frames: int = 0
    payload: int = 0
    index: dict[int, bytes] = field(default_factory=dict)
    compression: str = ""
    crc: int = 0
    body: list[Buffer] = field(default_factory=list)
    body_size: int = 0
    body_crc: int = 0
    _open: bytearray | None = None
    _singles: list[tuple[int, int, int]] = field(default_factory=list)
    _runs: list[tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], npt.NDArray[np.int64]]] = field(
        default_factory=list
    )

    def add(self, parts: Iterable[Buffer]) -> None:
        """Add buffers; small ones are joined, large ones are kept as they are."""
        for part in parts:
            self.size += len(part)
            if len(part) >= _LARGE:
                self.body.append(part)
                self._open = None
            else:
                if self._open is None:
                    self._open = bytearray()
                    self.body.append(self._open)
                self._open += part

    def add_message(self, message: OutMessage, head: bytes, size: int) -> None:
        """Add a message behind its head."""
        self._note_times(message.stamp, message.stamp)
        self._singles.append((message.channel + 1, message.stamp, self.size))
        self.payload += size
        self.add((head, *message.parts))

    def add_run(self, run: _Run) -> None:
        """Add records."""
        self._note_times(int(run.stamps[0]), int(run.stamps[-1]))
        self._runs.append((run.channels, run.stamps, run.starts[:-1] + self.size))
        self.payload += len(run.data) - _HEAD.itemsize * len(run.stamps)
        self.add((run.data,))

    def _note_times(self, first: int, last: int) -> None:
        self.first = min(self.first, first) if self._singles or self._runs else first
        self.last = max(self.last, last)

    def finish(self, compression: str) -> Chunk:
        """Compress the records, and compute the index and all CRCs."""
        self._make_index()
        for part in self.body:
            self.crc = isal_zlib.crc32(part, self.crc)
        self.body_size, self.body_crc = self.size, self.crc
        if self.stored or compression == "none":
            return self
        whole = b"".join(self.body)
        if compression == "zstd":
            packed = zstandard.ZstdCompressor(_ZSTD_LEVEL).compress(whole)
        else:
            packed = lz4.frame.compress(whole)
        self.compression, self.body, self.body_size = compression, [packed], len(packed)
        self.body_crc = isal_zlib.crc32(packed)
        return self

    def _make_index(self) -> None:
        """Make the index from the channels, log times and offsets of the messages."""
        columns = [np.array(self._singles, np.int64).reshape(-1, 3).T, *self._runs]
        channels, stamps, offsets = (np.concatenate(column) for column in zip(*columns, strict=True))
        entries = np.empty((len(channels), 2), "<i8")
        entries[:, 0], entries[:, 1] = stamps, offsets
        for channel in sorted(set(channels.tolist())):
            # In order, as the messages of a channel are all single ones or all in runs.
            self.index[channel] = entries[channels == channel].tobytes()


class _Signals:
    """The records of all signals, in order, made in blocks so that few are there at a time."""

    def __init__(self, rows: Sequence[Rows]) -> None:
        self._rows = rows
        empty = np.empty(0, np.int64)
        stamps = np.concatenate([empty, *(one.stamps for one in rows)])
        number = np.repeat(np.arange(len(rows)), [len(one.stamps) for one in rows])
        order = np.lexsort((number, stamps))
        self._stamps, self._number = stamps[order], number[order]
        self._taken = [0] * len(rows)
        self._next = 0
        self._block = _Run(empty, empty, np.zeros(1, np.int64), memoryview(b""))
        self._used = 0

    def before(self, stamp: int) -> Iterator[_Run]:
        """Yield the next records that are earlier."""
        yield from self._upto(int(np.searchsorted(self._stamps, stamp)))

    def rest(self) -> Iterator[_Run]:
        """Yield all that are left."""
        yield from self._upto(len(self._stamps))

    def _upto(self, end: int) -> Iterator[_Run]:
        while self._next < end:
            if self._used == len(self._block.stamps):
                self._make_block()
            count = min(end - self._next, len(self._block.stamps) - self._used)
            yield self._block.cut(self._used, self._used + count)
            self._used += count
            self._next += count

    def _make_block(self) -> None:
        number = self._number[self._next : self._next + _BLOCK]
        stamps = self._stamps[self._next : self._next + _BLOCK]
        lengths = np.array([_HEAD.itemsize + one.length for one in self._rows])[number]
        starts = np.concatenate([[0], np.cumsum(lengths)])
        data = np.empty(starts[-1], np.uint8)
        for which in sorted(set(number.tolist())):
            chosen = number == which
            records = self._records(which, stamps[chosen])
            places = starts[:-1][chosen]
            data[places[:, np.newaxis] + np.arange(records.shape[1])] = records
        channels = np.array([one.channel + 1 for one in self._rows])[number]
        self._block, self._used = _Run(channels, stamps, starts, data.data), 0

    def _records(self, which: int, stamps: npt.NDArray[np.int64]) -> npt.NDArray[np.uint8]:
        """Return the next records of one signal, one a row."""
        rows, first = self._rows[which], self._taken[which]
        self._taken[which] = last = first + len(stamps)
        heads = np.empty(len(stamps), _HEAD)
        heads["op"], heads["length"] = Op.MESSAGE, MESSAGE_HEADER.size + rows.length
        heads["channel"], heads["sequence"] = rows.channel + 1, np.arange(first, last) % 2**32
        heads["log_time"] = heads["publish_time"] = stamps
        heads_as_bytes = heads.view(np.uint8).reshape(len(stamps), _HEAD.itemsize)
        return np.concatenate([heads_as_bytes, rows.table(first, last)], axis=1)


class Chunker:
    """Puts messages into chunks. Small messages go with whichever images are at hand.

    Args:
        introduce: Returns the records that must stand before the first message of a channel; it is
            called with its index, once.
        stored: Channels whose messages are compressed already; their chunks are not.

    """

    def __init__(self, introduce: Callable[[int], list[bytes]], stored: frozenset[int]) -> None:
        self._introduce = introduce
        self._stored = stored
        self._known: set[int] = set()
        self._new_rows: set[int] = set()
        self._sequences: dict[int, int] = {}
        self._chunk = Chunk()
        self._has_image = False

    def chunks(self, messages: Iterable[OutMessage], rows: Sequence[Rows]) -> Iterator[Chunk]:
        """Yield chunks.

        Args:
            messages: In order of their stamps.
            rows: Further messages; at equal stamps they come behind `messages`.

        """
        signals = _Signals(rows)
        self._new_rows = {one.channel for one in rows}
        for message in messages:
            for run in signals.before(message.stamp):
                yield from self._add_run(run)
            yield from self._add_message(message)
        for run in signals.rest():
            yield from self._add_run(run)
        if self._chunk.size:
            yield self._chunk

    def _start(self) -> Chunk:
        """Return the chunk that is full, and begin another."""
        full = self._chunk
        self._chunk, self._has_image = Chunk(), False
        return full

    def _add_message(self, message: OutMessage) -> Iterator[Chunk]:
        size = sum(map(len, message.parts))
        kind = message.channel in self._stored
        other_kind = message.is_image and self._has_image and kind != self._chunk.stored
        if self._chunk.size and (self._chunk.size + size > CHUNK_BYTES or other_kind):
            yield self._start()
        chunk = self._chunk
        if message.is_image:
            self._has_image, chunk.stored = True, kind
            chunk.frames += 1
        self._begin(message.channel)
        sequence = self._sequences[message.channel] = self._sequences.get(message.channel, -1) + 1
        head = RECORD_HEADER.pack(Op.MESSAGE, MESSAGE_HEADER.size + size)
        head += MESSAGE_HEADER.pack(message.channel + 1, sequence % 2**32, message.stamp, message.stamp)
        chunk.add_message(message, head, size)

    def _add_run(self, run: _Run) -> Iterator[Chunk]:
        while len(run.stamps):
            # A message is in the chunk if it fits without its head.
            room = CHUNK_BYTES - self._chunk.size + _HEAD.itemsize
            count = int(np.searchsorted(run.starts[1:], room, side="right"))
            if not count and self._chunk.size:
                yield self._start()
                continue
            count = self._begin_some(run, max(count, 1))
            self._chunk.add_run(run.cut(0, count))
            run = run.cut(count, len(run.stamps))

    def _begin_some(self, run: _Run, count: int) -> int:
        """Introduce the channel of the first message; return how many messages may follow, it included."""
        if not self._new_rows:
            return count
        first = int(run.channels[0]) - 1
        if first in self._new_rows:
            self._new_rows.discard(first)
            self._begin(first)
            return 1  # what has been introduced takes room, too
        new = np.isin(run.channels[:count] - 1, list(self._new_rows))
        return int(new.argmax()) if new.any() else count

    def _begin(self, channel: int) -> None:
        if channel not in self._known:
            self._known.add(channel)
            self._chunk.add(self._introduce(channel))
