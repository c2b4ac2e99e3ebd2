# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The action and the hook for CI call the program as it is."""

from __future__ import annotations

import os
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
    assert inputs["fail-on"]["default"] in FAIL_ON


@pytest.mark.skipif(shutil.which("bash") is None, reason="bash is not installed")
@pytest.mark.parametrize(
    ("paths", "code"), [("fixtures/full\n  fixtures/fr3  \n", 0), ("fixtures/full\nno such folder\n", 1)]
)
def test_the_last_step_runs_as_it_stands(
    action: dict[str, Any], tmp_path: Path, paths: str, code: int
) -> None:
    script = action["runs"]["steps"][-1]["run"].replace("python -m", f"{sys.executable} -m")
    report = tmp_path / "report.json"
    environment = {
        "TUMTOOLS_PATHS": paths,
        "TUMTOOLS_FORMAT": "json",
        "TUMTOOLS_OUTPUT": str(report),
        "TUMTOOLS_FAIL_ON": "error",
        "PYTHONPATH": str(ROOT),
    }
    done = subprocess.run(
        ["bash", "-eo", "pipefail", "-c", script], cwd=ROOT, env=os.environ | environment, check=False
    )
    assert done.returncode == code
    assert '"sources"' in report.read_text()


def test_the_hook_uses_options_that_exist() -> None:
    (hook,) = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text())
    assert hook["entry"].startswith("tumtools validate ")
    known = {option for parameter in command.params for option in parameter.opts + parameter.secondary_opts}
    assert all(word in known for word in hook["entry"].split() if word.startswith("-"))
