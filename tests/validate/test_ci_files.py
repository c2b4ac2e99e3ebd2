# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The action and the hook for CI call the program as it is."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

from tumtools.cli.validate import FORMATS, command
from tumtools.validate.settings import FAIL_ON

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def action() -> dict[str, Any]:
    loaded: dict[str, Any] = yaml.safe_load((ROOT / "action.yml").read_text())
    return loaded


def test_the_inputs_name_what_the_program_offers(action: dict[str, Any]) -> None:
    inputs = action["inputs"]
    assert set(inputs) >= {"paths", "format", "fail-on", "version"}
    assert all(name in inputs["format"]["description"] for name in FORMATS)
    assert all(name in inputs["fail-on"]["description"] for name in FAIL_ON)
    assert inputs["format"]["default"] in FORMATS
    assert inputs["fail-on"]["default"] == ""  # the configuration decides


@pytest.mark.skipif(shutil.which("bash") is None, reason="bash is not installed")
@pytest.mark.parametrize(
    ("paths", "code"), [("fixtures/full\n  fixtures/fr3  \n", 0), ("fixtures/full\nno such folder\n", 1)]
)
def test_the_last_step_runs_as_it_stands(
    action: dict[str, Any], tmp_path: Path, paths: str, code: int
) -> None:
    report = tmp_path / "report.json"
    done = _last_step(
        action, tmp_path, TUMTOOLS_PATHS=paths, TUMTOOLS_FORMAT="json", TUMTOOLS_OUTPUT=str(report)
    )
    assert done == code
    assert '"sources"' in report.read_text()


@pytest.mark.skipif(shutil.which("bash") is None, reason="bash is not installed")
def test_the_last_step_takes_configuration_and_baseline(action: dict[str, Any], tmp_path: Path) -> None:
    config, known = tmp_path / "c.toml", tmp_path / "known.json"
    config.write_text('[validate]\nfail-on = "warning"\n')
    known.write_text('{"schema_version": 1, "accepted": []}')
    given = {"TUMTOOLS_PATHS": "fixtures/full", "TUMTOOLS_FAIL_ON": ""}
    assert _last_step(action, tmp_path, **given) == 0
    assert _last_step(action, tmp_path, **given, TUMTOOLS_CONFIG=str(config)) == 1
    assert _last_step(action, tmp_path, **given, TUMTOOLS_BASELINE=str(known)) == 0
    assert _last_step(action, tmp_path, **given, TUMTOOLS_BASELINE="nowhere.json") == 4
    assert _last_step(action, tmp_path, TUMTOOLS_PATHS="\n") == 2


def _last_step(action: dict[str, Any], tmp_path: Path, **inputs: str) -> int:
    """Run the last step as GitHub does, in the environment that the step before has made."""
    step = action["runs"]["steps"][-1]
    program = tmp_path / "tumtools-action" / "bin" / "python"
    if not program.exists():
        program.parent.mkdir(parents=True)
        program.symlink_to(sys.executable)
    defaults = {
        name: action["inputs"][re.search(r"inputs\.([a-z-]+)", value)[1]].get("default", "")
        for name, value in step["env"].items()
    }
    environment = os.environ | defaults | inputs | {"PYTHONPATH": _paths(), "RUNNER_TEMP": str(tmp_path)}
    command = ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", step["run"]]
    return subprocess.run(command, cwd=ROOT, env=environment, check=False).returncode


def _paths() -> str:
    """Return where this Python finds its modules: a link to it is no virtual environment."""
    return os.pathsep.join([str(ROOT), *filter(None, sys.path)])


def test_the_hook_uses_options_that_exist() -> None:
    (hook,) = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text())
    assert hook["entry"].startswith("tumtools validate ")
    known = {option for parameter in command.params for option in parameter.opts + parameter.secondary_opts}
    assert all(word in known for word in hook["entry"].split() if word.startswith("-"))
