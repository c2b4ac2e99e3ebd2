# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The table of rules is complete, and the rules that no single fault shows do what they say."""

from __future__ import annotations

import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tumtools.model.sequence import SequenceInfo
from tumtools.model.signals import Trajectory
from tumtools.validate.document import describe
from tumtools.validate.engine import check, validate
from tumtools.validate.finding import Finding, Place, Severity
from tumtools.validate.frames import FrameFacts
from tumtools.validate.rules import RULES
from tumtools.validate.settings import Settings
from tumtools.validate.subject import Subject

FIXTURES = Path(__file__).parents[2] / "fixtures"
SPECIFIED = (
    *(f"TUM00{n}" for n in range(1, 7)),
    *(f"TUM10{n}" for n in range(1, 10)),
    *(f"TUM20{n}" for n in range(1, 6)),
    *(f"TUM30{n}" for n in range(1, 7)),
    *(f"TUM40{n}" for n in range(1, 8)),
    "TUM501",
    "TUM502",
    "TUM503",
    "TUM601",
    *(f"TUM70{n}" for n in range(1, 8)),
)


def test_all_rules_are_there_in_the_order_of_their_codes() -> None:
    assert tuple(RULES) == SPECIFIED


@pytest.mark.parametrize("code", RULES)
def test_each_rule_documents_itself(code: str) -> None:
    rule = RULES[code]
    assert re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", rule.slug)
    for text in (rule.title, rule.why, rule.how, rule.mend):
        assert text.endswith((".", ")."))
        assert len(text) > 10
    page = describe(rule)
    assert page.startswith(f"# {code} {rule.slug}\n")
    assert all(f"| {name} |" in page for name in rule.limits)


def test_names_are_unique() -> None:
    assert len({rule.slug for rule in RULES.values()}) == len(RULES)


@pytest.mark.parametrize(
    "fixture", ["full", "validation", "ir_calibration", "no_depth", "no_accelerometer", "fr3", "trajectory"]
)
def test_good_fixtures_have_nothing_but_their_size(fixture: str) -> None:
    findings = validate(FIXTURES / fixture).findings
    assert {finding.code for finding in findings if finding.severity > Severity.INFO} <= {"TUM202"}


def test_a_stamp_before_the_range_of_years_is_told_as_such(tmp_path: Path) -> None:
    folder = shutil.copytree(FIXTURES / "full", tmp_path / "full")
    rows = (folder / "rgb.txt").read_text().splitlines(keepends=True)
    (folder / "rgb.txt").write_text("".join([*rows[:-1], f"-9999999999.0 {rows[-1].split()[1]}\n"]))
    assert "-9999999999.0 is no number of seconds since 1970: it is before the year 1678" in [
        finding.message for finding in validate(folder).findings if finding.code == "TUM105"
    ]


def _colour(red: float, blue: float) -> Subject:
    subject = Subject("x", "x", stamps={"rgb": np.array([1305031102175304000])})
    subject.frames["rgb"] = [FrameFacts("rgb", 0, 1305031102175304000, 640, 480, "rgb8", red=red, blue=blue)]
    return subject


@pytest.mark.parametrize(("red", "blue", "found"), [(120, 90, False), (90, 120, True), (100, 105, False)])
def test_swapped_channels_are_guessed_only_when_asked_for(red: float, blue: float, found: bool) -> None:
    settings = Settings(extend_select=("TUM205",))
    assert ("TUM205" in [f.code for f in check(_colour(red, blue), settings).findings]) == found
    assert "TUM205" not in [f.code for f in check(_colour(red, blue), Settings()).findings]


def _published(stamps: list[str], name: str) -> Subject:
    nanoseconds = np.array([int(stamp.replace(".", "")) * 100_000 for stamp in stamps])
    n = len(stamps)
    poses = Trajectory(nanoseconds, np.zeros((n, 3)), np.tile([0.0, 0, 0, 1], (n, 1)))
    return Subject("x", "x", format="tum", info=SequenceInfo(name, "tum"), groundtruth=poses)


def _stamps_around(repeated: str) -> list[str]:
    first = int(repeated.replace(".", ""))
    texts = [first + 33 * n for n in range(-20, 0)] + [first, first] + [first + 33 * n for n in range(1, 20)]
    return [f"{value // 10**4}.{value % 10**4:04d}" for value in texts]


def test_a_repeated_stamp_that_is_published_is_an_erratum() -> None:
    findings = check(
        _published(_stamps_around("1311868229.5760"), "rgbd_dataset_freiburg2_desk"), Settings()
    ).findings
    assert [(f.code, f.severity) for f in findings] == [("TUM601", Severity.INFO)]


@pytest.mark.parametrize(
    ("repeated", "name"),
    [("1311868229.5770", "rgbd_dataset_freiburg2_desk"), ("1311868229.5760", "my_own_sequence")],
)
def test_other_repeated_stamps_are_warned_of(repeated: str, name: str) -> None:
    codes = {
        finding.code for finding in check(_published(_stamps_around(repeated), name), Settings()).findings
    }
    assert codes == {"TUM102"}


def test_stamps_that_lie_centuries_apart_are_compared_all_the_same() -> None:
    """Their differences do not fit into 64 bits."""
    first, step = -(2**63) + 1, 33_333_333
    early = first + step * np.arange(40)
    late = 2**63 - 1 - step * np.arange(40)[::-1]
    for stamps, back in ((np.concatenate([early, late]), 0), (np.concatenate([late, early]), 1)):
        subject = Subject("x", "x", True, "tum", SequenceInfo("x", "tum"), stamps={"rgb": stamps})
        subject.names = {"rgb": tuple(map(str, range(len(stamps))))}
        found = check(subject, Settings(select=("TUM101", "TUM107")), full=False).findings
        assert sum("before that of the row before" in finding.message for finding in found) == back


def test_many_findings_of_a_kind_are_cut_short_and_counted(tmp_path: Path) -> None:
    lines = [f"1305031000.{n:06d} rgb/1305031000.{n:06d}.png\n" for n in range(50)]
    (tmp_path / "rgb.txt").write_text("".join(lines))
    missing = [finding for finding in validate(tmp_path).findings if finding.code == "TUM001"]
    assert len(missing) == 10
    assert missing[-1].message.endswith("and 40 more like this")


def test_a_fingerprint_does_not_change_when_lines_are_inserted() -> None:
    finding = Finding("TUM101", Severity.ERROR, "m", Place("rgb.txt", 7, "rgb", 3, 1305031102175304000))
    moved = replace(finding, place=replace(finding.place, line=9, row=5))
    other = replace(finding, place=replace(finding.place, stamp=1305031102175304001))
    assert finding.fingerprint == moved.fingerprint != other.fingerprint
