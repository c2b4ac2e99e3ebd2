# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools synth` writes a sequence that can be read, and refuses to overwrite."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tumtools.cli.main import run
from tumtools.sources import open_source

if TYPE_CHECKING:
    from pathlib import Path


def test_it_writes_a_sequence_in_the_published_layout(tmp_path: Path) -> None:
    target = tmp_path / "out"
    assert run(["synth", str(target), "--frames", "1", "--camera", "fr2"]) == 0
    with open_source(target) as sequence:
        assert sequence.info.name == "synthetic_freiburg2_room"
        assert [info.count for info in sequence.info.images.values()] == [1, 1]
        assert all(frame.load().png is not None for frame in sequence.images())
    assert run(["synth", str(target)]) == 2


def test_wrong_options_are_refused(tmp_path: Path) -> None:
    assert run(["synth", str(tmp_path / "out"), "--frames", "0"]) == 2
    assert run(["synth", str(tmp_path / "out"), "--camera", "fr9"]) == 2
