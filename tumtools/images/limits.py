# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""How large an image may be. A file of some kilobytes can claim to hold gigabytes of pixels."""

from __future__ import annotations

from typing import Final

from tumtools.errors import UnsupportedInputError

MAX_PIXELS: Final = 12 * 2**20
"""The colour images of the Azure Kinect, 4096x3072; the benchmark's have a fortieth of that."""


def check_size(width: int, height: int, location: str | None = None) -> None:
    """Refuse an image that is too large, before memory is taken for it.

    Raises:
        UnsupportedInputError: With its size and the limit.

    """
    if width * height > MAX_PIXELS:
        raise UnsupportedInputError(
            f"an image of {width}x{height} pixels; images of more than {MAX_PIXELS / 2**20:.0f} megapixels "
            f"({MAX_PIXELS} pixels) are not read",
            location=location,
        )
