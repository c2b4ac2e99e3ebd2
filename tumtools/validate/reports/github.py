# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Workflow commands of GitHub Actions, which become annotations; the verdicts are for the log."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from tumtools.printable import printable
from tumtools.validate.finding import Severity
from tumtools.validate.reports.text import verdict
from tumtools.validate.rules import RULES

if TYPE_CHECKING:
    from tumtools.validate.engine import Report, Result
    from tumtools.validate.finding import Finding

_COMMANDS: Final = {Severity.ERROR: "error", Severity.WARNING: "warning", Severity.INFO: "notice"}


def render(report: Report) -> str:
    """Render a command a finding, and a verdict a source."""
    lines = [_command(result, finding) for result in report.results for finding in result.findings]
    lines += [
        f"source {printable(result.source)}: {verdict(result, report.fail_on)}" for result in report.results
    ]
    return "".join(f"{line}\n" for line in lines)


def _command(result: Result, finding: Finding) -> str:
    place = finding.place
    properties = {"file": result.file_of(finding)}
    if place.line is not None:
        properties["line"] = str(place.line)
    properties["title"] = f"{finding.code} {RULES[finding.code].slug}"
    where = f"{place}: " if not place.file and place.stream and place.line is None else ""
    hint = f"\n{finding.hint}" if finding.hint else ""
    listed = ",".join(f"{key}={_escape_property(value)}" for key, value in properties.items())
    return f"::{_COMMANDS[finding.severity]} {listed}::{_escape(_shown(where + finding.message + hint))}"


def _escape(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _shown(text: str) -> str:
    """Return lines of text that do nothing to the terminal of somebody who reads the log."""
    return "\n".join(map(printable, text.split("\n")))


def _escape_property(text: str) -> str:
    return _escape(printable(text)).replace(":", "%3A").replace(",", "%2C")
