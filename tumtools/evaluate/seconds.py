# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Stamps as the benchmark's scripts see them: float64 seconds, 238 ns apart at today's epoch.

Where two ground-truth poses are equally far from a frame, which is common with stamps of four
decimals, the rounding of the floats decides in the scripts. To give their pairs and so their
numbers, it decides here too, but only then: limits and order are those of the integers. evo, whose
rule is `nearest`, computes with the same floats.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tumtools.model.time import NANOSECONDS_PER_SECOND

if TYPE_CHECKING:
    import numpy.typing as npt


def rounded_seconds(stamps: npt.NDArray[np.int64], offset: int = 0) -> npt.NDArray[np.float64]:
    """Return `float(text) + offset` for stamps (ns), as reading their text gives, shape [n].

    Whole seconds and the rest are added as floats; that sum is the nearest float to the decimal
    number, because no number of up to nine decimals is so near to the middle of two floats that the
    error of the rest (1e-17 s) matters.
    """
    seconds, rest = np.divmod(stamps, NANOSECONDS_PER_SECOND)
    result: npt.NDArray[np.float64] = seconds + rest / NANOSECONDS_PER_SECOND
    return result + offset / NANOSECONDS_PER_SECOND if offset else result
