# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Markdown, for the summary of a CI job or a comment."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from tumtools.printable import printable
from tumtools.validate.finding import Severity
from tumtools.validate.rules import RULES

if TYPE_CHECKING:
    from tumtools.validate.engine import Report, Result
    from tumtools.validate.finding import Finding

_SPECIAL: Final = str.maketrans({character: f"\\{character}" for character in "\\|`*_<>[]#"})


def render(report: Report) -> str:
    """Render a table of the sources, and one of findings for each source that has any."""
    lines = [
        "# tumtools validate",
        "",
        "| source | result | errors | warnings | info |",
        "|---|---|--:|--:|--:|",
    ]
    for result in report.results:
        word = "failed" if result.fails(report.fail_on) else "passed"
        counts = [str(result.count(severity)) for severity in reversed(Severity)]
        lines.append("| " + " | ".join([_escape(result.source), word, *counts]) + " |")
    for result in report.results:
        if result.findings:
            lines += ["", f"## {_escape(result.source)}", "", *_table(result)]
    return "\n".join(lines) + "\n"


def _table(result: Result) -> list[str]:
    rows = ["| severity | rule | where | what |", "|---|---|---|---|"]
    rows.extend(_row(finding) for finding in result.findings)
    return rows


def _row(finding: Finding) -> str:
    rule = f"{finding.code} {RULES[finding.code].slug}"
    hint = f" ({finding.hint})" if finding.hint else ""
    cells = [finding.severity.word, rule, str(finding.place), finding.message + hint]
    return "| " + " | ".join(_escape(cell) for cell in cells) + " |"


def _escape(text: str) -> str:
    return " ".join(printable(line) for line in text.splitlines()).translate(_SPECIAL)
