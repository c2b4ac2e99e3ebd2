# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""JUnit XML: a suite a source, a test case a rule that ran."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from tumtools import __version__
from tumtools.printable import printable
from tumtools.validate.rules import RULES

if TYPE_CHECKING:
    from tumtools.validate.engine import Report, Result
    from tumtools.validate.finding import Finding

_WHEN: Final = "1970-01-01T00:00:00"
"""The format wants a time and a host; the same input gives the same bytes."""
_HOST: Final = "localhost"
_NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def render(report: Report) -> str:
    """Render the suites; findings below the limit for failures are in `system-out`."""
    root = Element("testsuites")
    for number, result in enumerate(report.results):
        _suite(root, number, result, report)
    indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, encoding="unicode") + "\n"


def _suite(root: Element, number: int, result: Result, report: Report) -> None:
    failing = [f for f in result.findings if report.fail_on is not None and f.severity >= report.fail_on]
    failed_codes = {finding.code for finding in failing}
    suite = SubElement(
        root,
        "testsuite",
        name=_clean(result.source),
        package=_clean(result.name),
        id=str(number),
        timestamp=_WHEN,
        hostname=_HOST,
        tests=str(len(result.rules)),
        failures=str(len(failed_codes)),
        errors="0",
        time="0",
    )
    # The schemas disagree on whether there may be none.
    properties = SubElement(suite, "properties")
    for name, value in (("tumtools", __version__), ("format", result.format), ("level", result.level)):
        SubElement(properties, "property", name=name, value=value)
    for code in result.rules:
        case = SubElement(
            suite, "testcase", classname=_clean(result.source), name=f"{code} {RULES[code].slug}", time="0"
        )
        found = [finding for finding in failing if finding.code == code]
        if found:
            failure = SubElement(case, "failure", type=code, message=_clean(found[0].message))
            failure.text = "\n".join(_line(finding) for finding in found)
    rest = [finding for finding in result.findings if finding.code not in failed_codes]
    SubElement(suite, "system-out").text = "\n".join(_line(finding) for finding in rest)
    SubElement(suite, "system-err")


def _line(finding: Finding) -> str:
    where = f"{finding.place}: " if str(finding.place) else ""
    return _clean(f"{where}{finding.severity.word} {finding.code} {finding.message}")


def _clean(text: str) -> str:
    """Replace what XML cannot hold, and what a terminal would obey."""
    return _NOT_XML.sub("?", "\n".join(map(printable, text.split("\n"))))
