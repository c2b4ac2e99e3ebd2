# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools validate` and `tumtools rules`: exit codes, outputs, options."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from tumtools.cli.main import run

FIXTURES = Path(__file__).parents[2] / "fixtures"
FULL = str(FIXTURES / "full")


@pytest.fixture
def broken(tmp_path: Path) -> Path:
    folder = Path(shutil.copytree(FIXTURES / "full", tmp_path / "broken"))
    next((folder / "rgb").iterdir()).unlink()
    return folder


def test_exit_codes(broken: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["validate", FULL]) == 0
    assert run(["validate", FULL, "--fail-on", "warning"]) == 1
    assert run(["validate", FULL, "--fail-on", "warning", "--ignore", "TUM202"]) == 0
    assert run(["validate", FULL, str(broken)]) == 1
    assert run(["validate", str(broken), "--fail-on", "never"]) == 0
    assert run(["validate", "/nowhere/at/all"]) == 1
    assert run(["validate", FULL, "--select", "TUM9"]) == 2
    assert run(["validate"]) == 2
    assert "TUM001" in capsys.readouterr().out


def test_the_report_is_written_even_when_it_fails(broken: Path, tmp_path: Path) -> None:
    target = tmp_path / "report.json"
    assert run(["validate", str(broken), "--format", "json", "--output", str(target)]) == 1
    assert json.loads(target.read_text())["failed"] is True
    assert run(["validate", FULL, "--format", "json", "--output", str(target)]) == 0
    assert json.loads(target.read_text())["failed"] is False


def test_there_is_no_colour_in_a_pipe(broken: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run(["validate", str(broken)])
    assert "\x1b[" not in capsys.readouterr().out


def test_quick_does_not_decode(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = Path(shutil.copytree(FIXTURES / "full", tmp_path / "bad"))
    path = next((folder / "rgb").iterdir())
    path.write_bytes(path.read_bytes()[:2000])
    assert run(["validate", "--quick", str(folder)]) == 0
    assert run(["validate", "--full", str(folder)]) == 1
    assert "TUM201" in capsys.readouterr().out


def test_a_configuration_is_found_in_the_current_folder(
    broken: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (broken.parent / "tumtools.toml").write_text('[validate]\nignore = ["TUM0"]\n')
    monkeypatch.chdir(broken.parent)
    assert run(["validate", "broken"]) == 0
    (broken.parent / "other.toml").write_text("[validate]\n")
    assert run(["validate", "broken", "--config", "other.toml"]) == 1


def test_a_baseline_makes_known_findings_pass(broken: Path, tmp_path: Path) -> None:
    known = str(tmp_path / "known.json")
    assert run(["validate", str(broken), "--write-baseline", known]) == 1
    assert run(["validate", str(broken), "--baseline", known]) == 0
    assert run(["validate", str(broken), "--baseline", str(tmp_path / "none.json")]) == 4


def test_fix_writes_a_mended_copy_and_says_what_it_did(
    broken: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["validate", str(broken), "--fix", str(tmp_path / "mended")]) == 1
    assert "fixed rgb.txt: left out 1 rows without a file" in capsys.readouterr().err
    assert run(["validate", str(tmp_path / "mended")]) == 0


def test_rules_are_listed_and_explained(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["rules"]) == 0
    assert "TUM301  depth-scale" in capsys.readouterr().out
    assert run(["rules", "tum301"]) == 0
    by_code = capsys.readouterr().out
    assert run(["rules", "depth-scale"]) == 0
    assert capsys.readouterr().out == by_code
    assert run(["rules", "TUM301", "--json"]) == 0
    (rule,) = json.loads(capsys.readouterr().out)["rules"]
    assert rule["limits"]["deviation"]["default"] == 0.15
    assert run(["rules", "TUM999"]) == 2
