# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""How a sequence becomes messages: the options with all defaults filled in, what they need and cost."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from tumtools.formats.options import Needs
from tumtools.formats.ros.images import MILLIMETRES
from tumtools.formats.ros.layouts import LAYOUTS, Layout
from tumtools.model.image import ENCODINGS
from tumtools.model.sequence import TUM_DEPTH_UNITS_PER_METRE, Sequence

if TYPE_CHECKING:
    from tumtools.formats.options import WriteOptions
    from tumtools.formats.registry import Format
    from tumtools.formats.ros.recording import MessageEncoding

_ZSTD_SHARE: Final = 0.2
_MESSAGE_OVERHEAD: Final = 420
"""About the size of a small message with its index entry."""


@dataclass(frozen=True, slots=True)
class Style:
    """How to write, with all defaults filled in.

    Attributes:
        encoding: How messages are serialised.
        layout: Topics and frames.
        color_encoding: `png`, `rgb8` or `bgr8`.
        depth_encoding: `png`, `32FC1` or `16UC1`.
        groundtruth: `pose`, `tf`, `both` or `none`.
        options: The rest.

    """

    encoding: MessageEncoding
    layout: Layout
    color_encoding: str
    depth_encoding: str
    groundtruth: str
    options: WriteOptions

    @property
    def pixel_streams(self) -> frozenset[str]:
        """Streams that are written from their pixels."""
        raw = {"depth"} if self.depth_encoding != "png" else set()
        return frozenset(raw | ({"rgb", "ir"} if self.color_encoding != "png" else set()))

    def frame_id(self, sequence: Sequence, stream: str, of_frame: str | None = None) -> str:
        """Return the coordinate frame of a stream, or of one of its frames that says so itself."""
        return (
            self.options.frame_ids.get(stream)
            or of_frame
            or sequence.info.frame_ids.get(stream)
            or self.layout.frames[stream]
        )


def make_style(encoding: MessageEncoding, entry: Format, options: WriteOptions) -> Style:
    """Fill in the defaults of a format.

    Args:
        encoding: How messages are serialised.
        entry: The format.
        options: What was asked for.

    """
    layout = LAYOUTS[entry.option(options, "layout")]
    return Style(
        encoding=encoding,
        layout=layout,
        color_encoding="png" if options.archive else entry.option(options, "color_encoding"),
        depth_encoding="png" if options.archive else entry.option(options, "depth_encoding"),
        groundtruth=options.groundtruth or layout.groundtruth,
        options=options,
    )


def style_needs(style: Style) -> Needs:
    """Return what a writer of this style must be given: nothing is lost behind this point."""
    units = {"16UC1": MILLIMETRES, "png": TUM_DEPTH_UNITS_PER_METRE}.get(style.depth_encoding)
    drops = frozenset({"groundtruth"} if style.groundtruth == "none" else ())
    metres = style.depth_encoding == "32FC1"
    return Needs(units, pixel_streams=style.pixel_streams, metres=metres, drops=drops, keeps_digest=True)


def estimated_bytes(sequence: Sequence, style: Style, *, compressed: bool) -> int:
    """Return about how large the messages of a sequence will be."""
    total = 0
    for stream, info in sequence.info.images.items():
        raw = info.count * info.width * info.height
        if stream not in style.pixel_streams:
            total += info.nbytes if info.compression == "png" else raw
        elif stream == "depth":
            size = 4 if style.depth_encoding == "32FC1" else 2
            total += int(raw * size * (_ZSTD_SHARE if compressed else 1))
        else:
            total += raw * ENCODINGS[info.encoding or "rgb8"].bytes_per_pixel
        total += info.count * _MESSAGE_OVERHEAD
    rows = sum(len(one) for one in (sequence.accelerometer, sequence.groundtruth) if one is not None)
    return total + rows * _MESSAGE_OVERHEAD
