# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The numbers that errors are summed up with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Self

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt

STATISTICS: Final = ("rmse", "mean", "median", "std", "min", "max", "sse")
"""Names, in the order in which the benchmark's scripts print them; `sse` is ours."""


@dataclass(frozen=True, slots=True)
class Statistics:
    """Statistics of errors, in the unit of the errors (`sse`: its square).

    Attributes:
        rmse: Root of the mean square.
        mean: Mean.
        median: Median.
        std: Standard deviation of the population (divided by n), as the scripts have it.
        min: Smallest.
        max: Largest.
        sse: Sum of squares.

    """

    rmse: float
    mean: float
    median: float
    std: float
    min: float
    max: float
    sse: float

    @classmethod
    def of(cls, errors: npt.NDArray[np.float64]) -> Self:
        """Sum up errors, shape [n], n > 0."""
        sse = float(np.dot(errors, errors))
        return cls(
            rmse=float(np.sqrt(sse / len(errors))),
            mean=float(np.mean(errors)),
            median=float(np.median(errors)),
            std=float(np.std(errors)),
            min=float(np.min(errors)),
            max=float(np.max(errors)),
            sse=sse,
        )

    def as_dict(self) -> dict[str, float]:
        """Return the numbers by name, in the order of `STATISTICS`."""
        return {name: getattr(self, name) for name in STATISTICS}
