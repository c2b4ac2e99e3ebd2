# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.evaluate.brute import greedy, optimal_score
from tumtools.errors import UsageError
from tumtools.evaluate.associate import METHODS, associate
from tumtools.model.time import format_stamp, parse_stamp

if TYPE_CHECKING:
    from pathlib import Path

stamps = st.lists(st.integers(0, 60), max_size=25)
few_stamps = st.lists(st.integers(0, 25), max_size=7)


def pairs(
    first: list[int], second: list[int], limit: int, method: str, offset: int = 0
) -> list[tuple[int, int]]:
    one, two = np.array(first, np.int64), np.array(second, np.int64)
    found = associate(one, two, max_difference=limit, offset=offset, method=method)
    assert (found.differences == one[found.first] - two[found.second] - offset).all()
    return list(zip(one[found.first].tolist(), two[found.second].tolist(), strict=True))


@given(stamps, stamps, st.integers(1, 30))
def test_tum_takes_exactly_the_pairs_of_the_sorted_list_of_all_differences(
    first: list[int], second: list[int], limit: int
) -> None:
    assert pairs(first, second, limit, "tum") == greedy(first, second, limit)


@given(
    st.lists(st.integers(0, 200), max_size=20),
    st.lists(st.integers(0, 200), max_size=20),
    st.integers(-40, 40),
)
def test_ties_of_real_stamps_fall_as_the_floats_of_the_scripts_have_it(
    first: list[int], second: list[int], offset: int
) -> None:
    """Stamps of today on a raster of half a millisecond: many differences are equal."""
    one, two = ([1_305_031_453_374_100_000 + 500_000 * k for k in points] for points in (first, second))
    offset *= 500_000
    assert pairs(one, two, 20_000_000, "tum", offset) == greedy(one, two, 20_000_000, offset)


@given(stamps, stamps, st.integers(1, 30))
def test_the_heap_alone_finds_the_same_pairs(first: list[int], second: list[int], limit: int) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tumtools.evaluate.greedy._WORTHWHILE", 2.0)
        assert pairs(first, second, limit, "tum") == greedy(first, second, limit)


def test_chains_of_ever_smaller_distances_are_taken_from_their_end() -> None:
    """Each step is shorter than the one before, so that one round finds one pair only."""
    points = list(itertools.accumulate(range(4000, 0, -1)))
    first, second = points[::2], points[1::2]
    assert pairs(first[-300:], second[-300:], 10**9, "tum") == greedy(first[-300:], second[-300:], 10**9)
    assert len(pairs(first, second, 10**9, "tum")) == 2000


@given(few_stamps, few_stamps, st.integers(1, 20))
def test_optimal_has_the_most_pairs_and_then_the_least_sum(
    first: list[int], second: list[int], limit: int
) -> None:
    found = pairs(first, second, limit, "optimal")
    assert len({a for a, _ in found}) == len({b for _, b in found}) == len(found)
    assert all(abs(a - b) < limit for a, b in found)
    assert (len(found), sum(abs(a - b) for a, b in found)) == optimal_score(first, second, limit)


@given(stamps, stamps, st.integers(1, 30))
def test_nearest_gives_each_of_the_shorter_stream_its_nearest(
    first: list[int], second: list[int], limit: int
) -> None:
    """On quarters of a second, which floats hold exactly, so that ties are ties."""
    quarter = 250_000_000
    one, two = (sorted({quarter * k for k in points}) for points in (first, second))
    limit *= quarter
    swap = len(one) > len(two)
    short, long = (two, one) if swap else (one, two)
    expected = []
    for stamp in short:
        best = min(long, key=lambda other: (abs(other - stamp), other), default=None)
        if best is not None and abs(best - stamp) <= limit:
            expected.append((best, stamp) if swap else (stamp, best))
    assert sorted(pairs(one, two, limit, "nearest")) == sorted(expected)


@pytest.mark.parametrize("method", METHODS)
def test_offset_is_added_to_the_second_stamps(method: str) -> None:
    assert pairs([100, 200], [90, 190], 5, method, offset=8) == [(100, 90), (200, 190)]
    assert pairs([100, 200], [90, 190], 5, method, offset=-8) == []


