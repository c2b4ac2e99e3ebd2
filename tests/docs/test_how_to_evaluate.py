# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Every command of the page runs, on the files that the page speaks of."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest

from tests.evaluate.conftest import drifted, walk
from tumtools.cli.main import run
from tumtools.evaluate.tables import aligned_trajectory

PAGE = Path(__file__).parents[2] / "docs/how-to/evaluate.md"
COMMANDS = [
    line.removeprefix("$ tumtools ") for line in PAGE.read_text().splitlines() if line.startswith("$ ")
]


def test_the_page_has_commands() -> None:
    assert len(COMMANDS) > 10


@pytest.mark.parametrize("command", COMMANDS)
def test_command(command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if "-o " in command or "--plot" in command:
        pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    Path("groundtruth.txt").write_text(aligned_trajectory(walk(600)))
    Path("estimate.txt").write_text(aligned_trajectory(drifted(walk(600))))
    assert run(shlex.split(command)) == 0
