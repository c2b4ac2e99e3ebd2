# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What a check finds, where, and how bad it is."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from enum import IntEnum
from typing import Final, Self


class Severity(IntEnum):
    """How bad a finding is; greater is worse."""

    INFO = 1
    WARNING = 2
    ERROR = 3

    @property
    def word(self) -> str:
        """`info`, `warning` or `error`."""
        return self.name.lower()

    @classmethod
    def of_word(cls, word: str) -> Self:
        """Return the severity of a word.

        Raises:
            KeyError: There is none.

        """
        return cls[word.upper()]


SEVERITY_WORDS: Final = tuple(severity.word for severity in Severity)


@dataclass(frozen=True, slots=True)
class Place:
    """Where a finding is.

    Attributes:
        file: File within the source, relative and with `/`; empty for the source itself.
        line: Line of a text file, 1 = first.
        stream: Stream of the sequence.
        row: Image or row of the stream, 0 = first.
        stamp: Nanoseconds since 1970.

    """

    file: str = ""
    line: int | None = None
    stream: str | None = None
    row: int | None = None
    stamp: int | None = None

    def __str__(self) -> str:
        """Name the place as compilers do; rows only where there is no line."""
        if self.line is not None:
            return f"{self.file}:{self.line}"
        if self.file or self.stream is None:
            return self.file
        return self.stream if self.row is None else f"{self.stream}[{self.row}]"


NOWHERE: Final = Place()
"""The source as a whole."""


@dataclass(frozen=True, slots=True)
class Finding:
    """Something that a rule found.

    Attributes:
        code: Code of the rule.
        severity: How bad it is.
        message: What was found and what was expected, a sentence without a full stop.
        place: Where.
        hint: What to do about it; empty where the rule's page says it all.
        measured: What was measured, with its unit.
        expected: What it should be, with its unit.

    """

    code: str
    severity: Severity
    message: str
    place: Place = NOWHERE
    hint: str = ""
    measured: str = ""
    expected: str = ""

    @property
    def fingerprint(self) -> str:
        """A hash of rule, file, stamp or row and message; inserted lines do not change it."""
        place = self.place
        where = place.stamp if place.stamp is not None else place.row
        key = "\0".join([self.code, place.file, place.stream or "", str(where), self.message])
        return hashlib.sha256(key.encode("utf-8", "surrogateescape")).hexdigest()[:32]
