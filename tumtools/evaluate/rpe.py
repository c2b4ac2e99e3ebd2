# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Relative pose error over a fixed distance, or of random pairs.

Sturm et al., "A Benchmark for the Evaluation of RGB-D SLAM Systems" (2012), section VI.A, as the
benchmark's `evaluate_rpe.py` computes it, pair for pair; `tumtools.evaluate.allpairs` has the
average over all distances (equation 3).

For a pair (i, j) of the estimate's poses P and the nearest ground-truth poses Q the scripts compare
P_j^-1 P_i with Q_j^-1 Q_i, that is, the motion seen from the later pose, where the paper's
equation 1 has it seen from the earlier one. The rotational error is the same, the translational
error of one pair is not.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, get_args

import numpy as np

from tumtools.errors import InputError, UsageError
from tumtools.evaluate.geometry import angles, conjugate, multiply, normalised, rotate
from tumtools.evaluate.interpolate import interpolate
from tumtools.evaluate.sampling import random_pairs, sample
from tumtools.evaluate.seconds import rounded_seconds
from tumtools.evaluate.statistics import Statistics
from tumtools.evaluate.trajectories import clean, matched_note, no_pairs_error, scaled
from tumtools.model.time import NANOSECONDS_PER_SECOND

if TYPE_CHECKING:
    import numpy.typing as npt

    from tumtools.evaluate.geometry import Array
    from tumtools.model.signals import Trajectory

Unit = Literal["s", "m", "rad", "deg", "f"]
UNITS: Final[tuple[Unit, ...]] = get_args(Unit)
"""Seconds, metres travelled, radians or degrees turned, frames; all along the estimate."""

RANDOM_PAIRS: Final = 10_000
"""Number of random pairs by default, as in the scripts."""
MAX_PAIRS: Final = 1_000_000
"""More are not kept in memory."""


@dataclass(frozen=True, slots=True)
class Sampling:
    """A choice of pairs, the same on every machine (`tumtools.evaluate.sampling`).

    Attributes:
        max_pairs: Use at most so many, 2 .. `MAX_PAIRS`.
        seed: For the choice, 0 .. 2**64 - 1.
        random: Instead of pairs at a fixed distance, choose among all n^2 ordered pairs (i, j), i = j
            included, with replacement; all of them if there are not more than `max_pairs`. This is
            what the scripts do without `--fixed_delta`, with their own random numbers.

    Raises:
        UsageError: A number is out of range.

    """

    max_pairs: int = RANDOM_PAIRS
    seed: int = 0
    random: bool = False

    def __post_init__(self) -> None:
        if not 2 <= self.max_pairs <= MAX_PAIRS:  # noqa: PLR2004 - fewer have no statistics
            msg = f"a number of pairs must be in 2 .. {MAX_PAIRS}, not {self.max_pairs}"
            raise UsageError(msg, hint="the average over all pairs can be had exactly: --all-pairs")
        if not 0 <= self.seed < 2**64:
            msg = f"a seed must be in 0 .. 2**64 - 1, not {self.seed}"
            raise UsageError(msg)


@dataclass(frozen=True, slots=True, eq=False)
class RpeResult:
    """Relative pose error of m pairs of poses, in order of the pairs' first pose (random: as drawn).

    Attributes:
        translation: Statistics of the translational errors, metres.
        rotation: Statistics of the rotational errors, degrees; all of them, the median too.
        translational_errors: Metres, shape [m].
        rotational_errors: Radians, shape [m].
        estimate_stamps: Of the two poses of each pair, ns, int64, shape [m, 2].
        groundtruth_stamps: Of the ground-truth poses compared with, ns, int64, shape [m, 2].
        candidates: Pairs before those without ground truth were left out.
        groundtruth_count: Poses of the ground truth.
        estimate_count: Poses of the estimate.
        estimate_matched: Poses of the estimate that have ground truth.
        max_difference: Limit of the difference in time that was used, ns; 0 when interpolated.
        delta: Distance of the poses of a pair that was asked for; None for random pairs.
        unit: Its unit.
        notes: What the user should know.

    """

    translation: Statistics
    rotation: Statistics
    translational_errors: npt.NDArray[np.float64]
    rotational_errors: npt.NDArray[np.float64]
    estimate_stamps: npt.NDArray[np.int64]
    groundtruth_stamps: npt.NDArray[np.int64]
    candidates: int
    groundtruth_count: int
    estimate_count: int
    estimate_matched: int
    max_difference: int
    delta: float | None
    unit: Unit
    notes: tuple[str, ...]

    @property
    def pairs(self) -> int:
        """How many pairs were compared."""
        return len(self.translational_errors)

    @property
    def described(self) -> str:
        """How many pairs of which kind, in words."""
        if self.delta is None:
            return f"{self.pairs} random pairs"
        return f"{self.pairs} pairs {_distance(self.delta, self.unit)} apart"


