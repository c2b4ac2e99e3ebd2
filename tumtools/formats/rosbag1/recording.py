# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A ROS 1 bag as a `Recording`."""

from __future__ import annotations

import mmap
import os
from collections import OrderedDict, deque
from contextlib import closing
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.errors import InputError, MissingInputError
from tumtools.formats.metadata import parse_object
from tumtools.formats.ros.batches import BATCH, Batch, in_batches, is_interleaved
from tumtools.formats.ros.kept import left_out
from tumtools.formats.ros.layouts import DIGEST_TOPIC, METADATA_TOPIC
from tumtools.formats.ros.messages import STRING
from tumtools.formats.ros.pages import Pages
from tumtools.formats.ros.recording import Channel, RawMessage, Recording
from tumtools.formats.rosbag1.heads import find_messages
from tumtools.formats.rosbag1.index import read_index
from tumtools.formats.rosbag1.records import Block, find_message
from tumtools.images.parallel import ordered_map
from tumtools.model.sequence import Loss

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator
    from pathlib import Path

    import numpy.typing as npt

    from tumtools.formats.rosbag1.structure import BagIndex, Chunk, Connection

_CACHE_BYTES: Final = 16 * 2**20
"""Contents of chunks kept; messages that lie next to each other in time are in few chunks."""
_THREADS: Final = 2


class BagRecording(Recording):
    """A ROS 1 bag. Reads its index at once, and messages as they are asked for.

    Args:
        path: The file.
        salvage: Scan the file and leave out what is damaged, with a warning, instead of failing.

    Raises:
        InputError: The file is no bag, or damaged.

    """

    format = "rosbag1"

    def __init__(self, path: Path, *, salvage: bool = False) -> None:
        self.path = str(path)
        self._file = _map_file(path)
        self._index = read_index(self._file, salvage=salvage)
        self.warnings = self._index.warnings
        self.left_out = self._index.left_out
        self._channel_of = _channels_of(self._index)
        channels = sorted(set(self._channel_of.values()), key=lambda channel: channel.id)
        ours = {
            channel.topic: channel
            for channel in reversed(channels)
            if channel.topic in {METADATA_TOPIC, DIGEST_TOPIC} and channel.type == STRING
        }
        self._salvage = salvage
        self.metadata = self._read_strings(ours.get(METADATA_TOPIC))
        self.digest = self._read_strings(ours.get(DIGEST_TOPIC))
        self.channels = tuple(channel for channel in channels if channel not in ours.values())

    def messages(
        self, channels: Collection[Channel], start: int | None = None, end: int | None = None
    ) -> Iterator[RawMessage]:
        """Yield the messages of the channels in order of (log time, position in the file).

        Raises:
            InputError: Damage, with the offset and what was expected there.

        """
        entries = self._select(channels, start, end)
        with closing(_Contents(self._file, self._index.chunks, entries["chunk"])) as contents:
            for time, chunk, offset, number in entries.tolist():
                data = find_message(contents[chunk], offset, number, time)
                yield RawMessage(self._channel_of[number], time, data)

    def batches(self, channels: Collection[Channel]) -> Iterator[Batch]:
        """Yield small messages many at a time; those of each channel in order of log time.

        Raises:
            InputError: As `messages`.

        """
        entries = self._select(channels, None, None)
        if is_interleaved(entries["chunk"]):
            yield from in_batches(self.messages(channels))
            return
        starts = np.flatnonzero(np.diff(entries["chunk"], prepend=-1))
        with closing(_Contents(self._file, self._index.chunks, entries["chunk"])) as contents:
            for part in np.split(entries, starts[1:]) if len(entries) else ():
                block = contents[int(part["chunk"][0])]
                for first in range(0, len(part), BATCH):
                    yield from self._batches_of(block, part[first : first + BATCH])

    def _batches_of(self, block: Block, entries: npt.NDArray[np.void]) -> Iterator[Batch]:
        """Yield the messages that some entries name in one chunk."""
        times, offsets, numbers = entries["time"], entries["offset"].astype(np.int64), entries["connection"]
        places = find_messages(block, offsets, numbers, times)
        if places is None:
            yield from in_batches(
                RawMessage(self._channel_of[number], time, find_message(block, offset, number, time))
                for time, _, offset, number in entries.tolist()
            )
            return
        data, (starts, lengths) = np.frombuffer(block.data, np.uint8), places
        known, inverse = np.unique(numbers, return_inverse=True)
        channels = [self._channel_of[number] for number in known.tolist()]
        ids = np.array([channel.id for channel in channels])[inverse]
        for channel in {channel.id: channel for channel in channels}.values():
            rows = np.flatnonzero(ids == channel.id)
            yield Batch(channel, times[rows], data, starts[rows], lengths[rows])

    def log_times(self, channel: Channel) -> npt.NDArray[np.int64]:
        """Return the log times of a channel, from the index."""
        times: npt.NDArray[np.int64] = self._select([channel], None, None)["time"].copy()
        return times

    def close(self) -> None:
        """Release the file. Views that were handed out stay valid."""
        self._file = Block(self.path, memoryview(b""))

    def _select(
        self, channels: Collection[Channel], start: int | None, end: int | None
    ) -> npt.NDArray[np.void]:
        """Return the index entries wanted, sorted."""
        entries = self._index.entries
        ids = {channel.id for channel in channels}
        numbers = [number for number, channel in self._channel_of.items() if channel.id in ids]
        wanted = np.isin(entries["connection"], np.array(numbers, np.uint32))
        if start is not None:
            wanted &= entries["time"] >= start
        if end is not None:
            wanted &= entries["time"] <= end
        entries = entries[wanted]
        return entries[np.lexsort((entries["offset"], entries["chunk"], entries["time"]))]

    def _read_strings(self, channel: Channel | None) -> dict[str, str] | None:
        """Return the strings in the first message of a topic of ours; None if there is none.

        Raises:
            InputError: It does not hold what we write.

        """
        if channel is None or not channel.count:
            return None
        if channel.count > 1:
            why = "a recording has one such message; the others are of recordings that were joined with it"
            loss = Loss(channel.topic, "messages besides the first not carried over", channel.count - 1, why)
            self.not_carried += (loss,)
        try:
            return _strings_in(next(self.messages([channel])).data)
        except ValueError as error:
            damage = error if isinstance(error, InputError) else self._damaged(channel, str(error))
            if not self._salvage:
                raise damage from error
            self.warnings += (f"damage at {damage.location}: {damage.message}; this is left out",)
            self.left_out += (left_out(channel.topic, damage),)
            return None

    def _damaged(self, channel: Channel, message: str) -> InputError:
        """Return the error for the first message of a channel."""
        _, chunk, offset, _ = self._select([channel], None, None)[0].tolist()
        block = Block(self.path, memoryview(b""), self._index.chunks[chunk].offset)
        return block.damage(f"the message on {channel.topic} is not what tumtools writes: {message}", offset)


