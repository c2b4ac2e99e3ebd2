# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Trajectories made fit for measuring, and what had to be left out for it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.errors import InputError, UsageError
from tumtools.evaluate.associate import last_rows
from tumtools.model.signals import Trajectory
from tumtools.model.time import format_stamp

if TYPE_CHECKING:
    import numpy.typing as npt

LOUD_BELOW: Final = 0.9
"""Share of poses with a partner below which a warning is given."""


@dataclass(frozen=True, slots=True, eq=False)
class Clean:
    """A trajectory with strictly ascending stamps and finite numbers.

    Attributes:
        trajectory: The poses that remain.
        notes: A sentence for each kind of row that was left out.

    """

    trajectory: Trajectory
    notes: tuple[str, ...]


def clean(trajectory: Trajectory, who: str, *, rotations: bool) -> Clean:
    """Sort by stamp and leave out rows that cannot be measured.

    Left out are rows with a number that is not finite, with rotations also those whose quaternion is
    zero, and of rows with equal stamps all but the last. The benchmark's scripts do the same for the
    relative error; for the absolute error they fail on NaN.

    Args:
        trajectory: Poses in any order.
        who: What to call it in notes and errors: `ground truth` or `estimate`.
        rotations: Whether the quaternions are needed too.

    Raises:
        InputError: No row remains.

    """
    values = trajectory.values if rotations else trajectory.positions
    finite = np.isfinite(values).all(axis=1)
    turned = (trajectory.quaternions != 0.0).any(axis=1) if rotations else np.ones(len(trajectory), bool)
    usable = np.flatnonzero(finite & turned)
    rows = usable[last_rows(trajectory.stamps[usable])]
    counts = (
        (np.count_nonzero(~finite), "with NaN or infinity"),
        (np.count_nonzero(finite & ~turned), "with a zero quaternion"),
        (len(usable) - len(rows), "whose stamp comes again"),
    )
    notes = tuple(
        f"{who}: {count} of {len(trajectory)} rows {what} left out" for count, what in counts if count
    )
    if not len(rows):
        msg = f"the {who} has no pose that can be measured" + (f" ({'; '.join(notes)})" if notes else "")
        raise InputError(msg)
    return Clean(trajectory.take(rows), notes)


def no_pairs_error(
    found: int, groundtruth: npt.NDArray[np.int64], estimate: npt.NDArray[np.int64], limit: str
) -> InputError:
    """Say that too few poses match, with what can be told from the stamps about the reason.

    Args:
        found: How many matched.
        groundtruth: Ascending stamps, ns, not empty.
        estimate: Ascending stamps, ns, offset included, not empty.
        limit: How near stamps had to be, in words.

    """
    many = {0: "no pose", 1: "only one pose"}.get(found, f"only {found} poses")
    apart = max(int(groundtruth[0]) - int(estimate[-1]), int(estimate[0]) - int(groundtruth[-1]))
    if min(len(groundtruth), len(estimate)) == 1:
        hint = "a trajectory needs at least two poses with different stamps"
    elif apart > 0:
        hint = f"they are {apart / 1e9:.3f} s apart: choose the matching ground truth, or set the time offset"
    else:
        hint = "allow a larger difference in time, or set the time offset"
    return InputError(
        f"{many} of the estimate has a ground-truth pose {limit}, and two are needed; "
        f"the ground truth has {_span(groundtruth)}, the estimate {_span(estimate)}",
        hint=hint,
    )


def _span(stamps: npt.NDArray[np.int64]) -> str:
    if len(stamps) == 1:
        return f"one stamp, {_seconds(stamps[0])}"
    return f"{len(stamps)} stamps from {_seconds(stamps[0])} to {_seconds(stamps[-1])}"


def _seconds(stamp: np.int64) -> str:
    text = format_stamp(int(stamp), 9)
    return text.rstrip("0").rstrip(".")


def matched_note(matched: int, possible: int) -> tuple[str, ...]:
    """Return a warning when fewer than nine in ten poses that could have a partner have one."""
    if not possible or matched >= LOUD_BELOW * possible:
        return ()
    share = 100.0 * matched / possible
    text = f"only {matched} of {possible} poses ({share:.1f} %) have a partner"
    return (f"{text}: the numbers say nothing about the others",)


def scaled(trajectory: Trajectory, scale: float) -> Trajectory:
    """Multiply the positions.

    Raises:
        UsageError: The scale is not positive and finite.

    """
    if not (np.isfinite(scale) and scale > 0.0):
        msg = f"a scale must be positive, not {scale!r}"
        raise UsageError(msg)
    if scale == 1.0:
        return trajectory
    return Trajectory(trajectory.stamps, trajectory.positions * scale, trajectory.quaternions)
