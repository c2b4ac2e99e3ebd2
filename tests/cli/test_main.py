# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The program: exit codes, what goes to stdout and what to stderr, and what becomes of errors."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import pytest

from tumtools import __version__
from tumtools.cli import main as program
from tumtools.cli import output
from tumtools.cli.main import COMMANDS, run

if TYPE_CHECKING:
    from collections.abc import Callable

ROOT = Path(__file__).parents[2]
FULL = ROOT / "fixtures" / "full"


@pytest.fixture(autouse=True)
def _normal_verbosity(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(output, "verbosity", 0)


def _raise(monkeypatch: pytest.MonkeyPatch, error: BaseException) -> None:
    def fail(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(program.cli, "main", fail)


def test_the_version_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["--version"]) == 0
    assert capsys.readouterr().out == f"tumtools {__version__}\n"


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run([command, "-h"]) == 0
    assert capsys.readouterr().out.startswith(f"Usage: tumtools {command}")


def test_help_lists_all_commands_without_importing_numpy() -> None:
    code = "import sys; from tumtools.cli.main import run; run(['--help']); print(sorted(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    for command in COMMANDS:
        assert f"\n  {command} " in done.stdout
    modules = done.stdout.splitlines()[-1]
    for heavy in ("'numpy'", "'PIL'", "'requests'", "'yaml'", "'tqdm'", "'tumtools.formats.registry'"):
        assert heavy not in modules


@pytest.mark.parametrize("arguments", [["nonsense"], ["info"], ["info", "--nonsense", "x"], ["convert", "x"]])
def test_wrong_usage_is_exit_2(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert run(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "Error" in captured.err


def test_a_bug_shows_a_traceback_and_asks_for_a_report(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    _raise(monkeypatch, ZeroDivisionError("x"))
    assert run([]) == 70
    err = capsys.readouterr().err
    assert "Traceback" in err
    assert f"this is a bug of tumtools {__version__}: ZeroDivisionError: x" in err


def _interrupt(*_: object) -> NoReturn:
    raise KeyboardInterrupt


def _interrupt_the_making_of_a_class(*_: object) -> None:
    """Python 3.11 makes a RuntimeError of it."""
    type("Made", (), {"field": type("Field", (), {"__set_name__": _interrupt})()})


def _interrupt_and_stumble(*_: object) -> None:
    try:
        _interrupt()
    finally:
        [].pop()


@pytest.mark.parametrize("interrupt", [_interrupt, _interrupt_the_making_of_a_class, _interrupt_and_stumble])
def test_an_interrupt_is_exit_130(
    interrupt: Callable[..., None], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("tumtools.sources.open_source", interrupt)
    assert run(["digest", str(FULL)]) == 130
    assert capsys.readouterr().err.strip() == "interrupted; nothing half-written was left behind"


def test_what_the_system_refuses_is_no_bug(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    _raise(monkeypatch, PermissionError(13, "Permission denied", "/x"))
    assert run([]) == 4
    assert capsys.readouterr().err == "error: /x: Permission denied\n"


def test_an_error_of_the_input_is_exit_4_without_a_traceback(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["info", "/nowhere/at/all"]) == 4
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "/nowhere/at/all" in captured.err
    assert "Traceback" not in captured.err


def test_vv_shows_where_an_error_arose(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["-vv", "info", "/nowhere/at/all"]) == 4
    assert "Traceback" in capsys.readouterr().err


@pytest.mark.parametrize(
    "arguments",
    [
        ["info", "/nowhere/at/all", "-vv"],
        ["info", "-v", "/nowhere/at/all", "--verbose"],
        ["-v", "info", "-v", "/nowhere/at/all"],
        ["evaluate", "ate", "/nowhere/at/all", "/nowhere/at/all", "-vv"],
        ["cache", "-vv", "prune", "--nonsense"],
    ],
)
def test_verbosity_may_stand_behind_the_command(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(arguments) in {2, 4}
    assert ("Traceback" in capsys.readouterr().err) == ("--nonsense" not in arguments)
    assert run(["info", "/nowhere/at/all"]) == 4
    assert "Traceback" not in capsys.readouterr().err  # it holds for one run


@pytest.mark.parametrize("place", [0, 1, 4])
def test_quiet_leaves_results_and_losses(
    place: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["convert", str(FULL), str(tmp_path / "x.mcap"), "--to=mcap"]
    assert run([*arguments[:place], "-q", *arguments[place:]]) == 0
    captured = capsys.readouterr()
    assert (captured.out, captured.err) == ("", "")
    assert run([*arguments, "--depth-encoding=16UC1", "--force", "-q"]) == 0
    assert capsys.readouterr().out.startswith("lost:")
    assert run([*arguments, "--force", "-v"]) == 0
    assert "took" in capsys.readouterr().err


def test_a_reader_of_the_pipe_that_goes_away_is_no_error() -> None:
    pipe = f"set -o pipefail; {sys.executable} -m tumtools digest --deep {FULL} | head -1"
    done = subprocess.run(["bash", "-c", pipe], capture_output=True, text=True, check=True)
    assert done.stderr == ""
    assert json.loads(done.stdout)["stream"] == "rgb"


def test_a_pipe_without_a_reader_is_no_finding(tmp_path: Path) -> None:
    with subprocess.Popen(["true"], stdin=subprocess.PIPE) as gone:
        gone.wait()
        assert gone.stdin is not None
        done = subprocess.run(
            [sys.executable, "-m", "tumtools", "digest", str(FULL)],
            stdout=gone.stdin,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert (done.returncode, done.stderr) == (0, "")


def test_no_color_is_honoured(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NO_COLOR", raising=False)
    assert "\x1b[" in output.style("x", bold=True)
    monkeypatch.setenv("NO_COLOR", "1")
    assert output.style("x", bold=True, color="red") == "x"


def test_file_names_in_no_known_coding_can_be_printed(tmp_path: Path) -> None:
    folder = shutil.copytree(FULL, tmp_path / "full")
    (folder / os.fsdecode(b"\xff.md")).touch()
    for arguments in (["info"], ["info", "--json"]):
        done = subprocess.run(
            [sys.executable, "-m", "tumtools", *arguments, str(folder)],
            capture_output=True,
            check=True,
            env=os.environ | {"LC_ALL": "C.UTF-8"},
        )
        assert b"\\udcff.md" in done.stdout
        if "--json" in arguments:
            assert json.loads(done.stdout)["not_carried"][0]["stream"] == "\udcff.md"


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_is_printed_for_each_shell(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["completion", shell]) == 0
    assert "_TUMTOOLS_COMPLETE" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        ("tumtools co", {"plain,convert", "plain,completion"}),
        ("tumtools evaluate r", {"plain,rpe"}),
        ("tumtools info fr1/des", {"plain,fr1/desk", "plain,fr1/desk2"}),
        ("tumtools info ful", {"file,ful"}),
        ("tumtools validate --config x", {"file,x"}),
        ("tumtools fetch --dest x", {"dir,x"}),
        ("tumtools rules quaternion-o", {"plain,quaternion-order"}),
    ],
)
def test_completion_offers_commands_names_and_files(typed: str, offered: set[str]) -> None:
    asked = {"COMP_WORDS": typed, "COMP_CWORD": str(typed.count(" "))}
    done = subprocess.run(
        [sys.executable, "-m", "tumtools"],
        env=os.environ | asked | {"_TUMTOOLS_COMPLETE": "bash_complete", "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
        cwd=FULL.parent,
    )
    assert offered <= set(done.stdout.split())


@pytest.fixture
def installed(tmp_path: Path) -> dict[str, str]:
    """Return an environment with `tumtools` on the PATH."""
    program = tmp_path / "bin" / "tumtools"
    program.parent.mkdir()
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -m tumtools "$@"\n')
    program.chmod(0o755)
    return os.environ | {"PATH": f"{program.parent}:{os.environ['PATH']}", "PYTHONPATH": str(ROOT)}


def test_bash_completes_with_the_script(installed: dict[str, str]) -> None:
    if shutil.which("bash") is None:
        pytest.skip("bash is not installed")
    script = """
        eval "$(tumtools completion bash)"
        COMP_WORDS=(tumtools validate --form) COMP_CWORD=2
        _tumtools_completion tumtools --form validate
        echo "${COMPREPLY[@]}"
    """
    done = subprocess.run(["bash", "-c", script], env=installed, capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["--format"]


def test_fish_completes_with_the_script(installed: dict[str, str]) -> None:
    if shutil.which("fish") is None:
        pytest.skip("fish is not installed")
    script = 'tumtools completion fish | source; complete -C "tumtools info fr1/des"'
    done = subprocess.run(
        ["fish", "--no-config", "-c", script], env=installed, capture_output=True, text=True, check=True
    )
    assert {"fr1/desk", "fr1/desk2"} <= set(done.stdout.split())


def test_formats_are_listed_for_people_and_programs(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["formats"]) == 0
    assert "--depth-encoding 32FC1|png|16UC1  (default 32FC1)" in capsys.readouterr().out
    assert run(["formats", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["schema_version"] == 1
    assert {"tum", "mcap"} <= {entry["name"] for entry in document["formats"]}


def test_a_digest_is_printed_with_its_streams(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["digest", "--json", str(FULL)]) == 0
    document = json.loads(capsys.readouterr().out)
    assert run(["digest", "--deep", str(FULL)]) == 0
    *frames, whole = map(json.loads, capsys.readouterr().out.splitlines())
    assert whole["sha256"] == document["sha256"]
    assert len(frames) == 8
    assert all(isinstance(frame["stamp"], str) for frame in frames)
    assert document["streams"]["rgb"]["count"] == 4
    assert run(["digest", str(FULL)]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == f"{document['sha256']}  {FULL}"


@pytest.mark.parametrize("closed", ["<&-", ">&-", "2>&-", "<&- >&- 2>&-"])
def test_streams_that_are_closed_are_no_matter(tmp_path: Path, closed: str) -> None:
    command = f"{sys.executable} -m tumtools convert {FULL.resolve()} x --to rawlog {closed}"
    done = subprocess.run(
        ["/bin/sh", "-c", command],
        capture_output=True,
        cwd=tmp_path,
        check=False,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "x" / "x.rawlog").exists()
    assert b"Traceback" not in done.stderr


def test_a_disk_that_is_full_is_said_to_be_that() -> None:
    command = f"{sys.executable} -m tumtools formats > /dev/full"
    done = subprocess.run(["/bin/sh", "-c", command], capture_output=True, text=True, check=False, cwd=ROOT)
    assert (done.returncode, done.stderr) == (4, "error: No space left on device\n")
