# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""SARIF 2.1.0, the format that code scanning of GitHub and others read."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final
from urllib.parse import quote

from tumtools import __version__
from tumtools.printable import json_text
from tumtools.validate.document import describe
from tumtools.validate.finding import Severity
from tumtools.validate.rules import RULES

if TYPE_CHECKING:
    from tumtools.validate.engine import Report, Result
    from tumtools.validate.finding import Finding
    from tumtools.validate.rule import Rule

SCHEMA: Final = "https://json.schemastore.org/sarif-2.1.0.json"
_LEVELS: Final = {Severity.ERROR: "error", Severity.WARNING: "warning", Severity.INFO: "note"}
_INDEX: Final = {code: number for number, code in enumerate(RULES)}


def render(report: Report) -> str:
    """Render one run with all rules and results."""
    document = {
        "$schema": SCHEMA,
        "version": "2.1.0",
        "runs": [
            {
                "tool": {
                    "driver": {
                        "name": "tumtools",
                        "semanticVersion": __version__,
                        "rules": [_rule(rule) for rule in RULES.values()],
                    }
                },
                "columnKind": "utf16CodeUnits",
                "results": [
                    _result(result, finding) for result in report.results for finding in result.findings
                ],
            }
        ],
    }
    return json_text(document) + "\n"


def _rule(rule: Rule) -> dict[str, object]:
    return {
        "id": rule.code,
        "name": rule.slug,
        "shortDescription": {"text": rule.title},
        "fullDescription": {"text": rule.why},
        "help": {"text": f"{rule.how}\n\n{rule.mend}", "markdown": describe(rule)},
        "defaultConfiguration": {"level": _LEVELS[rule.severity], "enabled": rule.enabled},
    }


def _result(result: Result, finding: Finding) -> dict[str, object]:
    physical: dict[str, object] = {"artifactLocation": _artifact(result.file_of(finding))}
    if finding.place.line is not None:
        physical["region"] = {"startLine": finding.place.line}
    location: dict[str, object] = {"physicalLocation": physical}
    place = finding.place
    if place.stream is not None:
        name = place.stream if place.row is None else f"{place.stream}[{place.row}]"
        location["logicalLocations"] = [{"fullyQualifiedName": name}]
    text = f"{finding.message}. {finding.hint}" if finding.hint else finding.message
    values = {"measured": finding.measured, "expected": finding.expected}
    document: dict[str, object] = {
        "ruleId": finding.code,
        "ruleIndex": _INDEX[finding.code],
        "level": _LEVELS[finding.severity],
        "message": {"text": text},
        "locations": [location],
        "partialFingerprints": {"tumtools/v1": finding.fingerprint},
    }
    properties = {key: value for key, value in values.items() if value}
    return document | ({"properties": properties} if properties else {})


def _artifact(path: str) -> dict[str, str]:
    """Return a file as a URI relative to the current folder; absolute where it lies elsewhere."""
    absolute = Path(path).absolute()
    try:
        relative = absolute.relative_to(Path.cwd())
    except ValueError:
        return {"uri": absolute.as_uri()}
    return {"uri": quote(relative.as_posix()), "uriBaseId": "%SRCROOT%"}
