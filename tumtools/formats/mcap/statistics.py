# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What a MCAP file says of how much it holds: what is found can be held against it."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from tumtools.formats.mcap.records import Fields

_STATISTICS: Final = struct.Struct("<QHIIIIQQ")
"""Counts of messages, schemas, channels, attachments, metadata records, chunks; first and last log time."""

ANY: Final = -1
"""In place of the number of a channel: whichever it is."""


@dataclass(frozen=True, slots=True)
class Statistics:
    """The statistics record.

    Attributes:
        offset: Where it is in the file.
        messages: How many there are.
        attachments: How many there are.
        records: Metadata records.
        counts: Messages of each channel; None where the record does not tell.

    """

    offset: int
    messages: int
    attachments: int
    records: int
    counts: Mapping[int, int] | None

    def difference(self, found: Mapping[int, int]) -> str:
        """Return in what the messages found of each channel differ; empty if in nothing."""
        if self.counts is None:
            total = sum(found.values())
            return "" if total == self.messages else f"{self.messages} messages; {total} are found"
        for channel in sorted(self.counts.keys() | found.keys()):
            counted, there = self.counts.get(channel, 0), found.get(channel, 0)
            if counted != there:
                return f"{counted} messages of channel {channel}; {there} are found"
        return ""

    def missing(self, found: Mapping[int, int]) -> Iterator[tuple[int, int]]:
        """Yield channels and how many messages of each are counted and not found.

        The channel is `ANY` where messages are not counted by channel.
        """
        counts = {ANY: self.messages} if self.counts is None else self.counts
        there = {ANY: sum(found.values())} if self.counts is None else found
        for channel, count in sorted(counts.items()):
            if count > there.get(channel, 0):
                yield channel, count - there.get(channel, 0)


def read_statistics(fields: Fields, offset: int) -> Statistics:
    """Read the statistics record.

    Raises:
        InputError: It ends too early.

    """
    messages, _, _, attachments, records, _, _, _ = fields.unpack(_STATISTICS)
    counts = fields.number_map()
    # An empty map says that messages are not counted by channel.
    return Statistics(offset, messages, attachments, records, counts if counts or not messages else None)