def evaluate_rpe(
    groundtruth: Trajectory,
    estimate: Trajectory,
    *,
    delta: float = 1.0,
    unit: Unit = "s",
    sampling: Sampling | None = None,
    offset: int = 0,
    scale: float = 1.0,
    max_hole: int | None = None,
) -> RpeResult:
    """Measure the relative pose error.

    Args:
        groundtruth: True poses.
        estimate: Poses to judge.
        delta: Distance of the two poses of a pair, in `unit`, along the estimate. For each pose the
            nearest to this distance is its partner; pairs that end with the last pose are left out,
            as in the scripts, because there the distance is too short.
        unit: One of `UNITS`.
        sampling: Which of the pairs to use; None for all.
        offset: Added to the estimate's stamps, ns.
        scale: Multiplies the estimate's positions.
        max_hole: Interpolate the ground truth at the estimate's stamps, but not across holes longer
            than this, ns. By default the nearest ground-truth pose is taken, which may be as far as
            twice the median step of the ground truth, as in the scripts.

    Raises:
        InputError: Fewer than two pairs can be compared.
        UsageError: An argument makes no sense.

    """
    _check(delta, unit)
    true = clean(groundtruth, "ground truth", rotations=True)
    judged = clean(estimate, "estimate", rotations=True)
    poses = judged.trajectory
    limit, partner, near = _partners(true.trajectory, poses, offset, max_hole)
    if np.count_nonzero(near) < 2:  # noqa: PLR2004 - a pair needs two
        how = f"within {limit / 1e9:g} s" if max_hole is None else "to interpolate between"
        raise no_pairs_error(int(near.sum()), true.trajectory.stamps, poses.stamps + offset, how)
    random = sampling if sampling is not None and sampling.random else None
    if random is not None:
        first, second = _random_pairs(len(poses), random)
    else:
        first, second = fixed_pairs(poses, delta, unit)
        if sampling is not None:
            chosen = sample(len(first), sampling.max_pairs, sampling.seed)
            first, second = first[chosen], second[chosen]
    known = near[first] & near[second]
    candidates = len(first)
    first, second = first[known], second[known]
    if len(first) < 2:  # noqa: PLR2004 - as the scripts
        raise _too_few(len(first), candidates, delta, unit, poses)
    place = partner if max_hole is None else np.cumsum(near) - 1
    reference = (
        true.trajectory
        if max_hole is None
        else interpolate(true.trajectory, poses.stamps + offset, max_hole)[0]
    )
    trans, rot = relative_errors(
        scaled(poses, scale), reference, (first, second), (place[first], place[second])
    )
    return RpeResult(
        translation=Statistics.of(trans),
        rotation=Statistics.of(np.degrees(rot)),
        translational_errors=trans,
        rotational_errors=rot,
        estimate_stamps=np.stack([poses.stamps[first], poses.stamps[second]], axis=1),
        groundtruth_stamps=np.stack(
            [reference.stamps[place[first]], reference.stamps[place[second]]], axis=1
        ),
        candidates=candidates,
        groundtruth_count=len(true.trajectory),
        estimate_count=len(poses),
        estimate_matched=int(near.sum()),
        max_difference=limit,
        delta=delta if random is None else None,
        unit=unit,
        notes=(
            *true.notes,
            *judged.notes,
            *matched_note(int(near.sum()), len(poses)),
            *(_distance_note(poses, delta, unit, (first, second)) if random is None else ()),
        ),
    )


def _check(delta: float, unit: str) -> None:
    if unit not in UNITS:
        msg = f"unknown unit {unit!r}; there are {', '.join(UNITS)}"
        raise UsageError(msg)
    if not (np.isfinite(delta) and delta > 0.0):
        msg = f"the distance of a pair must be finite and more than 0, not {delta!r}"
        raise UsageError(msg)


def _partners(
    groundtruth: Trajectory, estimate: Trajectory, offset: int, max_hole: int | None
) -> tuple[int, npt.NDArray[np.intp], npt.NDArray[np.bool_]]:
    """Return the limit in time (ns), and for each pose its ground-truth row and whether that is near."""
    times = estimate.stamps + offset
    if max_hole is not None:
        return 0, np.empty(0, np.intp), interpolate(groundtruth, times, max_hole)[1]
    partner = closest_index(rounded_seconds(groundtruth.stamps), rounded_seconds(estimate.stamps, offset))
    # Twice the median step, of which only its integer part matters when compared with integers.
    limit = int(2 * np.median(np.diff(groundtruth.stamps))) if len(groundtruth) > 1 else 0
    return limit, partner, np.abs(groundtruth.stamps[partner] - times) <= limit


def _too_few(found: int, candidates: int, delta: float, unit: Unit, estimate: Trajectory) -> InputError:
    seconds = (int(estimate.stamps[-1]) - int(estimate.stamps[0])) / NANOSECONDS_PER_SECOND
    return InputError(
        f"only {found} of {candidates} pairs of poses {_distance(delta, unit)} apart can be compared, and "
        f"two are needed; the estimate has {len(estimate)} poses in {seconds:.3f} s",
        hint="choose a shorter distance",
    )


