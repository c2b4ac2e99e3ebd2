# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""TUM501 to TUM503: the accelerometer by itself."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.validate.finding import Place, Severity
from tumtools.validate.rule import Found, Limit, rule
from tumtools.validate.subject import ProblemKind

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy.typing as npt

    from tumtools.validate.rule import Limits
    from tumtools.validate.subject import Subject

_MIN_ROWS: Final = 10
_ABSURD: Final = 1e100
"""Squares of greater numbers overflow."""
_NEAR: Final = 0.06


def _is_sensible(values: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
    """Tell the rows with finite numbers of a sensible size."""
    sizes: npt.NDArray[np.float64] = np.abs(np.nan_to_num(values, nan=np.inf))
    sensible: npt.NDArray[np.bool_] = np.all(sizes < _ABSURD, axis=1)
    return sensible


@rule(
    "TUM501",
    "accelerometer-gravity",
    Severity.WARNING,
    title="The accelerometer does not feel gravity.",
    why="A wrong unit, or gravity taken out: filters that expect specific force in m/s2 go wrong.",
    how="The median of the norms must lie in the range; g as unit is recognised.",
    mend="Multiply by 9.80665 if the unit is g; put gravity back if it was taken out.",
    limits={
        "lowest": Limit(9.3, "m/s2", "least median norm"),
        "highest": Limit(10.3, "m/s2", "greatest median norm"),
    },
)
def accelerometer_gravity(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Look at the median norm."""
    if subject.accelerometer is None or len(subject.accelerometer) < _MIN_ROWS:
        return
    values = subject.accelerometer.values
    norms = np.linalg.norm(values[_is_sensible(values)], axis=1)
    median = float(np.median(norms)) if len(norms) else 0.0
    if limits["lowest"] <= median <= limits["highest"]:
        return
    guess = ""
    if abs(median - 1) < _NEAR:
        guess = ": the unit seems to be g"
    elif abs(median / 1000 - 1) < _NEAR:
        guess = ": the unit seems to be mg"
    elif median < 1:
        guess = ": gravity seems to have been taken out"
    yield Found(
        f"the median norm is {median:.4g} m/s2{guess}",
        subject.stream_place("accelerometer"),
        measured=f"{median:.4f} m/s2",
        expected=f"{limits['lowest']:g} .. {limits['highest']:g} m/s2",
    )


@rule(
    "TUM502",
    "accelerometer-columns",
    Severity.ERROR,
    title="The accelerometer file has other columns than ax ay az.",
    why="In files with six columns the gyroscope comes first as often as last; a reader takes three of them.",
    how="Rows with a stamp and six numbers are recognised as those of an IMU with a gyroscope.",
    mend="Keep the columns of the accelerations.",
)
def accelerometer_columns(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Look for IMU rows."""
    del limits
    text = subject.texts.get("accelerometer")
    problems = [] if text is None else text.problems(ProblemKind.IMU)
    if text is not None and problems:
        rows = "1 row has" if len(problems) == 1 else f"{len(problems)} rows have"
        yield Found(
            f"{rows} six numbers after the stamp: an IMU with a gyroscope; expected 'timestamp ax ay az'",
            Place(text.name, problems[0].line, "accelerometer"),
            measured="6 columns",
            expected="3 columns",
        )


@rule(
    "TUM503",
    "accelerometer-not-finite",
    Severity.ERROR,
    title="An acceleration is no number, or an absurd one.",
    why="One NaN makes every mean and every filter state after it NaN.",
    how="Every number is looked at.",
    mend="Remove the row.",
)
def accelerometer_not_finite(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Look for rows that are no accelerations."""
    del limits
    if subject.accelerometer is None:
        return
    for row in np.flatnonzero(~_is_sensible(subject.accelerometer.values)).tolist():
        yield Found("a number is not finite, or absurdly large", subject.place("accelerometer", row))


RULES = (accelerometer_gravity, accelerometer_columns, accelerometer_not_finite)
