# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""TUM601: what the catalogue knows."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tumtools.validate.errata import explain
from tumtools.validate.finding import Severity
from tumtools.validate.rule import Found, rule

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tumtools.validate.rule import Limits
    from tumtools.validate.subject import Subject


@rule(
    "TUM601",
    "known-erratum",
    Severity.INFO,
    title="A deviation that is published with this sequence.",
    why="Repeated stamps and holes of the benchmark's own ground truth are no fault of yours.",
    how=(
        "The catalogue knows the repeated stamps, the number of gaps and the longest gap of each published "
        "ground truth. What is there and is listed is reported here once, instead of by "
        "TUM102, TUM103 and TUM109."
    ),
    mend="Nothing to mend; leave holes out of an evaluation.",
)
def known_erratum(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Report what the catalogue lists."""
    del limits
    for known in explain(subject):
        yield Found(known.message, subject.stream_place("groundtruth"))


RULES = (known_erratum,)