def _distance(delta: float, unit: Unit) -> str:
    return f"{delta:g} {'frames' if unit == 'f' else unit}"


def _distance_note(
    estimate: Trajectory,
    delta: float,
    unit: Unit,
    pairs: tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]],
) -> tuple[str, ...]:
    """Warn of pairs whose distance is far from what was asked for; the scripts compare them silently."""
    places = _travelled(estimate, unit)
    wrong = np.count_nonzero(np.abs(places[pairs[1]] - places[pairs[0]] - delta) > delta / 2)
    if not wrong:
        return ()
    text = f"{wrong} of {len(pairs[0])} pairs are less than half or more than one and a half times"
    return (f"{text} {_distance(delta, unit)} apart: no pose of the estimate is nearer to that distance",)


def _random_pairs(n: int, sampling: Sampling) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Return random pairs, or all n^2 if these are not more."""
    if n * n <= sampling.max_pairs:
        first, second = np.divmod(np.arange(n * n), n)
        return first, second
    first, second = random_pairs(n, sampling.max_pairs, sampling.seed)
    return first, second


def fixed_pairs(
    estimate: Trajectory, delta: float, unit: Unit
) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Return the scripts' pairs (i, j): j nearest to i plus `delta`, unless that is the last pose.

    Args:
        estimate: Cleaned trajectory, n poses.
        delta: Distance, in `unit`.
        unit: One of `UNITS`.

    Returns:
        Rows i and j, ascending in i, shape [m <= n] each.

    """
    places = _travelled(estimate, unit)
    second = closest_index(places, places + delta)
    first = np.flatnonzero(second != len(estimate) - 1)
    return first, second[first]


def _travelled(estimate: Trajectory, unit: Unit) -> Array:
    """Return how far each pose is along the trajectory, in seconds, metres, radians, degrees or frames."""
    if unit == "s":
        return rounded_seconds(estimate.stamps)
    if unit == "f":
        return np.arange(len(estimate), dtype=np.float64)
    if unit == "m":
        steps = np.linalg.norm(np.diff(estimate.positions, axis=0), axis=1)
    else:
        turns = normalised(estimate.quaternions)
        steps = angles(multiply(conjugate(turns[1:]), turns[:-1]))
        steps = np.degrees(steps) if unit == "deg" else steps
    return np.concatenate([[0.0], np.cumsum(steps)])


def closest_index(places: Array, wanted: Array) -> npt.NDArray[np.intp]:
    """Return the index that the scripts' binary search ends with, for each of `wanted`, shape [k].

    The index of the nearest place; which of several equally near ones depends on the way of the
    search, and with it the scripts' pairs where a camera stands still. So the search is done step
    by step here too, for all wanted values at once.

    Args:
        places: Not descending, shape [n], n > 0.
        wanted: Shape [k].

    """
    best = np.zeros(len(wanted), np.intp)
    difference = np.abs(places[0] - wanted)
    begin, end = np.zeros(len(wanted), np.intp), np.full(len(wanted), len(places), np.intp)
    active = np.arange(len(wanted))
    while len(active):
        middle = (begin[active] + end[active]) // 2
        away = places[middle] - wanted[active]
        # A hit ends the search even where the first place was as near.
        nearer = (np.abs(away) < difference[active]) | (away == 0)
        best[active[nearer]] = middle[nearer]
        difference[active[nearer]] = np.abs(away[nearer])
        end[active[away > 0]] = middle[away > 0]
        begin[active[away < 0]] = middle[away < 0] + 1
        active = active[(away != 0) & (begin[active] < end[active])]
    return best


def relative_errors(
    estimate: Trajectory,
    groundtruth: Trajectory,
    estimate_rows: tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]],
    groundtruth_rows: tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]],
) -> tuple[Array, Array]:
    """Compare the motion between pairs of poses.

    Args:
        estimate: P, with finite numbers and quaternions that are not zero.
        groundtruth: Q, likewise.
        estimate_rows: i and j, shape [m] each.
        groundtruth_rows: The rows of Q that belong to them, shape [m] each.

    Returns:
        Norm of the translation (metres) and angle (radians, 0 .. pi) of
        (P_j^-1 P_i)^-1 (Q_j^-1 Q_i), shape [m] each.

    """
    move_p, turn_p = _motion(estimate, *estimate_rows)
    move_q, turn_q = _motion(groundtruth, *groundtruth_rows)
    # A rotation does not change the norm, so the error's own rotation need not be applied.
    return np.linalg.norm(move_q - move_p, axis=1), angles(multiply(conjugate(turn_p), turn_q))


def _motion(
    trajectory: Trajectory, first: npt.NDArray[np.intp], second: npt.NDArray[np.intp]
) -> tuple[Array, Array]:
    """Return X_j^-1 X_i as translation [m, 3] and unit quaternion [m, 4]."""
    turns = normalised(trajectory.quaternions)
    back = conjugate(turns[second])
    move = rotate(back, trajectory.positions[first] - trajectory.positions[second])
    return move, multiply(back, turns[first])
