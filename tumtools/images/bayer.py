# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Colour out of a Bayer mosaic, by bilinear interpolation."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt

PATTERNS: Final = {
    "bayer_rggb8": (0, 0),
    "bayer_bggr8": (1, 1),
    "bayer_gbrg8": (1, 0),
    "bayer_grbg8": (0, 1),
}
"""Encoding -> row and column, modulo 2, of the red pixels; blue ones are diagonally opposite."""


def demosaic(mosaic: npt.NDArray[np.uint8], encoding: str) -> npt.NDArray[np.uint8]:
    """Interpolate the two colours that each pixel lacks.

    A colour that was measured is kept; the others are the mean of the nearest two or four pixels that have
    it, rounded half up. Borders are mirrored, which keeps the pattern.

    Args:
        mosaic: Shape [height, width], at least 2 in both.
        encoding: A key of `PATTERNS`.

    Returns:
        R G B, shape [height, width, 3].

    """
    row, column = PATTERNS[encoding]
    padded = np.pad(mosaic, 1, mode="reflect").astype(np.uint16)
    up, down, left, right = padded[:-2, 1:-1], padded[2:, 1:-1], padded[1:-1, :-2], padded[1:-1, 2:]
    horizontal, vertical = (left + right + 1) // 2, (up + down + 1) // 2
    cross = (left + right + up + down + 2) // 4
    corners = padded[:-2, :-2] + padded[:-2, 2:] + padded[2:, :-2] + padded[2:, 2:]
    diagonal = (corners + 2) // 4
    result = np.empty((*mosaic.shape, 3), np.uint8)
    for channel, y, x in ((0, row, column), (2, 1 - row, 1 - column)):
        other = 2 - channel
        result[y::2, x::2, channel] = mosaic[y::2, x::2]
        result[y::2, x::2, 1] = cross[y::2, x::2]
        result[y::2, x::2, other] = diagonal[y::2, x::2]
        # The green pixels of this row and column parity: this colour is beside them, or above and below.
        result[y::2, 1 - x :: 2, channel] = horizontal[y::2, 1 - x :: 2]
        result[1 - y :: 2, x::2, channel] = vertical[1 - y :: 2, x::2]
        result[y::2, 1 - x :: 2, 1] = mosaic[y::2, 1 - x :: 2]
    return result
