# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What `tumtools batch` says: of plans, of runs, and of where tasks stand."""

from __future__ import annotations

import json
import shutil
from typing import TYPE_CHECKING

import pytest
from click.testing import CliRunner

from tests.batch.batches import FIXTURES
from tumtools.batch.ledger import FAILED, Entry
from tumtools.batch.task import WORKED, Job, Outcome, execute
from tumtools.cli import batch_progress, main
from tumtools.cli.main import cli
from tumtools.errors import UsageError

if TYPE_CHECKING:
    from pathlib import Path


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for name in ("full", "early"):
        shutil.copytree(FIXTURES / name, tmp_path / "data" / name)
    (tmp_path / "data/full/notes.txt").write_text("of the day\n")
    (tmp_path / "m.toml").write_text(
        'destination = "out"\n[[source]]\npath = "data/*"\n'
        '[[target]]\nto = "mcap"\n[[target]]\nto = "rawlog"\n'
    )
    monkeypatch.chdir(tmp_path)
    return tmp_path


def call(*words: str, code: int = 0) -> str:
    result = CliRunner().invoke(cli, ["batch", *words], standalone_mode=False)
    assert (result.return_value or 0) == code, result.output
    if result.exception is not None:
        raise result.exception
    return result.output


def run(*words: str, code: int = 0) -> str:
    return call("run", "p.json", "--engine", "inline", *words, code=code)


def test_a_batch_from_plan_to_status(folder: Path) -> None:
    assert "4 tasks: 2 sources, 2 targets" in call("plan", "m.toml", "-o", "p.json")
    printed = run()
    assert "notes.txt" in printed
    row = next(line for line in printed.splitlines() if line.startswith("mcap") and "notes.txt" in line)
    assert row.endswith("full/full.mcap")
    lost = json.loads(run("--json"))["losses"]
    assert [(one["target"], one["outputs"]) for one in lost] == [
        ("mcap", ["full/full.mcap"]),
        ("rawlog", ["full/full.rawlog"]),
    ]
    assert "notes.txt" in call("status", "p.json")


def test_a_single_task_is_not_called_tasks(folder: Path) -> None:
    (folder / "m.toml").write_text(
        'destination = "out"\nestimate = "off"\n[[source]]\npath = "data/full"\n[[target]]\nto = "mcap"\n'
    )
    printed = call("plan", "m.toml", "-o", "p.json")
    assert "1 task: 1 source, 1 target, of unknown size" in printed
    assert "0 of 1 sources were opened" in printed


def test_status_names_what_has_changed_and_why(folder: Path) -> None:
    call("plan", "m.toml", "-o", "p.json")
    call("status", "p.json", "--check", code=1)
    run()
    call("status", "p.json", "--check", "--full")
    (folder / "out/full/full.mcap").unlink()
    assert "changed: full/full.mcap: the output is gone" in call("status", "p.json")
    call("status", "p.json", "--check", code=1)
    call("status", "p.json", "--full", code=1)
    run()
    call("status", "p.json", "--check", "--full")


def test_failures_are_one_line_each_while_it_runs(folder: Path) -> None:
    image = next((folder / "data/full/rgb").glob("*.png"))
    image.write_bytes(image.read_bytes()[:-20])
    call("plan", "m.toml", "-o", "p.json")
    printed = run(code=1)
    lines = [line for line in printed.splitlines() if image.name in line]
    assert [line.partition(": ")[0] for line in lines] == ["failed", "failed"]


def test_a_log_is_told_now_and_then_where_the_batch_stands(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    clock = iter([0.0, 10.0, 70.0, 80.0])
    monkeypatch.setattr(batch_progress.time, "monotonic", lambda: next(clock))
    say = batch_progress._Lines(100)
    bad = Entry("t", FAILED, "s", "o.mcap", 1, 0.0, 1.0, "h", reason="no\n  hint: none")
    for _ in range(3):
        say(Outcome("t", WORKED, bad))
    told = capsys.readouterr().err.splitlines()
    assert told.count("failed: o.mcap: no; hint: none") == 3
    assert told.count("2 of 100 tasks, 2 failed, about 0:57:10 left") == 1


def test_what_is_skipped_is_told_with_its_reason_and_what_is_left_of_it(folder: Path) -> None:
    text = (folder / "m.toml").read_text()
    (folder / "m.toml").write_text(f'on_findings = "skip"\n{text}')
    call("plan", "m.toml", "-o", "p.json")
    run()
    (folder / "data/full/rgb.txt").write_text("# nothing\n0.5 rgb/nowhere.png\n")
    for printed in (run(), run()):
        assert "skipped: full/full.mcap: validation: " in printed
    line = next(line for line in call("status", "p.json").splitlines() if "full.mcap" in line)
    assert line.startswith("skipped: full/full.mcap: validation: ")
    assert line.endswith("; an older output is there")


def test_names_with_control_characters_stay_on_their_line(folder: Path) -> None:
    (folder / "data" / "a\nb\x1b[1m").mkdir()
    assert "a\\nb\\x1b[1m" in call("plan", "m.toml", "-o", "p.json")
    for printed in (run(code=1), call("status", "p.json", code=1)):
        assert "failed: a\\nb\\x1b[1m/a\\nb\\x1b[1m.mcap: " in printed


def test_a_plan_is_not_written_to_a_file_called_minus(folder: Path) -> None:
    with pytest.raises(UsageError, match="written to a file"):
        call("plan", "m.toml", "-o", "-")
    assert not (folder / "-").exists()


@pytest.mark.parametrize("as_json", [False, True])
def test_a_run_that_is_interrupted_tells_what_was_done(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], as_json: bool
) -> None:
    def interrupt(job: Job) -> Outcome:
        if begun:
            raise KeyboardInterrupt
        begun.append(job)
        return execute(job)

    begun: list[Job] = []
    monkeypatch.setattr("tumtools.batch.engines.inline.execute", interrupt)
    call("plan", "m.toml", "-o", "p.json")
    capsys.readouterr()
    words = ["batch", "run", "p.json", "--engine", "inline", *(["--json"] if as_json else [])]
    assert main.run(words) == 130
    printed = capsys.readouterr()
    if as_json:
        document = json.loads(printed.out)
        assert (document["interrupted"], document["counts"]["done"]) == (True, 1)
    else:
        assert "cut short after 1 of 4 tasks; `tumtools batch run PLAN` goes on" in printed.err
        assert printed.out.splitlines()[-1].split()[:2] == ["all", "1"]
