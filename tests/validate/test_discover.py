# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A folder of sequences stands for the sequences in it."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tumtools.cli.main import run
from tumtools.validate.discover import discover

FIXTURES = Path(__file__).parents[2] / "fixtures"


@pytest.fixture
def data(tmp_path: Path) -> Path:
    """Return a folder with two sequences, an archive, and other things."""
    data = tmp_path / "data"
    shutil.copytree(FIXTURES / "full", data / "b" / "full")
    shutil.copytree(FIXTURES / "fr3", data / "a")
    shutil.copytree(FIXTURES / "fr3", data / ".hidden")
    shutil.make_archive(str(data / "c"), "zip", FIXTURES, "validation")
    (data / "notes.txt").write_text("no sequence")
    return data


def test_sequences_are_found_in_order_and_not_below_each_other(data: Path) -> None:
    shutil.copytree(FIXTURES / "fr3", data / "a" / "inner")
    assert discover(str(data)) == [str(data / "a"), str(data / "b" / "full"), str(data / "c.zip")]


def test_a_sequence_stands_for_itself() -> None:
    assert discover(str(FIXTURES / "full")) == [str(FIXTURES / "full")]
    assert discover("fr1/desk") == ["fr1/desk"]


def test_a_folder_with_nothing_in_it_is_reported_as_such(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert discover(str(tmp_path)) == [str(tmp_path)]
    assert run(["validate", str(tmp_path)]) == 1
    assert "no sequence in this folder" in capsys.readouterr().out


def test_validate_takes_a_folder_of_sequences(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["validate", str(data)]) == 0
    assert "3 sources, 0 failed" in capsys.readouterr().out
