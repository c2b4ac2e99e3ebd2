# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Many small messages at a time, where they lie: what a container finds without a step for each of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    import numpy.typing as npt

    from tumtools.formats.ros.recording import Channel, RawMessage

BATCH: Final = 2048
"""Messages that are worked on at a time at the most."""
_ROWS_OF_A_PLACE: Final = 6
"""Fewer messages are faster found one by one."""
BATCH_BYTES: Final = 2**24
"""Bytes of copies that are held for it: an index may name a large message again and again."""


@dataclass(frozen=True, slots=True)
class Batch:
    """Messages of one channel in one buffer, in order of log time.

    Attributes:
        channel: Their channel.
        log_times: Nanoseconds, int64, shape [n].
        data: The buffer, uint8; whoever keeps it keeps a chunk of the recording, or the mapped file.
        starts: Where each message begins, int64, shape [n].
        lengths: Bytes of each message, int64, shape [n].

    """

    channel: Channel
    log_times: npt.NDArray[np.int64]
    data: npt.NDArray[np.uint8]
    starts: npt.NDArray[np.int64]
    lengths: npt.NDArray[np.int64]


class Copies:
    """Copies of messages of one channel, until there are enough of them for a batch."""

    def __init__(self, channel: Channel) -> None:
        self._channel = channel
        self._log_times: list[int] = []
        self._messages: list[bytes] = []
        self._nbytes = 0

    def __len__(self) -> int:
        return len(self._messages)

    @property
    def is_enough(self) -> bool:
        """Whether it is time to take them."""
        return len(self._messages) >= BATCH or self._nbytes >= BATCH_BYTES

    def add(self, message: RawMessage) -> None:
        """Copy a message."""
        self._log_times.append(message.log_time)
        self._messages.append(bytes(message.data))
        self._nbytes += len(message.data)

    def take(self) -> Batch:
        """Return what has been copied, and hold nothing any more."""
        times, messages = np.array(self._log_times, np.int64), self._messages
        self._log_times, self._messages, self._nbytes = [], [], 0
        lengths = np.fromiter(map(len, messages), np.int64, len(messages))
        data = np.frombuffer(b"".join(messages), np.uint8)
        return Batch(self._channel, times, data, np.cumsum(lengths) - lengths, lengths)


def in_batches(messages: Iterable[RawMessage]) -> Iterator[Batch]:
    """Yield copies of messages, many of a channel at a time; those of each channel in their order."""
    copies: dict[int, Copies] = {}
    for message in messages:
        own = copies.setdefault(message.channel.id, Copies(message.channel))
        own.add(message)
        if own.is_enough:
            yield own.take()
    yield from (own.take() for own in copies.values() if len(own))


def is_interleaved(chunks: npt.NDArray[np.integer]) -> bool:
    """Tell whether messages, whose chunks these are, lie too much apart to gain by being taken together."""
    return len(chunks) < _ROWS_OF_A_PLACE * (1 + int(np.count_nonzero(np.diff(chunks))))


def rows_at(data: npt.NDArray[np.uint8], starts: npt.NDArray[np.int64], length: int) -> npt.NDArray[np.uint8]:
    """Return so many bytes at each of some places, which must be there, copied; uint8, shape [n, length]."""
    if not length or not len(starts):
        return np.empty((len(starts), length), np.uint8)
    # As `sliding_window_view`, which takes longer than to copy some rows.
    windows = np.ndarray((len(data) - length + 1, length), np.uint8, data, strides=(1, 1))
    return windows[starts]


def tables(
    data: npt.NDArray[np.uint8], starts: npt.NDArray[np.int64], lengths: npt.NDArray[np.int64]
) -> Iterator[tuple[npt.NDArray[np.intp], npt.NDArray[np.uint8]]]:
    """Yield the messages of each length that occurs, copied.

    Args:
        data: What they lie in.
        starts: Where each begins, shape [n].
        lengths: Bytes of each, shape [n].

    Yields:
        The numbers of the messages, shape [m], and one message a row, uint8, shape [m, length].

    """
    if len(lengths) and (lengths == lengths[0]).all():  # as it mostly is
        yield np.arange(len(lengths)), rows_at(data, starts, int(lengths[0]))
        return
    for length in np.unique(lengths).tolist():
        rows = np.flatnonzero(lengths == length)
        yield rows, rows_at(data, starts[rows], length)
