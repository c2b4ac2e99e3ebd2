# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A smaller matrix on published data."""

from __future__ import annotations

import filecmp
from typing import TYPE_CHECKING

import pytest

from tests.roundtrip.base import Sources
from tests.roundtrip.harness import run
from tests.roundtrip.variants import Variant, defaults
from tumtools.convert import ConvertOptions, convert
from tumtools.sources import open_source
from tumtools.transform import Selection, first_stamp

if TYPE_CHECKING:
    from pathlib import Path

pytestmark = pytest.mark.real

ARCHIVES = (
    Variant("mcap", {"archive": True}, ".mcap"),
    Variant("rosbag1", {"archive": True}, ".bag"),
    Variant("rosbag2", {"archive": True}),
)

MILLIMETRES = Variant("mcap", {"depth_encoding": "16UC1"}, ".mcap")


@pytest.fixture(scope="module")
def part(real_sequence: Path, tmp_path_factory: pytest.TempPathFactory) -> Sources:
    """Return the first fifth of a second of fr1/rpy, in every format."""
    folder = tmp_path_factory.mktemp("real")
    with open_source(real_sequence) as sequence:
        start = first_stamp(sequence) or 0
        chosen = ConvertOptions(Selection(start=start, end=start + 200_000_000))
        convert(sequence, folder / "sequence", "tum", options=chosen)
    return Sources(folder / "sequence", folder / "sources")


@pytest.mark.parametrize(
    "by_way_of", [*defaults(), Variant("mcap", {"depth_encoding": "16UC1"}, ".mcap")], ids=str
)
def test_published_images_come_back(by_way_of: Variant, part: Sources, tmp_path: Path) -> None:
    tum = defaults()[0]
    outcome = run((tum, by_way_of, tum), part[tum], tmp_path)
    assert bool(outcome.steps[0]) == ("depth_encoding" in by_way_of.options)
    assert outcome.pixels >= 2 * 10 * 640 * 480


@pytest.mark.parametrize("by_way_of", ARCHIVES, ids=str)
def test_an_archive_gives_the_same_files_again(by_way_of: Variant, part: Sources, tmp_path: Path) -> None:
    tum = defaults()[0]
    run((tum, by_way_of, tum), part[tum], tmp_path)
    compared = filecmp.dircmp(part[tum], tmp_path / "2" / "sequence")
    for one in (compared, *compared.subdirs.values()):
        assert not one.left_only + one.right_only + one.diff_files + one.funny_files
        assert filecmp.cmpfiles(one.left, one.right, one.same_files, shallow=False)[1:] == ([], [])


@pytest.mark.parametrize("variant", defaults(), ids=str)
def test_published_ground_truth_comes_back(variant: Variant, real_data: Path, tmp_path: Path) -> None:
    """fr2/desk has a stamp with two poses."""
    files = sorted((real_data / "groundtruth").glob("*.txt"))
    assert files
    for file in files:
        folder = tmp_path / file.stem
        outcome = run((variant, variant, defaults()[0]), file, folder)
        assert not any(outcome.steps)
        assert (folder / "2" / "sequence" / "groundtruth.txt").read_bytes() == file.read_bytes()
