# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Absolute trajectory error: how far the aligned estimate is from the ground truth.

Sturm et al., "A Benchmark for the Evaluation of RGB-D SLAM Systems" (2012), section VI.B, as the
benchmark's `evaluate_ate.py` computes it: associate, align all matched positions, measure distances.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tumtools.evaluate.align import Alignment, Mode, align
from tumtools.evaluate.associate import MAX_DIFFERENCE, Method
from tumtools.evaluate.matching import match
from tumtools.evaluate.statistics import Statistics
from tumtools.evaluate.trajectories import clean, matched_note, scaled

if TYPE_CHECKING:
    import numpy.typing as npt

    from tumtools.model.signals import Trajectory


@dataclass(frozen=True, slots=True, eq=False)
class AteResult:
    """Absolute trajectory error of matched poses, in order of the ground truth's stamps.

    Attributes:
        statistics: Of the errors, metres.
        errors: Distance of each pair after the alignment, metres, shape [k].
        groundtruth: The matched (or interpolated) ground-truth poses, k rows.
        estimate: The matched poses of the estimate, scaled and aligned, k rows; stamps as in its
            file, without the offset.
        aligned: All measurable poses of the estimate, scaled and aligned.
        alignment: Takes the (scaled) estimate to the ground truth.
        groundtruth_count: Poses of the ground truth.
        estimate_count: Poses of the estimate.
        largest_difference: Largest distance in time of a pair, ns; 0 when interpolated.
        notes: What the user should know: rows left out, few pairs, an alignment that is not unique.

    """

    statistics: Statistics
    errors: npt.NDArray[np.float64]
    groundtruth: Trajectory
    estimate: Trajectory
    aligned: Trajectory
    alignment: Alignment
    groundtruth_count: int
    estimate_count: int
    largest_difference: int
    notes: tuple[str, ...]

    @property
    def pairs(self) -> int:
        """How many poses were compared."""
        return len(self.errors)


def evaluate_ate(
    groundtruth: Trajectory,
    estimate: Trajectory,
    *,
    alignment: Mode = "se3",
    max_difference: int = MAX_DIFFERENCE,
    offset: int = 0,
    scale: float = 1.0,
    method: Method = "tum",
    max_hole: int | None = None,
) -> AteResult:
    """Measure the absolute trajectory error.

    Args:
        groundtruth: True poses.
        estimate: Poses to judge. Only positions are used.
        alignment: `se3`, `sim3` or `none`.
        max_difference: Limit of the difference in time, ns.
        offset: Added to the estimate's stamps, ns.
        scale: Multiplies the estimate's positions before everything else.
        method: How to associate (`tumtools.evaluate.associate`).
        max_hole: Interpolate the ground truth at the estimate's stamps instead of associating, but
            not across holes longer than this, ns.

    Raises:
        InputError: Fewer than two poses match, or a scale cannot be found.
        UsageError: An argument makes no sense.

    """
    interpolated = max_hole is not None
    true = clean(groundtruth, "ground truth", rotations=interpolated)
    judged = clean(estimate, "estimate", rotations=False)
    poses = scaled(judged.trajectory, scale)
    found = match(
        true.trajectory,
        poses,
        max_difference=max_difference,
        offset=offset,
        method=method,
        max_hole=max_hole,
    )
    best = align(found.estimate.positions, found.groundtruth.positions, alignment)
    aligned = best.trajectory(poses)
    matched = aligned.take(found.rows)
    errors = np.linalg.norm(matched.positions - found.groundtruth.positions, axis=1)
    possible = len(poses) if interpolated else min(len(poses), len(true.trajectory))
    notes = [*true.notes, *judged.notes, *matched_note(len(errors), possible)]
    if best.freedom:
        notes.append(
            f"the matched positions leave the {best.freedom} of the alignment open: "
            "the errors do not depend on it, the orientation of the aligned trajectory does"
        )
    return AteResult(
        statistics=Statistics.of(errors),
        errors=errors,
        groundtruth=found.groundtruth,
        estimate=matched,
        aligned=aligned,
        alignment=best,
        groundtruth_count=len(true.trajectory),
        estimate_count=len(poses),
        largest_difference=found.largest_difference,
        notes=tuple(notes),
    )
