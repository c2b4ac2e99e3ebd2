# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""How many counts make a metre: the sensor's own quantisation tells, whatever the scene.

A structured-light sensor measures disparity in steps of 1/8 pixel, so its depths Z lie on a grid that is
uniform in 1/Z with the step 1 / (f b 8), for f = 580 px and b = 0.075 m. In an image with U counts a metre
the distinct values u have 1/u_i - 1/u_(i+1) = step / U, and so U follows from the images alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt

DISPARITY_STEP: Final = 1 / (580.0 * 0.075 * 8)
"""Step of 1/Z, per metre: first Kinect and Xtion."""

_NEAR_SHARE: Final = 1 / 3
"""Of the distinct values, the nearest are dropped: their rounding to whole counts hides the grid."""
_SMALL_SHARE: Final = 0.7
"""The median is taken over the smaller steps; the larger ones span values that do not occur."""
_MIN_VALUES: Final = 40
_MAX_SPREAD: Final = 0.25
_MIN_COARSENESS: Final = 2.0


@dataclass(frozen=True, slots=True)
class DepthScale:
    """What the quantisation says.

    Attributes:
        units_per_metre: The measured factor.
        spread: Interquartile range of the steps taken, relative to their median: about 0.1 for a sensor's
            depth, 0.5 or more for depth that never was on a grid.
        coarseness: Median distance of neighbouring values, counts. Where every count occurs it is 1, and
            there is no grid to see.
        distinct: Distinct values.

    """

    units_per_metre: float
    spread: float
    coarseness: float
    distinct: int

    @property
    def is_quantised(self) -> bool:
        """Whether there is a grid at all; if not, the factor means nothing."""
        return self.spread <= _MAX_SPREAD and self.coarseness >= _MIN_COARSENESS


def measure_depth_scale(values: npt.NDArray[np.unsignedinteger]) -> DepthScale | None:
    """Measure the depth factor.

    Args:
        values: Distinct values of one or more depth images, sorted, in counts; zeros are ignored.

    Returns:
        The measure, or None if there are too few distinct values to say anything.

    """
    present = values[values > 0].astype(np.float64)
    far = present[int(len(present) * _NEAR_SHARE) :]
    if len(far) < _MIN_VALUES:
        return None
    steps = np.sort(-np.diff(1 / far))
    taken = steps[: max(1, int(len(steps) * _SMALL_SHARE))]
    low, middle, high = np.percentile(taken, [25, 50, 75])
    coarseness = float(np.median(np.diff(far)))
    return DepthScale(float(DISPARITY_STEP / middle), float((high - low) / middle), coarseness, len(present))
