# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The small signals of a sequence as numpy columns, rows in the order of their file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """Poses of the colour camera's optical frame in the world.

    Attributes:
        stamps: Nanoseconds since 1970, int64, shape [n]. Not necessarily sorted or unique.
        positions: Metres, float64, shape [n, 3].
        quaternions: Rotations as x y z w, float64, shape [n, 4]. As read, not normalised.

    Raises:
        ValueError: The shapes do not fit together.

    """

    stamps: npt.NDArray[np.int64]
    positions: npt.NDArray[np.float64]
    quaternions: npt.NDArray[np.float64]

    def __post_init__(self) -> None:
        n = len(self.stamps)
        if self.stamps.shape != (n,) or self.positions.shape != (n, 3) or self.quaternions.shape != (n, 4):
            msg = (
                f"a trajectory needs shapes [n], [n, 3], [n, 4], "
                f"not {self.stamps.shape}, {self.positions.shape}, {self.quaternions.shape}"
            )
            raise ValueError(msg)

    def __len__(self) -> int:
        return len(self.stamps)

    @classmethod
    def empty(cls) -> Self:
        """Return one with no rows."""
        return cls(np.empty(0, np.int64), np.empty((0, 3)), np.empty((0, 4)))

    def take(self, rows: npt.NDArray[np.intp] | npt.NDArray[np.bool_] | slice) -> Trajectory:
        """Return the chosen rows, in the order given."""
        return Trajectory(self.stamps[rows], self.positions[rows], self.quaternions[rows])

    @property
    def values(self) -> npt.NDArray[np.float64]:
        """The seven numbers of each row, tx ty tz qx qy qz qw, shape [n, 7]."""
        return np.concatenate([self.positions, self.quaternions], axis=1)


@dataclass(frozen=True, slots=True, eq=False)
class Accelerometer:
    """Accelerations in the sensor's own axes, gravity included.

    Attributes:
        stamps: Nanoseconds since 1970, int64, shape [n].
        values: m/s2, float64, shape [n, 3].

    Raises:
        ValueError: The shapes do not fit together.

    """

    stamps: npt.NDArray[np.int64]
    values: npt.NDArray[np.float64]

    def __post_init__(self) -> None:
        n = len(self.stamps)
        if self.stamps.shape != (n,) or self.values.shape != (n, 3):
            msg = f"an accelerometer needs shapes [n], [n, 3], not {self.stamps.shape}, {self.values.shape}"
            raise ValueError(msg)

    def __len__(self) -> int:
        return len(self.stamps)

    @classmethod
    def empty(cls) -> Self:
        """Return one with no rows."""
        return cls(np.empty(0, np.int64), np.empty((0, 3)))

    def take(self, rows: npt.NDArray[np.intp] | npt.NDArray[np.bool_] | slice) -> Accelerometer:
        """Return the chosen rows, in the order given."""
        return Accelerometer(self.stamps[rows], self.values[rows])
