# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.evaluate.brute import matrices
from tests.evaluate.conftest import drifted, walk
from tumtools.errors import InputError, UsageError
from tumtools.evaluate.rpe import UNITS, Sampling, closest_index, evaluate_rpe, fixed_pairs
from tumtools.evaluate.sampling import random_pairs, sample, splitmix64
from tumtools.model.signals import Trajectory


def scripts_search(places: list[float], wanted: float) -> int:
    """The binary search of evaluate_rpe.py, in words: halve, remember the nearest seen, stop at a hit."""
    low, high, best, least = 0, len(places), 0, abs(places[0] - wanted)
    while low < high:
        middle = (low + high) // 2
        if abs(places[middle] - wanted) < least:
            best, least = middle, abs(places[middle] - wanted)
        if places[middle] == wanted:
            return middle
        low, high = (low, middle) if places[middle] > wanted else (middle + 1, high)
    return best


@given(st.lists(st.integers(0, 30), min_size=1, max_size=40), st.lists(st.integers(-3, 33), min_size=1))
def test_the_scripts_search_also_where_a_camera_stands_still(places: list[int], wanted: list[int]) -> None:
    ordered = sorted(map(float, places))
    found = closest_index(np.array(ordered), np.array(wanted, float))
    assert found.tolist() == [scripts_search(ordered, float(want)) for want in wanted]


def test_errors_are_those_of_the_matrices() -> None:
    groundtruth = walk(60)
    estimate = drifted(groundtruth)
    result = evaluate_rpe(groundtruth, estimate, delta=7, unit="f")
    assert result.pairs == 60 - 7 - 1  # the pair that ends with the last pose is left out

    def pose(trajectory: Trajectory, row: int) -> np.ndarray:
        matrix = np.eye(4)
        matrix[:3, :3] = matrices(trajectory.quaternions)[row]
        matrix[:3, 3] = trajectory.positions[row]
        return matrix

    for i in (0, 20, 51):
        motions = [np.linalg.inv(pose(t, i + 7)) @ pose(t, i) for t in (estimate, groundtruth)]
        error = np.linalg.inv(motions[0]) @ motions[1]
        assert result.translational_errors[i] == pytest.approx(np.linalg.norm(error[:3, 3]))
        assert result.rotational_errors[i] == pytest.approx(np.arccos((np.trace(error[:3, :3]) - 1) / 2))


def test_statistics_of_rotation_are_all_in_degrees() -> None:
    result = evaluate_rpe(walk(60), drifted(walk(60)), delta=5, unit="f")
    assert result.rotation.median == pytest.approx(np.degrees(np.median(result.rotational_errors)))
    assert result.rotation.max == pytest.approx(np.degrees(result.rotational_errors.max()))


@pytest.mark.parametrize("unit", UNITS)
def test_pairs_are_as_far_apart_as_asked(unit: str) -> None:
    trajectory = walk(400)
    delta = {"s": 0.5, "m": 0.3, "rad": 0.2, "deg": 12.0, "f": 20.0}[unit]
    first, second = fixed_pairs(trajectory, delta, unit)
    along = {
        "s": trajectory.stamps / 1e9,
        "f": np.arange(400.0),
        "m": np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(trajectory.positions, axis=0), axis=1))],
    }
    if unit in along:
        assert np.abs(along[unit][second] - along[unit][first] - delta).max() < 0.05
    assert (second > first).all()
    assert 200 < len(first) < 400


def test_radians_and_degrees_are_the_same_distance() -> None:
    trajectory = walk(400)
    for one, other in zip(
        fixed_pairs(trajectory, 0.2, "rad"), fixed_pairs(trajectory, np.degrees(0.2), "deg"), strict=True
    ):
        np.testing.assert_array_equal(one, other)


def test_the_generator_is_splitmix64() -> None:
    """First outputs for seed 1234567, as its authors' C code gives them."""
    assert splitmix64(1234567, 3).tolist() == [6457827717110365317, 3203168211198807973, 9817491932198370423]


