# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The ground-truth pose of each pose of an estimate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tumtools.evaluate.associate import MAX_DIFFERENCE, Method, associate
from tumtools.evaluate.interpolate import interpolate
from tumtools.evaluate.trajectories import no_pairs_error

if TYPE_CHECKING:
    import numpy.typing as npt

    from tumtools.model.signals import Trajectory


@dataclass(frozen=True, slots=True, eq=False)
class Matched:
    """Poses of ground truth and estimate that belong together, row by row.

    Attributes:
        groundtruth: k poses.
        estimate: k poses, stamps without the offset.
        rows: Rows of the cleaned estimate that they are, shape [k].
        largest_difference: Largest distance in time of a pair, ns.

    """

    groundtruth: Trajectory
    estimate: Trajectory
    rows: npt.NDArray[np.intp]
    largest_difference: int


def match(
    groundtruth: Trajectory,
    estimate: Trajectory,
    *,
    max_difference: int = MAX_DIFFERENCE,
    offset: int = 0,
    method: Method = "tum",
    max_hole: int | None = None,
) -> Matched:
    """Find the ground-truth pose of each pose of the estimate: a near one, or one in between.

    Args:
        groundtruth: Cleaned trajectory.
        estimate: Cleaned trajectory.
        max_difference: Limit of the difference in time, ns.
        offset: Added to the estimate's stamps, ns.
        method: How to associate.
        max_hole: Interpolate the ground truth instead, but not across holes longer than this, ns.

    Raises:
        InputError: Fewer than two poses match.

    """
    if max_hole is not None:
        poses, known = interpolate(groundtruth, estimate.stamps + offset, max_hole)
        rows = np.flatnonzero(known)
        found = Matched(poses, estimate.take(rows), rows, 0)
        limit = f"on both sides, at most {max_hole / 1e9:g} s apart"
    else:
        pairs = associate(
            groundtruth.stamps, estimate.stamps, max_difference=max_difference, offset=offset, method=method
        )
        found = Matched(
            groundtruth.take(pairs.first), estimate.take(pairs.second), pairs.second, pairs.largest_difference
        )
        limit = f"within {max_difference / 1e9:g} s"
    if len(found.rows) < 2:  # noqa: PLR2004 - one pose can be put anywhere
        raise no_pairs_error(len(found.rows), groundtruth.stamps, estimate.stamps + offset, limit)
    return found
