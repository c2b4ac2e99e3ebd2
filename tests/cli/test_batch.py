# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools batch`: what is printed, exit codes, and what it does not import."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from typing import TYPE_CHECKING

import pytest

from tests.batch.batches import FIXTURES
from tumtools.batch.engines.engine import EngineSettings
from tumtools.batch.engines.inline import InlineEngine
from tumtools.cli.main import run

if TYPE_CHECKING:
    from pathlib import Path


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    shutil.copytree(FIXTURES / "trajectory", tmp_path / "data/good")
    shutil.copytree(FIXTURES / "trajectory", tmp_path / "data/bad")
    (tmp_path / "data/bad/groundtruth.txt").write_text("1.0 nothing\n")
    (tmp_path / "m.toml").write_text(
        'destination = "out"\n[[source]]\npath = "data/*"\n[[target]]\nto = "mcap"\n'
    )
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_plan_run_status_retry(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    inline = ("--engine", "inline")
    assert run(["batch", "plan", "m.toml", "-o", "p.json"]) == 0
    assert "2 tasks: 2 sources, 1 target," in capsys.readouterr().err
    assert run(["batch", "run", "p.json", *inline]) == 1
    printed = capsys.readouterr()
    assert "failed: bad/bad.mcap: " in printed.err
    assert "batch retry" in printed.err
    assert run(["batch", "status", "p.json"]) == 1
    assert "groundtruth.txt" in capsys.readouterr().out
    shutil.copy(folder / "data/good/groundtruth.txt", folder / "data/bad/groundtruth.txt")
    assert run(["batch", "retry", "p.json", "--json", *inline]) == 0
    document = json.loads(capsys.readouterr().out)
    assert [task["entry"]["output"] for task in document["tasks"]] == ["bad/bad.mcap"]
    assert document["counts"]["done"] == 1
    assert run(["batch", "status", "p.json", "--full", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["counts"]["done"] == 2


@pytest.mark.parametrize(
    "words",
    [
        ["run", "p.json", "--shard", "0/2"],
        ["run", "p.json", "--shard", "3/2"],
        ["run", "p.json", "--memory-limit", "much"],
        ["run", "p.json", "--memory-limit", "1M"],
        ["run", "p.json", "--memory-limit", "99999999999999999999"],
        ["run", "p.json", "--memory-limit", "9999999999T"],
        ["run", "p.json", "--timeout", "nan"],
        ["run", "p.json", "--timeout", "inf"],
        ["run", "p.json", "--lease", "nan"],
        ["run", "p.json", "--address", "tcp://127.0.0.1:1"],
        ["run", "p.json", "--engine", "ray"],
        ["run", "p.json", "--engine", "inline", "--timeout", "3"],
    ],
)
def test_wrong_usage_is_refused(folder: Path, words: list[str]) -> None:
    run(["batch", "plan", "m.toml", "-o", "p.json"])
    assert run(["batch", *words]) == 2
    assert not (folder / "out").exists()


@pytest.mark.parametrize(
    ("text", "limit"),
    [
        ("300000000", 300_000_000),
        ("500M", 500_000_000),
        ("2g", 2 * 10**9),
        ("1.5G", 1_500_000_000),
        ("2T", 2 * 10**12),
        ("1 GB", 10**9),
        ("1GiB", 2**30),
    ],
)
def test_sizes_of_memory_are_written_as_people_write_them(
    folder: Path, monkeypatch: pytest.MonkeyPatch, text: str, limit: int
) -> None:
    found: list[int | None] = []

    def create(name: str, settings: EngineSettings) -> InlineEngine:
        assert name == "local"
        found.append(settings.memory_limit)
        return InlineEngine(EngineSettings())

    monkeypatch.setattr("tumtools.batch.engines.create_engine", create)
    run(["batch", "plan", "m.toml", "-o", "p.json"])
    run(["batch", "run", "p.json", "--memory-limit", text])
    assert found == [limit]


@pytest.mark.parametrize(
    ("missing", "words", "extra"),
    [("distributed", ["--engine", "dask"], "tumtools[dask]"), ("obstore", [], "tumtools[s3]")],
)
def test_a_missing_extra_is_named(folder: Path, missing: str, words: list[str], extra: str) -> None:
    run(["batch", "plan", "m.toml", "-o", "p.json"])
    if missing == "obstore":
        text = (folder / "m.toml").read_text().replace('"out"', '"s3://bucket/x"')
        (folder / "m.toml").write_text(text)
        run(["batch", "plan", "m.toml", "-o", "p.json"])
    code = (
        f"import sys; sys.modules[{missing!r}] = None; from tumtools.cli.main import main; "
        f"main(['batch', 'run', 'p.json', *{words!r}])"
    )
    path = os.pathsep.join(sys.path)
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"PYTHONPATH": path},
    )
    assert done.returncode == 2
    assert extra in done.stderr


def test_help_imports_nothing_heavy() -> None:
    heavy = "numpy", "obstore", "distributed", "multiprocessing", "tumtools.batch", "requests"
    code = (
        "import sys; from tumtools.cli.main import run; run(['batch', 'run', '--help']); "
        f"print([name for name in {heavy!r} if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"