def test_samples_are_choices_without_repetition() -> None:
    chosen = sample(1000, 100, seed=3)
    assert len(set(chosen.tolist())) == 100
    assert chosen.tolist() == sorted(chosen.tolist()) == sample(1000, 100, seed=3).tolist()
    assert chosen.tolist() != sample(1000, 100, seed=4).tolist()
    assert sample(5, 9).tolist() == [0, 1, 2, 3, 4]


def test_random_pairs_are_spread_evenly() -> None:
    pairs = random_pairs(10, 100_000)
    assert pairs.shape == (2, 100_000)
    counts = np.histogram2d(pairs[0], pairs[1], bins=10, range=[[0, 10], [0, 10]])[0]
    assert np.abs(counts - 1000).max() < 150


def test_sampled_errors_are_near_the_complete_ones() -> None:
    groundtruth = walk(300)
    estimate = drifted(groundtruth)
    every = evaluate_rpe(groundtruth, estimate, sampling=Sampling(max_pairs=90_000, random=True))
    some = evaluate_rpe(groundtruth, estimate, sampling=Sampling(max_pairs=20_000, random=True))
    assert (every.pairs, some.pairs) == (90_000, 20_000)
    assert some.translation.rmse == pytest.approx(every.translation.rmse, rel=0.02)
    few = evaluate_rpe(groundtruth, estimate, delta=1, unit="f", sampling=Sampling(max_pairs=50))
    assert few.pairs == 50


def test_scale_is_applied_to_the_estimate() -> None:
    groundtruth = walk(60)
    half = Trajectory(groundtruth.stamps, groundtruth.positions / 2.0, groundtruth.quaternions)
    assert evaluate_rpe(groundtruth, half, delta=3, unit="f", scale=2.0).translation.max < 1e-12


def test_offset_is_added_to_the_estimate() -> None:
    groundtruth = walk(300)
    late = Trajectory(groundtruth.stamps + 5_000_000_000, groundtruth.positions, groundtruth.quaternions)
    assert evaluate_rpe(groundtruth, late, offset=-5_000_000_000).translation.max < 1e-12
    with pytest.raises(InputError, match=r"no pose of the estimate has a ground-truth pose within 0\.02 s"):
        evaluate_rpe(groundtruth, late)


def test_pairs_at_another_distance_than_asked_for_are_said() -> None:
    groundtruth = walk(200)
    assert evaluate_rpe(groundtruth, drifted(groundtruth), delta=0.5).notes == ()
    still = Trajectory(groundtruth.stamps, np.zeros_like(groundtruth.positions), groundtruth.quaternions)
    (note,) = evaluate_rpe(groundtruth, still, unit="m").notes
    assert note.startswith("200 of 200 pairs are less than half or more than one and a half times 1 m apart")
    holed = groundtruth.take(np.r_[0:100, 180:200])
    (note,) = evaluate_rpe(groundtruth, holed, delta=0.11).notes
    assert note.startswith("6 of 108 pairs")
    (note,) = evaluate_rpe(groundtruth, groundtruth, delta=0.001).notes
    assert note.startswith("199 of 199 pairs")


def test_too_long_a_distance_is_said() -> None:
    with pytest.raises(InputError, match="0 of 0 pairs of poses 60 s apart") as error:
        evaluate_rpe(walk(100), walk(100), delta=60)
    assert "shorter" in str(error.value)


@pytest.mark.parametrize(
    "arguments",
    [
        {"unit": "km"},
        {"delta": np.nan},
        {"delta": np.inf},
        {"delta": 0.0},
        {"delta": -1.0},
        {"scale": 0.0},
        {"scale": np.nan},
    ],
)
def test_nonsense_is_refused(arguments: dict[str, object]) -> None:
    with pytest.raises(UsageError):
        evaluate_rpe(walk(200), walk(200), **arguments)


@pytest.mark.parametrize(
    "arguments", [{"max_pairs": 1}, {"max_pairs": 10**9}, {"max_pairs": -1}, {"seed": -1}, {"seed": 2**64}]
)
def test_nonsense_samples_are_refused(arguments: dict[str, int]) -> None:
    with pytest.raises(UsageError):
        Sampling(**arguments)
