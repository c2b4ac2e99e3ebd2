# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""TUM501 and TUM502: the accelerometer by itself."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.validate.finding import Place, Severity
from tumtools.validate.rule import Found, Limit, rule
from tumtools.validate.subject import ProblemKind

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tumtools.validate.rule import Limits
    from tumtools.validate.subject import Subject

_MIN_ROWS: Final = 10
_ABSURD: Final = 1e100
"""Squares of greater numbers overflow."""
_NEAR: Final = 0.06


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
    norms = np.linalg.norm(values[(np.abs(np.nan_to_num(values, nan=np.inf)) < _ABSURD).all(axis=1)], axis=1)
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
        f"the median norm is {median:.3g} m/s2{guess}",
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


RULES = (accelerometer_gravity, accelerometer_columns)
