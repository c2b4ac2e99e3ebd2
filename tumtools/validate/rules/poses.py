# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""TUM401 to TUM407: the ground truth, by itself and against the accelerometer."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.validate.finding import Severity
from tumtools.validate.gravity import XYZW
from tumtools.validate.rule import Found, Limit, rule

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy.typing as npt

    from tumtools.model.signals import Trajectory
    from tumtools.validate.rule import Limits
    from tumtools.validate.subject import Subject

_ZERO_NORM: Final = 1e-6
_ABSURD: Final = 1e100
"""Squares of greater numbers overflow."""
_ROUNDING_NOISE: Final = 1e-7
_MOVES_METRES: Final = 0.1
_UP: Final = 0.9
"""Least z of a direction that counts as up, in a world whose z is up as that of a motion capture system."""


def _is_valid(poses: Trajectory) -> npt.NDArray[np.bool_]:
    """Tell the rows with finite numbers of a sensible size and a quaternion that is not zero."""
    values = poses.values
    sizes: npt.NDArray[np.float64] = np.abs(np.nan_to_num(values, nan=np.inf))
    sensible = np.all(sizes < _ABSURD, axis=1)
    norms = np.linalg.norm(np.where(sensible[:, None], poses.quaternions, 0), axis=1)
    valid: npt.NDArray[np.bool_] = sensible & (norms > _ZERO_NORM)
    return valid


def _decimals(subject: Subject) -> int | None:
    """Return the decimals of the quaternions in the text, None where there is none or they differ."""
    text = subject.texts.get("groundtruth")
    match = None if text is None else re.fullmatch(r"%\.(\d+)f", text.table.layout.value_format)
    return None if match is None else int(match[1])