def test_the_limit_is_strict_for_tum_and_may_be_reached_for_nearest() -> None:
    assert pairs([0], [20], 20, "tum") == []
    assert pairs([0], [20], 20, "optimal") == []
    assert pairs([0], [20], 20, "nearest") == [(0, 20)]


@pytest.mark.parametrize("method", METHODS)
def test_of_rows_with_one_stamp_the_last_counts_and_order_does_not(method: str) -> None:
    found = associate(np.array([30, 10, 10]), np.array([11, 31]), max_difference=5, method=method)
    assert found.first.tolist() == [2, 0]
    assert (found.first_count, found.second_count) == (2, 2)


@pytest.mark.parametrize("method", METHODS)
def test_empty_streams_have_no_pairs(method: str) -> None:
    none = np.empty(0, np.int64)
    found = associate(none, np.array([1]), method=method)
    assert (len(found), found.unmatched_first, found.unmatched_second, found.largest_difference) == (
        0,
        0,
        1,
        0,
    )
    assert len(associate(none, none, method=method)) == 0


def test_stamps_at_both_ends_of_int64_are_no_pair() -> None:
    assert pairs([-(2**63)], [2**63 - 1], 2**62, "tum") == []


@pytest.mark.parametrize(
    "arguments", [{"method": "best"}, {"max_difference": 0}, {"max_difference": -1}, {"offset": 2**63 - 2}]
)
def test_nonsense_is_refused(arguments: dict[str, object]) -> None:
    with pytest.raises(UsageError):
        associate(np.array([5]), np.array([5]), **arguments)


def test_a_window_too_wide_for_optimal_is_refused() -> None:
    times = np.arange(1000) * 10**9
    with pytest.raises(UsageError, match="too wide"):
        associate(times, times, max_difference=2**60, method="optimal")


def test_too_many_candidates_for_optimal_are_refused_before_memory_is_taken() -> None:
    times = np.arange(10_000) * 1000
    with pytest.raises(UsageError, match="too many for 'optimal'"):
        associate(times, times, max_difference=10**7, method="optimal")


def read_list(path: Path) -> tuple[list[str], np.ndarray]:
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    return lines, np.array([parse_stamp(line.split()[0]) for line in lines], np.int64)


@pytest.mark.real
def test_fr1_rpy_is_associated_line_for_line_as_by_the_script(real_data: Path) -> None:
    rgb_lines, rgb = read_list(real_data / "lists/fr1_rpy_rgb.txt")
    depth_lines, depth = read_list(real_data / "lists/fr1_rpy_depth.txt")
    found = associate(rgb, depth)
    lines = [f"{rgb_lines[i]} {depth_lines[j]}" for i, j in zip(found.first, found.second, strict=True)]
    assert len(lines) == 694
    assert lines == (real_data / "lists/fr1_rpy_associate_output.txt").read_text().splitlines()


@pytest.mark.real
def test_the_complete_lists_of_fr1_xyz_give_792_pairs(real_data: Path) -> None:
    folder = real_data / "malformed/header_without_hash"
    rgb, depth = (
        np.array([parse_stamp(line.split()[0]) for line in (folder / name).read_text().splitlines()[3:]])
        for name in ("rgb.txt", "depth.txt")
    )
    assert len(associate(rgb, depth)) == 792


@pytest.mark.real
@pytest.mark.parametrize(("name", "count"), [("fr1_xyz", 792), ("fr1_desk", 573), ("fr3_office", 2488)])
def test_published_pairs_are_found_again_in_their_own_stamps(real_data: Path, name: str, count: int) -> None:
    fields = [line.split() for line in (real_data / f"lists/{name}.txt").read_text().splitlines()]
    rgb = np.array([parse_stamp(row[0]) for row in fields])
    depth = np.array([parse_stamp(row[2]) for row in fields])
    found = associate(rgb, depth)
    assert len(found) == count
    assert [format_stamp(int(rgb[i])) for i in found.first] == [row[0] for row in fields]
    assert [format_stamp(int(depth[i])) for i in found.second] == [row[2] for row in fields]
