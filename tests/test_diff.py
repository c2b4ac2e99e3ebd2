# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What counts as a difference of two sequences, and what does not."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tests.memory import START, Memory, groundtruth
from tumtools.cli.main import run
from tumtools.diff import diff
from tumtools.model.text import default_layout

if TYPE_CHECKING:
    from pathlib import Path

    import pytest


def test_two_files_without_text_are_the_same_under_any_names() -> None:
    """As three bags of one recording, which differ in nothing but their compression."""
    first, second = (Memory({}, groundtruth=groundtruth(START), name=name) for name in ("a", "a-bz2"))
    assert diff(first, second).same


def test_a_header_that_is_there_is_compared() -> None:
    layout = default_layout("groundtruth", "other")
    first = Memory({}, groundtruth=groundtruth(START), name="a")
    second = Memory({}, groundtruth=groundtruth(START), name="a", text={"groundtruth": layout})
    assert [one.what for one in diff(first, second).differences] == ["text"]


def test_nothing_on_both_sides_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "rgb.txt").touch()
    assert run(["diff", str(tmp_path / "a"), str(tmp_path / "b")]) == 0
    assert "nothing was compared" in capsys.readouterr().err