@rule(
    "TUM401",
    "quaternion-norm",
    Severity.WARNING,
    title="A quaternion is not of unit length.",
    why="Formulas for rotations assume it; a norm of 0.99 shrinks the map by two per cent.",
    how="The deviation of the norm from 1 is compared with what rounding to the printed decimals explains.",
    mend="Normalise (`validate --fix`).",
    limits={
        "deviation": Limit(
            1.0, "last decimals", "largest deviation that rounding explains, and at least 1e-4"
        ),
        "error": Limit(0.01, "", "deviation from which on it is an error"),
    },
    fixable=True,
)
def quaternion_norm(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Look at the norms."""
    if subject.groundtruth is None:
        return
    poses = subject.groundtruth
    valid = _is_valid(poses)
    deviation = np.where(
        valid, np.abs(np.linalg.norm(np.where(valid[:, None], poses.quaternions, 1), axis=1) - 1), 0
    )
    decimals = _decimals(subject)
    allowed = max(1e-4, limits["deviation"] * 10.0 ** -(decimals if decimals is not None else 4))
    wrong = np.flatnonzero(deviation > allowed + _ROUNDING_NOISE)
    if len(wrong):
        worst = float(deviation[wrong].max())
        rows = "1 row" if len(wrong) == 1 else f"{len(wrong)} rows"
        yield Found(
            f"the quaternions of {rows} are off unit length by up to {worst:.2g}; rounding "
            f"explains {allowed:.1g}",
            subject.place("groundtruth", int(wrong[np.argmax(deviation[wrong])])),
            measured=f"{worst:.3g}",
            expected=f"at most {allowed:.1g}",
            severity=Severity.ERROR if worst > limits["error"] else None,
        )


@rule(
    "TUM402",
    "quaternion-zero",
    Severity.ERROR,
    title="A pose is no pose: an all-zero quaternion, or a number that is not finite.",
    why="One NaN makes a whole evaluation NaN; trackers write such rows while they are lost.",
    how="Every number is looked at.",
    mend="Remove the row.",
)
def quaternion_zero(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Look for rows that are no poses."""
    del limits
    if subject.groundtruth is None:
        return
    poses = subject.groundtruth
    for row in np.flatnonzero(~_is_valid(poses)).tolist():
        sensible = bool((np.abs(np.nan_to_num(poses.values[row], nan=np.inf)) < _ABSURD).all())
        what = "the quaternion is zero" if sensible else "a number is not finite, or absurdly large"
        yield Found(what, subject.place("groundtruth", row))


@rule(
    "TUM403",
    "quaternion-order",
    Severity.ERROR,
    title="The quaternions are in another order, or the poses are inverse.",
    why="Every rotation is wrong, and it may still look like a trajectory.",
    how=(
        "With the right reading, the accelerometer turned into the world points the same "
        "way, up, all through "
        "the sequence. The fit of x y z w is compared with that of w first and of inverse poses. A sequence "
        "that hardly rotates cannot decide, and nothing is said."
    ),
    mend="Write x y z w, and the pose of the camera in the world (`validate --fix` if w is first).",
    limits={
        "ratio": Limit(1.5, "of the angles", "how much better another reading must fit"),
        "degrees": Limit(1.0, "deg", "by how much, at least"),
    },
    fixable=True,
)
def quaternion_order(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Compare the fits to gravity."""
    other = better_reading(subject, limits["ratio"], limits["degrees"])
    if other is None:
        return
    here, there = subject.gravity[XYZW].rms_degrees, subject.gravity[other[0]].rms_degrees
    yield Found(
        f"gravity fits {' or '.join(other)} with {there:.1f} deg and x y z w with {here:.1f} deg only",
        subject.stream_place("groundtruth"),
        measured=f"{here:.2f} deg",
        expected=f"{there:.2f} deg",
    )


def better_reading(subject: Subject, ratio: float, degrees: float) -> list[str] | None:
    """Return the readings of the quaternions that fit gravity clearly better than x y z w; None if none does.

    That w is first and that poses are inverse fit equally well; the direction found to be up tells them
    apart where the world's z is up. Otherwise both are returned.
    """
    fits = subject.gravity
    if not fits:
        return None
    here = fits[XYZW].rms_degrees
    readings = ["w x y z", "inverse poses"]
    best = min(fits[reading].rms_degrees for reading in readings)
    if here < ratio * best or here - best < degrees:
        return None
    upright = [reading for reading in readings if fits[reading].up[2] > _UP]
    return upright if len(upright) == 1 else readings


@rule(
    "TUM404",
    "quaternion-sign-flip",
    Severity.INFO,
    title="Neighbouring quaternions have opposite signs.",
    why="q and -q are the same rotation, but interpolating the numbers between them goes the long way round.",
    how="The scalar product of neighbours is negative. Common in the published files.",
    mend="Nothing to mend; interpolate with the shorter way.",
)
def quaternion_sign_flip(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Look for changes of sign."""
    del limits
    if subject.groundtruth is None or len(subject.groundtruth) == 0:
        return
    valid = _is_valid(subject.groundtruth)
    quaternions = np.where(valid[:, None], subject.groundtruth.quaternions, 0)
    flips = np.flatnonzero((quaternions[1:] * quaternions[:-1]).sum(axis=1) < 0) + 1
    if len(flips):
        yield Found(
            f"{len(flips)} quaternions have the opposite sign of the one before",
            subject.place("groundtruth", int(flips[0])),
            measured=str(len(flips)),
        )


@rule(
    "TUM405",
    "pose-jump",
    Severity.WARNING,
    title="The camera jumps.",
    why=(
        "The motion capture lost its markers and found them elsewhere; an evaluation there measures the jump."
    ),
    how=(
        "Distance and angle between neighbouring poses over their time, at least the median step. In an "
        "estimate, which jumps when a loop closes, it is an information only."
    ),
    mend="Leave the time out of an evaluation.",
    limits={
        "metres_per_second": Limit(5, "m/s", "greatest speed"),
        "degrees_per_second": Limit(720, "deg/s", "greatest turning speed"),
    },
)
def pose_jump(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Look at the speeds."""
    if subject.groundtruth is None:
        return
    rows = np.flatnonzero(_is_valid(subject.groundtruth))
    rows = rows[np.argsort(subject.groundtruth.stamps[rows], kind="stable")]
    if len(rows) < 3:  # noqa: PLR2004 - a median of one step says nothing
        return
    poses = subject.groundtruth.take(rows)
    steps = np.diff(poses.stamps) / 1e9
    seconds = np.maximum(steps, np.median(steps))
    if not seconds.all():
        return
    quaternions = poses.quaternions / np.linalg.norm(poses.quaternions, axis=1, keepdims=True)
    speed = np.linalg.norm(np.diff(poses.positions, axis=0), axis=1) / seconds
    # From the chord, not from the cosine: rounding of the numbers near 1 would pass for a turn.
    chord = np.minimum(
        np.linalg.norm(quaternions[1:] - quaternions[:-1], axis=1),
        np.linalg.norm(quaternions[1:] + quaternions[:-1], axis=1),
    )
    turn = np.degrees(4 * np.arcsin(np.clip(chord / 2, 0, 1))) / seconds
    for index in np.flatnonzero(speed > limits["metres_per_second"]).tolist():
        yield _jump(
            subject, int(rows[index + 1]), f"{speed[index]:.1f} m/s", f"{limits['metres_per_second']:g} m/s"
        )
    fast = (turn > limits["degrees_per_second"]) & (speed <= limits["metres_per_second"])
    for index in np.flatnonzero(fast).tolist():
        yield _jump(
            subject,
            int(rows[index + 1]),
            f"{turn[index]:.0f} deg/s",
            f"{limits['degrees_per_second']:g} deg/s",
        )


def _jump(subject: Subject, row: int, measured: str, limit: str) -> Found:
    return Found(
        f"a jump from the pose before, at {measured}",
        subject.place("groundtruth", row),
        measured=measured,
        expected=f"at most {limit}",
        severity=Severity.INFO if subject.is_estimate else None,
    )


@rule(
    "TUM406",
    "pose-frozen",
    Severity.WARNING,
    title="The pose does not change at all for a while.",
    why="A system that lost track and repeats its last pose gives the camera a rest that it did not have.",
    how=(
        "Identical rows in sequence are counted. A camera that stands still throughout gets an "
        "information only."
    ),
    mend="Leave the time out of an evaluation.",
    limits={"rows": Limit(100, "rows", "longest run of identical poses")},
)
def pose_frozen(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Look for runs of identical poses."""
    if subject.groundtruth is None or len(subject.groundtruth) == 0:
        return
    values = subject.groundtruth.values
    changes = np.flatnonzero((values[1:] != values[:-1]).any(axis=1)) + 1
    starts = np.concatenate([[0], changes])
    lengths = np.diff(np.concatenate([starts, [len(values)]]))
    positions = subject.groundtruth.positions[_is_valid(subject.groundtruth)]
    moves = len(positions) > 0 and float(np.ptp(positions, axis=0).max()) > _MOVES_METRES
    for start, length in zip(starts.tolist(), lengths.tolist(), strict=True):
        if length > limits["rows"]:
            yield Found(
                f"{length} identical poses in a row",
                subject.place("groundtruth", start),
                measured=str(length),
                expected=f"at most {limits['rows']:g}",
                severity=None if moves else Severity.INFO,
            )


@rule(
    "TUM407",
    "groundtruth-sync",
    Severity.WARNING,
    title="Accelerometer and ground truth are apart in time.",
    why="The ground truth is evaluated at the images' stamps; an offset of clocks turns motion into error.",
    how=(
        "The fit to gravity (TUM403) is made at shifted stamps; a parabola through the best gives the offset."
    ),
    mend="Shift the stamps of the ground truth (`--offset` of `evaluate`).",
    limits={
        "milliseconds": Limit(50, "ms", "largest offset"),
        "contrast": Limit(3.0, "of the angles", "how much worse the fit must be at the middling shift"),
    },
)
def groundtruth_sync(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Estimate the offset of the clocks."""
    if not subject.gravity or better_reading(subject, 1.5, 1.0) is not None:
        return
    estimate = subject.accelerometer_offset
    if estimate is None:
        return
    seconds, contrast = estimate
    if abs(seconds) * 1e3 > limits["milliseconds"] and contrast >= limits["contrast"]:
        yield Found(
            f"the accelerometer fits the ground truth best when its stamps are shifted by "
            f"{seconds * 1e3:+.0f} ms",
            subject.stream_place("groundtruth"),
            measured=f"{seconds * 1e3:.1f} ms",
            expected=f"within {limits['milliseconds']:g} ms",
        )


RULES = (
    quaternion_norm,
    quaternion_zero,
    quaternion_order,
    quaternion_sign_flip,
    pose_jump,
    pose_frozen,
    groundtruth_sync,
)
