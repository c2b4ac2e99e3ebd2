# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The report for programs; its schema is `report.schema.json` beside this file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from tumtools import __version__
from tumtools.printable import json_text
from tumtools.validate.finding import Severity
from tumtools.validate.rules import RULES

if TYPE_CHECKING:
    from tumtools.validate.engine import Report, Result
    from tumtools.validate.finding import Finding

SCHEMA_VERSION: Final = 1


def render(report: Report) -> str:
    """Render one JSON document; stamps are strings of integer nanoseconds."""
    document = {
        "schema_version": SCHEMA_VERSION,
        "tool": "tumtools",
        "version": __version__,
        "fail_on": None if report.fail_on is None else report.fail_on.word,
        "failed": report.failed,
        "sources": [_source(result, report) for result in report.results],
    }
    return json_text(document) + "\n"


def _source(result: Result, report: Report) -> dict[str, object]:
    return {
        "source": result.source,
        "name": result.name,
        "format": result.format or None,
        "level": result.level,
        "images": result.images,
        "failed": result.fails(report.fail_on),
        "counts": {severity.word: result.count(severity) for severity in reversed(Severity)},
        "accepted": result.accepted,
        "findings": [_finding(finding) for finding in result.findings],
    }


def _finding(finding: Finding) -> dict[str, object]:
    place = finding.place
    return {
        "code": finding.code,
        "slug": RULES[finding.code].slug,
        "severity": finding.severity.word,
        "message": finding.message,
        "hint": finding.hint or None,
        "file": place.file or None,
        "line": place.line,
        "stream": place.stream,
        "row": place.row,
        "stamp": None if place.stamp is None else str(place.stamp),
        "measured": finding.measured or None,
        "expected": finding.expected or None,
        "fingerprint": finding.fingerprint,
    }
