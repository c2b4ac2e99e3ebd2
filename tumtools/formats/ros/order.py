# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""In which order the images of a recording come, from their log times and header stamps alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tumtools.model.sequence import IMAGE_STREAMS

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    import numpy.typing as npt

    from tumtools.formats.ros.collectors import Times


@dataclass(frozen=True, slots=True)
class ImageOrder:
    """The images of a recording, each by its stream and its position in order of log time.

    Attributes:
        times: Stream -> log times and header stamps, in order of log time.
        rows: Stream -> row in file order of each image, in order of log time.

    """

    times: Mapping[str, Times]
    rows: Mapping[str, npt.NDArray[np.intp]]

    def in_file_order(self, stream: str) -> npt.NDArray[np.int64]:
        """Return the header stamps in file order; none for a stream that is not there."""
        if stream not in self.times:
            return np.empty(0, np.int64)
        _, logged = self.times[stream]
        stamps = np.empty_like(logged)
        stamps[self.rows[stream]] = logged
        return stamps

    def most_waiting(self, streams: Collection[str]) -> int:
        """Return how many messages of the streams wait at most when they are read together."""
        if not streams:
            return 0
        logged = np.concatenate([self.times[stream][0] for stream in streams])
        stamps = np.concatenate([self.times[stream][1] for stream in streams])
        arrival = np.empty(len(stamps), np.intp)
        arrival[np.argsort(logged, kind="stable")] = np.arange(len(stamps))
        leaves_after = np.maximum.accumulate(arrival[np.lexsort((logged, stamps))])
        gone = np.searchsorted(leaves_after, np.arange(len(stamps)), side="right")
        return int((np.arange(len(stamps)) + 1 - gone).max(initial=0))

    def chosen(self, streams: Collection[str], start: int | None, end: int | None) -> list[tuple[str, int]]:
        """Return stream and position of the images between two header stamps, in the order to yield them."""
        keys = [
            (stamp, IMAGE_STREAMS.index(stream), row, position)
            for stream in streams
            for position, (stamp, row) in enumerate(
                zip(self.times[stream][1].tolist(), self.rows[stream].tolist(), strict=True)
            )
            if (start is None or stamp >= start) and (end is None or stamp <= end)
        ]
        return [(IMAGE_STREAMS[stream], position) for _, stream, _, position in sorted(keys)]
