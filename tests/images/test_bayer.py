# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Bayer mosaics become colour."""

from __future__ import annotations

import numpy as np
import pytest

from tumtools.images.bayer import PATTERNS, demosaic


@pytest.mark.parametrize("encoding", PATTERNS)
def test_demosaicing_keeps_what_was_measured_and_planes_exactly(encoding: str) -> None:
    """Bilinear interpolation is exact where each colour is a plane, but for the mirrored border."""
    y, x = np.mgrid[:8, :10]
    image = np.stack([10 + 2 * y + 4 * x, 50 + 4 * y + 2 * x, 200 - 2 * x - 4 * y], axis=2).astype(np.uint8)
    row, column = PATTERNS[encoding]
    mosaic = image[:, :, 1].copy()
    mosaic[row::2, column::2] = image[row::2, column::2, 0]
    mosaic[1 - row :: 2, 1 - column :: 2] = image[1 - row :: 2, 1 - column :: 2, 2]

    colour = demosaic(mosaic, encoding)

    assert np.array_equal(colour[1:-1, 1:-1], image[1:-1, 1:-1])
    assert np.array_equal(colour[row::2, column::2, 0], mosaic[row::2, column::2])
    assert np.array_equal(colour[1 - row :: 2, 1 - column :: 2, 2], mosaic[1 - row :: 2, 1 - column :: 2])
