# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Which images become one scan, under which times and names."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.formats.rawlog.made import FIRST, FRAME_NS, Made, accelerometer, colour, depth, typical
from tumtools.errors import OutputError
from tumtools.formats.rawlog.plan import MAX_DIFFERENCE_NS, plan_converter, plan_lossless
from tumtools.formats.tum.text import parse
from tumtools.model.time import stamp_to_ticks

if TYPE_CHECKING:
    from pathlib import Path

COLOUR, DEPTH = colour(), depth()
TIMES = st.lists(st.integers(0, 200_000_000).map(lambda ns: FIRST + ns), max_size=12)


def _sequence(rgb: list[int], depths: list[int], ir: list[int] | None = None) -> Made:
    images = {"rgb": [(t, COLOUR) for t in rgb], "depth": [(t, DEPTH) for t in depths]}
    return Made(images | ({"ir": [(t, COLOUR) for t in ir]} if ir else {}))


@given(TIMES, TIMES, TIMES)
def test_every_image_is_in_exactly_one_scan(rgb: list[int], depths: list[int], ir: list[int]) -> None:
    plan = plan_lossless(_sequence(rgb, depths, ir))
    keys = [key for slot in plan.slots for key in slot.keys]
    lists = {"rgb": rgb, "depth": depths, "ir": ir}
    assert sorted(keys) == sorted((name, row) for name, times in lists.items() for row in range(len(times)))
    assert all(one.ticks <= other.ticks for one, other in pairwise(plan.slots))
    names = [name for group in plan.files().values() for name in group]
    assert len(set(names)) == len(names)
    assert plan.losses == ()


@given(TIMES, TIMES)
def test_pairs_are_each_others_nearest_and_close(rgb: list[int], depths: list[int]) -> None:
    pairs = [
        (rgb[slot.image[1]], depths[slot.depth[1]])
        for slot in plan_lossless(_sequence(rgb, depths)).slots
        if slot.image and slot.depth
    ]
    for first, second in pairs:
        gap = abs(first - second)
        assert gap <= MAX_DIFFERENCE_NS
        assert gap == min(abs(other - second) for other in rgb) == min(abs(first - other) for other in depths)
    if rgb and depths:
        closest = min(abs(one - other) for one in rgb for other in depths)
        assert bool(pairs) == (closest <= MAX_DIFFERENCE_NS)


def test_the_time_is_that_of_the_colour_image_and_each_file_has_its_own() -> None:
    (slot,) = plan_lossless(_sequence([FIRST], [FIRST + 36_000])).slots
    assert slot.ticks == stamp_to_ticks(FIRST)
    assert slot.image_file == "1305031229.528748_rgb"
    assert slot.depth_file == "1305031229.528784_depth"


def test_names_have_as_many_decimals_as_the_stamps_need_and_tell_equal_stamps_apart() -> None:
    plan = plan_lossless(_sequence([FIRST, FIRST, FIRST + 1], []))
    assert [slot.image_file for slot in plan.slots] == [
        "1305031229.528748000_rgb",
        "1305031229.528748000-1_rgb",
        "1305031229.528748001_rgb",
    ]


def test_infrared_takes_the_place_of_colour_where_there_is_none() -> None:
    both = plan_lossless(_sequence([FIRST], [FIRST], [FIRST]))
    assert [slot.keys for slot in both.slots] == [(("rgb", 0), ("depth", 0)), (("ir", 0),)]
    alone = plan_lossless(_sequence([], [FIRST], [FIRST]))
    assert [slot.keys for slot in alone.slots] == [(("ir", 0), ("depth", 0))]


def test_accelerometer_rows_are_in_order_of_time() -> None:
    sequence = Made({}, accelerometer([FIRST + 250, FIRST, FIRST + 100]))
    plan = plan_lossless(sequence)
    assert plan.imu_rows.tolist() == [1, 2, 0]
    assert plan.imu_ticks.tolist() == [stamp_to_ticks(FIRST) + tick for tick in (0, 1, 2)]


