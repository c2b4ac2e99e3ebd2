# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools validate` and `tumtools rules`: exit codes, outputs, options."""

from __future__ import annotations

import json
import os
import shutil
import stat
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from tumtools.cli.main import run
from tumtools.cli.validate import FORMATS

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


def test_a_new_baseline_keeps_what_the_old_one_accepts(broken: Path, tmp_path: Path) -> None:
    known = str(tmp_path / "known.json")
    run(["validate", str(broken), "--write-baseline", known])
    assert run(["validate", str(broken), "--baseline", known, "--write-baseline", known]) == 0
    assert run(["validate", str(broken), "--baseline", known]) == 0


@pytest.mark.parametrize("option", ["--output", "--write-baseline"])
def test_a_folder_is_never_replaced_by_a_report(
    option: str, broken: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    precious = Path(shutil.copytree(FULL, tmp_path / "precious"))
    before = sorted(precious.rglob("*"))
    assert run(["validate", str(broken), option, str(precious)]) == 2
    assert sorted(precious.rglob("*")) == before
    captured = capsys.readouterr()
    assert "this is a folder" in captured.err
    assert not captured.out  # known before the work begins


def test_a_report_goes_to_a_pipe_as_it_is(
    broken: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with ThreadPoolExecutor() as pool:
        text = pool.submit(pipe.read_text)
        assert run(["validate", str(broken), "--json", "--output", str(pipe)]) == 1
    assert json.loads(text.result())["failed"] is True
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    assert run(["validate", str(broken), "--json", "--output", "-"]) == 1
    assert json.loads(capsys.readouterr().out)["failed"] is True


def test_a_file_name_that_is_no_utf8_does_not_stop_a_report(broken: Path, tmp_path: Path) -> None:
    try:
        (broken / "rgb" / os.fsdecode(b"\xff.png")).write_bytes(b"")
    except OSError:
        pytest.skip("the file system takes UTF-8 names only")
    for name in FORMATS:
        target = tmp_path / "report"
        assert run(["validate", str(broken), "--format", name, "--output", str(target)]) == 1
        assert "TUM002" in target.read_text(encoding="utf-8")


def test_json_is_a_short_way_to_say_format_json(broken: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run(["validate", str(broken), "--json"])
    short = capsys.readouterr().out
    run(["validate", str(broken), "--format", "json"])
    assert short == capsys.readouterr().out
    assert json.loads(short)["failed"] is True


def test_rules_are_chosen_by_code_or_name_and_choices_add_up(
    broken: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["validate", str(broken), "--select", "missing-file", "--select", "TUM2", "--json"]) == 1
    (source,) = json.loads(capsys.readouterr().out)["sources"]
    assert {finding["code"] for finding in source["findings"]} == {"TUM001", "TUM202"}
    assert run(["validate", str(broken), "--ignore", "TUM001", "--ignore", "image-format"]) == 0


def test_a_source_that_is_not_there_fails_whatever_rules_are_chosen(tmp_path: Path) -> None:
    assert run(["validate", str(tmp_path / "typo"), "--ignore", "TUM001,TUM701"]) == 1
    assert run(["validate", str(tmp_path), "--select", "TUM3"]) == 1


def test_an_empty_name_is_not_the_current_folder(
    broken: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(broken)
    assert run(["validate", ""]) == 1
    assert "the name of the source is empty" in capsys.readouterr().out
    assert run(["info", ""]) == 4


def test_a_recording_that_is_not_clear_does_not_stop_the_others(
    broken: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bag = tmp_path / "two.mcap"
    assert run(["convert", FULL, str(bag), "--to", "mcap"]) == 0
    capsys.readouterr()
    assert run(["validate", str(bag), str(broken), "--topic", "rgb=/nowhere"]) == 1
    out = capsys.readouterr().out
    assert "error TUM706 --topic rgb=/nowhere: no such topic [topics: " in out
    assert "2 sources, 2 failed" in out


def test_fix_refuses_before_the_work_begins(
    broken: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["validate", str(broken), FULL, "--fix", str(tmp_path / "mended")]) == 2
    assert run(["validate", str(broken), "--fix", FULL]) == 2
    captured = capsys.readouterr()
    assert not captured.out
    assert "--force" not in captured.err  # which this command does not have


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
