# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The report for people: grouped by source and file, a line a finding, counts, verdict."""

from __future__ import annotations

from itertools import groupby
from typing import TYPE_CHECKING, Final

from tumtools.printable import printable
from tumtools.validate.finding import Severity

if TYPE_CHECKING:
    from collections.abc import Callable

    from tumtools.validate.engine import Report, Result
    from tumtools.validate.finding import Finding

    Style = Callable[[str, str], str]

COLOURS: Final = {Severity.ERROR: "red", Severity.WARNING: "yellow", Severity.INFO: "blue"}


def plain(text: str, colour: str) -> str:
    """Return the text as it is."""
    del colour
    return text


def render(report: Report) -> str:
    """Render the report without colours."""
    return render_styled(report, plain)


def render_styled(report: Report, style: Style) -> str:
    """Render the report.

    Args:
        report: What was found.
        style: Puts a text into a colour (`red`, `yellow`, `blue`, `green`, `bold`).

    """
    lines: list[str] = []
    results, fail_on = report.results, report.fail_on
    for result in results:
        lines.append(style(printable(result.source), "bold") + f"  ({_about(result)})")
        for file, findings in groupby(result.findings, key=lambda finding: finding.place.file):
            if file:
                lines.append(f"  {printable(file)}")
            lines.extend(_line(finding, style) for finding in findings)
        lines.append(f"  {verdict(result, fail_on, style)}")
        lines.append("")
    if len(results) > 1:
        failed = sum(result.fails(fail_on) for result in results)
        lines.append(f"{len(results)} sources, {failed} failed")
    return "\n".join(lines).rstrip("\n") + "\n"


def _about(result: Result) -> str:
    parts = [result.format or "not readable"]
    if result.images:
        parts.append(f"{result.images} images {'decoded' if result.level == 'full' else 'listed'}")
    return ", ".join(parts)


def _line(finding: Finding, style: Style) -> str:
    place = finding.place
    where = f"{place.line}: " if place.line is not None else ""
    if not place.file and place.line is None and place.stream:
        where = f"{place}: "
    word = style(finding.severity.word, COLOURS[finding.severity])
    hint = f" [{finding.hint}]" if finding.hint else ""
    return f"    {printable(where)}{word} {finding.code} {printable(finding.message + hint)}"


def verdict(result: Result, fail_on: Severity | None, style: Style = plain) -> str:
    """Return whether a source passed, and how many findings it has."""
    counts = [
        f"{(count := result.count(severity))} {severity.word}"
        f"{'' if count == 1 or severity is Severity.INFO else 's'}"
        for severity in (Severity.ERROR, Severity.WARNING, Severity.INFO)
    ]
    accepted = f", {result.accepted} accepted by the baseline" if result.accepted else ""
    word = style("failed", "red") if result.fails(fail_on) else style("passed", "green")
    return f"{word}: {', '.join(counts)}{accepted}"