def test_the_converter_says_what_it_loses() -> None:
    frame = 33_000_000
    sequence = Made(
        {
            "rgb": [(FIRST, COLOUR), (FIRST + frame, COLOUR), (FIRST + 10 * frame, COLOUR)],
            "depth": [(FIRST + 16_600_000, DEPTH), (FIRST + 5 * frame, DEPTH)],
            "ir": [(FIRST, COLOUR)],
        },
        accelerometer([FIRST + 1_000_000, FIRST + 40 * frame]),
    )
    plan = plan_converter(sequence)
    assert [slot.keys for slot in plan.slots] == [(("rgb", 0), ("depth", 0)), (("rgb", 1), ("depth", 0))]
    assert {(loss.stream, loss.what): (loss.count, loss.largest_error) for loss in plan.losses} == {
        ("rgb", "images dropped"): (1, None),
        ("depth", "images dropped"): (1, None),
        ("ir", "images dropped"): (1, None),
        ("depth", "images stored again"): (1, None),
        ("accelerometer", "rows dropped"): (1, None),
        ("rgb", "stamps replaced"): (2, 0.0083),
        ("depth", "stamps replaced"): (2, 0.0083),
        ("accelerometer", "stamps replaced"): (1, pytest.approx(0.0073)),
    }


def test_the_converter_of_a_sequence_without_depth_keeps_colour_alone() -> None:
    plan = plan_converter(Made({"rgb": [(FIRST, COLOUR)]}))
    assert [slot.keys for slot in plan.slots] == [(("rgb", 0),)]
    assert [slot.keys for slot in plan_converter(Made({"depth": [(FIRST, DEPTH)]})).slots] == [
        (("depth", 0),)
    ]


@pytest.mark.parametrize("stream", ["rgb", "depth"])
def test_the_converter_stores_no_accelerations_without_both_colour_and_depth(stream: str) -> None:
    """MRPT's program looks for them only where it pairs the two; that they are missing is told."""
    times = [FIRST + FRAME_NS * number for number in range(11)]
    image = COLOUR if stream == "rgb" else DEPTH
    plan = plan_converter(Made({stream: [(t, image) for t in times]}, accelerometer(times)))
    assert len(plan.slots) == 11
    assert plan.imu_ticks.tolist() == plan.imu_rows.tolist() == []
    (loss,) = plan.losses
    assert (loss.stream, loss.what, loss.count) == ("accelerometer", "rows dropped", 11)
    assert "where colour or depth is missing" in loss.why


def test_a_pair_of_equal_stamps_loses_no_stamp_in_the_converter() -> None:
    assert plan_converter(_sequence([FIRST], [FIRST])).losses == ()


@pytest.mark.real
def test_the_converter_pairs_the_whole_of_fr1_rpy_as_mrpt_does(real_data: Path) -> None:
    lists = {
        stream: parse((real_data / "lists" / f"fr1_rpy_{stream}.txt").read_bytes(), stream, stream).stamps
        for stream in ("rgb", "depth")
    }
    plan = plan_converter(_sequence(lists["rgb"].tolist(), lists["depth"].tolist()))
    assert len(lists["rgb"]) == 723
    assert len(plan.slots) == 676
    assert len({slot.depth for slot in plan.slots}) == 664
    found = {(loss.stream, loss.what): loss.count for loss in plan.losses}
    assert found["rgb", "images dropped"] == 47
    assert found["depth", "images stored again"] == 12


def test_an_empty_sequence_has_an_empty_plan() -> None:
    plan = plan_lossless(Made({}))
    assert plan.slots == ()
    assert np.array_equal(plan.imu_ticks, [])
    assert plan_lossless(typical(0)).slots == ()


def test_the_converter_refuses_what_it_has_no_names_for() -> None:
    for stamps, reason in (
        ([], "scans only"),
        ([FIRST, FIRST + 300], "two scans in one"),
        ([2**63 - 1], "the year 2262"),
    ):
        with pytest.raises(OutputError, match=reason):
            plan_converter(_sequence(stamps, []))
