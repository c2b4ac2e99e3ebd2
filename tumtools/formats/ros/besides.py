# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What messages say and a sequence has no place for."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tumtools.model.sequence import Loss

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tumtools.formats.ros.gather import Gathered


def beside_the_streams(found: Gathered) -> Iterator[Loss]:
    """Yield what the messages of a recording say beside the streams that were read from them."""
    why = "a sequence has one coordinate frame for each stream, that of its first message"
    for stream, count in found.other_frames.items():
        if count:
            yield Loss(stream, "frame ids of single messages", count, why)
    why = "a sequence has one calibration for each image stream, that of its first message"
    for stream, count in found.other_cameras.items():
        yield Loss(stream, "calibrations that differ from the first", count, why)
