# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What a rule is: a check with its code, its limits and its documentation in one place."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING

from tumtools.validate.finding import NOWHERE, Finding, Place, Severity

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from tumtools.validate.subject import Subject

Limits = dict[str, float]
"""Name of a limit -> its value, as configured."""


class Needs(Enum):
    """What a rule looks at, and so at which level it runs."""

    TEXT = "text files, listings and headers"
    PIXELS = "decoded images"


@dataclass(frozen=True, slots=True)
class Limit:
    """A configurable number of a rule.

    Attributes:
        default: Its value.
        unit: Its unit, as a word.
        meaning: What it limits.

    """

    default: float
    unit: str
    meaning: str


@dataclass(frozen=True, slots=True)
class Found:
    """A finding before the rule's code and the configured severity are put to it.

    Attributes:
        message: As in `Finding`.
        place: As in `Finding`.
        hint: As in `Finding`.
        measured: As in `Finding`.
        expected: As in `Finding`.
        severity: Other than the rule's own, where one rule has cases of different weight.

    """

    message: str
    place: Place = NOWHERE
    hint: str = ""
    measured: str = ""
    expected: str = ""
    severity: Severity | None = None


@dataclass(frozen=True, slots=True)
class Rule:
    """A check and all that is known about it.

    Attributes:
        code: `TUM101`; never changes its meaning.
        slug: Name for people.
        severity: Of its findings, unless configured otherwise.
        title: What it finds, in one sentence.
        why: Why it matters.
        how: How it is measured.
        mend: How to mend it.
        check: Yields what it finds.
        limits: Its configurable numbers, by name.
        needs: What it looks at.
        enabled: Whether it runs unless asked for by name.
        fixable: Whether `validate --fix` mends it.

    """

    code: str
    slug: str
    severity: Severity
    title: str
    why: str
    how: str
    mend: str
    check: Callable[[Subject, Limits], Iterator[Found]] = field(repr=False)
    limits: Mapping[str, Limit] = field(default_factory=dict)
    needs: Needs = Needs.TEXT
    enabled: bool = True
    fixable: bool = False

    def run(self, subject: Subject, limits: Limits, severity: Severity | None = None) -> Iterator[Finding]:
        """Yield the findings.

        Args:
            subject: The sequence.
            limits: Configured values; the others have their defaults.
            severity: Configured severity of all findings of this rule.

        """
        values = {name: limit.default for name, limit in self.limits.items()} | limits
        for found in self.check(subject, values):
            yield Finding(
                self.code,
                severity or found.severity or self.severity,
                found.message,
                found.place,
                found.hint,
                found.measured,
                found.expected,
            )


def rule(  # noqa: PLR0913 - the attributes of `Rule`, by name
    code: str,
    slug: str,
    severity: Severity,
    *,
    title: str,
    why: str,
    how: str,
    mend: str,
    limits: Mapping[str, Limit] | None = None,
    needs: Needs = Needs.TEXT,
    enabled: bool = True,
    fixable: bool = False,
) -> Callable[[Callable[[Subject, Limits], Iterator[Found]]], Rule]:
    """Make a rule of the function below; the arguments are the attributes of `Rule`."""

    def make(check: Callable[[Subject, Limits], Iterator[Found]]) -> Rule:
        return Rule(code, slug, severity, title, why, how, mend, check, limits or {}, needs, enabled, fixable)

    return make
