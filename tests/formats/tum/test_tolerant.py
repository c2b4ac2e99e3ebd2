# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Opened tolerantly, a sequence tells all that is wrong with it instead of the first thing."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tumtools.errors import InputError
from tumtools.formats.tum.reader import TumSequence, open_tolerant

FIXTURE = Path(__file__).parents[3] / "fixtures" / "full"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return shutil.copytree(FIXTURE, tmp_path / "full")


def _open(folder: Path) -> TumSequence:
    sequence = open_tolerant(folder)
    assert isinstance(sequence, TumSequence)
    return sequence


def test_bad_lines_are_collected_with_their_numbers_and_text(folder: Path) -> None:
    text = (folder / "groundtruth.txt").read_text().splitlines()
    text[7] = "1305031000.1 1 2"
    text[9] = "yesterday 0 0 0 0 0 0 1"
    (folder / "groundtruth.txt").write_text("\n".join(text) + "\n")
    table = _open(folder).tables["groundtruth"]
    assert [(problem.line, problem.text) for problem in table.problems] == [(8, text[7]), (10, text[9])]
    assert len(table.stamps) == len(text) - 3 - 2


def test_missing_images_are_passed_over(folder: Path) -> None:
    gone = sorted((folder / "rgb").iterdir())[1]
    gone.unlink()
    sequence = _open(folder)
    assert sequence.missing == [f"rgb/{gone.name}"]
    assert [frame.row for frame in sequence.images(["rgb"])] == [0, 2, 3]


def test_a_file_that_is_no_text_is_named(folder: Path) -> None:
    text = (folder / "depth.txt").read_text()
    (folder / "depth.txt").write_bytes(text.encode("utf-16"))
    sequence = _open(folder)
    assert isinstance(sequence.damaged["depth"], InputError)
    assert len(sequence.image_stamps("depth")) == 0
    assert len(sequence.image_stamps("rgb")) == 4


def test_names_that_lead_elsewhere_are_missing_images(folder: Path) -> None:
    text = (folder / "rgb.txt").read_text().splitlines()
    text[3] = text[3].split()[0] + " ../../secret.png"
    (folder / "rgb.txt").write_text("\n".join(text) + "\n")
    assert _open(folder).missing == ["../../secret.png"]


def test_a_header_can_be_read_alone(folder: Path) -> None:
    assert _open(folder).png_header("depth", 2).bit_depth == 16
