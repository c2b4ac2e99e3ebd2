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
"""Messages."""


@dataclass(frozen=True, slots=True)
class Batch:
    """Messages of one channel in one buffer, in order of log time.

    Attributes:
        channel: Their channel.
        log_times: Nanoseconds, int64, shape [n].
        data: The buffer, uint8; whoever keeps it keeps a chunk of the recording.
        starts: Where each message begins, shape [n].
        lengths: Bytes of each message, shape [n].

    """

    channel: Channel
    log_times: npt.NDArray[np.int64]
    data: npt.NDArray[np.uint8]
    starts: npt.NDArray[np.int64]
    lengths: npt.NDArray[np.int64]


def joined(messages: list[bytes | memoryview]) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.int64]]:
    """Return messages in one buffer, and the length of each."""
    lengths = np.fromiter(map(len, messages), np.int64, len(messages))
    return np.frombuffer(b"".join(messages), np.uint8), lengths


def in_batches(messages: Iterable[RawMessage]) -> Iterator[Batch]:
    """Yield the messages of each channel in batches of `BATCH`, copied as they come."""
    waiting: dict[Channel, tuple[list[int], list[bytes | memoryview]]] = {}
    for message in messages:
        times, copies = waiting.setdefault(message.channel, ([], []))
        times.append(message.log_time)
        copies.append(bytes(message.data))
        if len(copies) == BATCH:
            yield _batch(message.channel, *waiting.pop(message.channel))
    for channel, (times, copies) in waiting.items():
        yield _batch(channel, times, copies)


def _batch(channel: Channel, times: list[int], messages: list[bytes | memoryview]) -> Batch:
    data, lengths = joined(messages)
    return Batch(channel, np.array(times, np.int64), data, np.cumsum(lengths) - lengths, lengths)


def cut(data: npt.NDArray[np.uint8], starts: npt.NDArray[np.int64], length: int) -> npt.NDArray[np.uint8]:
    """Return a copy of the bytes at some places, which must be there; shape [n, length]."""
    if not length or not len(starts):
        return np.empty((len(starts), length), np.uint8)
    # As `sliding_window_view`, which takes longer than to copy some rows.
    windows = np.ndarray((len(data) - length + 1, length), np.uint8, data, strides=(1, 1))
    return windows[starts]


def tables(
    data: npt.NDArray[np.uint8], starts: npt.NDArray[np.int64], lengths: npt.NDArray[np.int64]
) -> Iterator[tuple[npt.NDArray[np.intp], npt.NDArray[np.uint8]]]:
    """Yield the numbers of the messages of each length that occurs, and these messages, one a row."""
    if len(lengths) and (lengths == lengths[0]).all():
        yield np.arange(len(lengths)), cut(data, starts, int(lengths[0]))
        return
    for length in np.unique(lengths).tolist():
        rows = np.flatnonzero(lengths == length)
        yield rows, cut(data, starts[rows], length)
