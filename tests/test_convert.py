# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Conversions as a whole."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tests.memory import START, Memory, groundtruth
from tumtools.convert import convert
from tumtools.formats.options import WriteOptions
from tumtools.sources import open_source

if TYPE_CHECKING:
    from pathlib import Path


def test_topics_may_be_named_for_streams_that_are_not_there(tmp_path: Path) -> None:
    """The verification looked for them in the result."""
    sequence = Memory({"rgb": [START]}, groundtruth=groundtruth(START))
    options = WriteOptions(groundtruth="tf", topics={"depth": "/d", "groundtruth": "/g", "rgb": "/color"})
    report = convert(sequence, tmp_path / "x.mcap", "mcap", options)
    assert report.verified
    with open_source(tmp_path / "x.mcap") as result:
        assert result.info.images["rgb"].source == "/color"
