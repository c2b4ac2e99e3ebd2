# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""One image: compressed bytes, pixels, or both, whichever it came with.

The other form is made on demand by `tumtools.images`, so that what need not be decoded is not.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt

Compression = Literal["png", "jpeg"]


@dataclass(frozen=True, slots=True)
class Encoding:
    """How the pixels of an encoding lie in memory: rows without padding, little endian."""

    name: str
    dtype: np.dtype[np.generic]
    channels: int

    @property
    def bytes_per_pixel(self) -> int:
        """Size of one pixel in memory."""
        return self.dtype.itemsize * self.channels


ENCODINGS: Final[dict[str, Encoding]] = {
    name: Encoding(name, np.dtype(kind), channels)
    for name, kind, channels in (
        ("rgb8", "u1", 3),
        ("bgr8", "u1", 3),
        ("rgba8", "u1", 4),
        ("bgra8", "u1", 4),
        ("mono8", "u1", 1),
        ("mono16", "<u2", 1),
        ("16UC1", "<u2", 1),
        ("32FC1", "<f4", 1),
        ("bayer_rggb8", "u1", 1),
        ("bayer_bggr8", "u1", 1),
        ("bayer_gbrg8", "u1", 1),
        ("bayer_grbg8", "u1", 1),
    )
}
"""The encodings of the model, by the names that ROS uses (`sensor_msgs/image_encodings.hpp`)."""


@dataclass(frozen=True, slots=True, eq=False)
class Image:
    """An image of one stream.

    Attributes:
        width: Columns.
        height: Rows.
        encoding: A key of `ENCODINGS`.
        depth_units_per_metre: For depth, how many counts make a metre (5000 in the benchmark, 1 for
            `32FC1`); None for everything else.
        compressed: The bytes of the file, exactly as they came, or None.
        compression: What `compressed` is.
        origin: Where it comes from, for messages: a file, a topic and a time.
        pixels: Shape [height, width] or [height, width, channels], dtype of the encoding, or None.
            At least one of `compressed` and `pixels` is there. Arrays are not written to.

    """

    width: int
    height: int
    encoding: str
    depth_units_per_metre: float | None = None
    compressed: bytes | memoryview | None = None
    compression: Compression | None = None
    pixels: npt.NDArray[np.generic] | None = None
    origin: str | None = None

    @property
    def png(self) -> bytes | memoryview | None:
        """The PNG file, if that is what the image came with."""
        return self.compressed if self.compression == "png" else None

    @property
    def nbytes(self) -> int:
        """Bytes held by whichever form is there (the compressed one if both are)."""
        if self.compressed is not None:
            return len(self.compressed)
        return 0 if self.pixels is None else self.pixels.nbytes
