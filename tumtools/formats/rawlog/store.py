# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Put the images of a sequence into the files beside a rawlog."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tumtools.formats.rawlog.compression import Container, deflate
from tumtools.formats.rawlog.externals import depth_payload, metres_payload
from tumtools.images import depth
from tumtools.images.codec import pixels_of, png_of
from tumtools.model.sequence import TUM_DEPTH_UNITS_PER_METRE

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from tumtools.formats.rawlog.dialects import Dialect
    from tumtools.formats.rawlog.plan import Key
    from tumtools.model.image import Image
    from tumtools.model.sequence import Frame


@dataclass(frozen=True, slots=True)
class Stored:
    """An image that is in its file."""

    key: Key
    suffix: str
    width: int
    height: int
    nbytes: int
    range_units: float = 0.0
    rounding: depth.Rounding = depth.EXACT


@dataclass(frozen=True, slots=True)
class Store:
    """Puts images into files; called by several threads."""

    folder: Path
    dialect: Dialect
    container: Container
    names: Mapping[Key, list[str]]

    def __call__(self, frame: Frame) -> Stored:
        """Write the file or files of an image."""
        image = frame.load()
        key = (frame.stream, frame.row)
        data: bytes | memoryview
        range_units, rounding = 0.0, depth.EXACT
        if frame.stream == "depth":
            payload, units, rounding = self._depth(image)
            data, suffix, range_units = deflate(payload, self.container), ".bin", 1 / units
        elif image.compressed is not None and image.compression == "jpeg":
            data, suffix = image.compressed, ".jpg"
        else:
            data, suffix = png_of(image), ".png"
        for name in self.names[key]:
            # Path takes as long as a small file.
            with open(f"{self.folder}/{name}{suffix}", "wb") as file:  # noqa: PTH123 - as said
                file.write(data)
        nbytes = len(data) * len(self.names[key])
        return Stored(key, suffix, image.width, image.height, nbytes, range_units, rounding)

    def _depth(self, image: Image) -> tuple[bytes, float, depth.Rounding]:
        """Return the content of the depth file, counts per metre, and what rounding changed."""
        pixels = pixels_of(image)
        units = image.depth_units_per_metre or TUM_DEPTH_UNITS_PER_METRE
        is_float = pixels.dtype.kind == "f"
        if self.dialect.float_depth:
            if is_float:
                metres = np.where(np.isnan(pixels), 0, pixels).astype(np.float32, copy=False)
            else:
                metres = depth.divided(pixels.astype(np.uint16, copy=False), units)
            return metres_payload(metres), units, depth.EXACT
        if is_float:
            units = TUM_DEPTH_UNITS_PER_METRE
            counts, rounding = depth.to_counts(pixels.astype(np.float32, copy=False), units)
        else:
            counts, rounding = pixels.astype(np.uint16, copy=False), depth.EXACT
        return depth_payload(counts), units, rounding