def _strings_in(message: memoryview) -> dict[str, str]:
    """Return the strings in a std_msgs/String of ours.

    Raises:
        ValueError: It holds something else.

    """
    head, text = bytes(message[:4]), bytes(message[4:])
    if int.from_bytes(head, "little") != len(text):
        raise ValueError(f"a text of {int.from_bytes(head, 'little')} bytes, {len(text)} are there")
    return parse_object(text)


def _map_file(path: Path) -> Block:
    try:
        descriptor = os.open(path, os.O_RDONLY)
    except FileNotFoundError as error:
        raise MissingInputError("no such file", path=path) from error
    except OSError as error:
        raise InputError(f"cannot be opened: {error.strerror}", path=path) from error
    try:
        if not os.fstat(descriptor).st_size:
            return Block(str(path), memoryview(b""))
        mapped = mmap.mmap(descriptor, 0, access=mmap.ACCESS_READ)
    except (OSError, ValueError) as error:
        raise InputError(f"cannot be read: {error}", path=path) from error
    finally:
        os.close(descriptor)
    return Block(str(path), memoryview(mapped), passed=Pages(mapped).read)


def _channels_of(index: BagIndex) -> dict[int, Channel]:
    """Return the channel of each connection; publishers of the same on the same topic share one."""
    count_of = index.count()
    groups: dict[tuple[str, str, str], list[int]] = {}
    for number, connection in sorted(index.connections.items()):
        groups.setdefault((connection.topic, connection.type, connection.definition), []).append(number)
    return {
        number: channel
        for group in groups.values()
        for channel in [_channel(group, index.connections, sum(count_of[n] for n in group))]
        for number in group
    }


def _channel(numbers: list[int], connections: dict[int, Connection], count: int) -> Channel:
    first = connections[numbers[0]]
    package, _, name = first.type.rpartition("/")
    return Channel(
        id=numbers[0],
        topic=first.topic,
        type=f"{package}/msg/{name}",
        encoding="ros1",
        definition=first.definition,
        count=count,
        latched=any(connections[number].latched for number in numbers),
    )


class _Contents:
    """Contents of chunks in the order in which they are needed: decompressed ahead, the last few kept."""

    def __init__(self, file: Block, chunks: list[Chunk], visits: npt.NDArray[np.int32]) -> None:
        self._file = file
        self._chunks = chunks
        self._kept: OrderedDict[int, Block] = OrderedDict()
        numbers, first = np.unique(visits, return_index=True)
        order: list[int] = numbers[np.argsort(first)].tolist()
        self._next = deque(number for number in order if chunks[number].compression != "none")
        self._ahead = ordered_map(self._load, tuple(self._next), _THREADS, window=2 * _THREADS)

    def __getitem__(self, number: int) -> Block:
        block = self._kept.get(number)
        if block is not None:
            self._kept.move_to_end(number)
            return block
        if self._next and self._next[0] == number:
            self._next.popleft()
            block = next(self._ahead)
        else:
            block = self._load(number)
        self._kept[number] = block
        while len(self._kept) > 1 and sum(len(kept.data) for kept in self._kept.values()) > _CACHE_BYTES:
            self._kept.popitem(last=False)
        return block

    def close(self) -> None:
        """Stop decompressing ahead."""
        self._ahead.close()

    def _load(self, number: int) -> Block:
        return self._chunks[number].load(self._file)
