# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""All pairs by FFT against all pairs one by one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.evaluate import brute
from tests.evaluate.conftest import drifted, walk
from tumtools.errors import InputError
from tumtools.evaluate import allpairs
from tumtools.evaluate.allpairs import evaluate_rpe_all_pairs, rotational_rmse, translational_rmse
from tumtools.evaluate.geometry import multiply, rotate
from tumtools.evaluate.matching import match
from tumtools.evaluate.trajectories import clean
from tumtools.model.signals import Trajectory

if TYPE_CHECKING:
    from collections.abc import Callable

RELATIVE = 1e-9
"""The promise is 1e-6."""


def check(groundtruth: Trajectory, estimate: Trajectory) -> None:
    rp, rq = brute.matrices(estimate.quaternions), brute.matrices(groundtruth.quaternions)
    expected = brute.translational(estimate.positions, rp, groundtruth.positions, rq)
    np.testing.assert_allclose(translational_rmse(groundtruth, estimate), expected, rtol=RELATIVE, atol=1e-10)
    np.testing.assert_allclose(rotational_rmse(groundtruth, estimate), brute.rotational(rp, rq), atol=2e-7)


def moved(trajectory: Trajectory) -> Trajectory:
    turn = np.tile([0.0, 0.0, np.sin(0.7), np.cos(0.7)], (len(trajectory), 1))
    positions = rotate(turn, trajectory.positions) + np.array([100.0, 200.0, -300.0])
    return Trajectory(trajectory.stamps, positions, multiply(turn, trajectory.quaternions))


def with_outlier(trajectory: Trajectory) -> Trajectory:
    positions = trajectory.positions.copy()
    positions[len(positions) // 2] += 1e6
    return Trajectory(trajectory.stamps, positions, trajectory.quaternions)


CASES = {
    "a walk": lambda: (walk(700), drifted(walk(700))),
    "far from the origin": lambda: (far := walk(700, start=(1e5, -3e6, 2e4)), drifted(far)),
    "kilometres": lambda: (long := walk(700, step=20.0), drifted(long, drift=1e-5)),
    "still": lambda: (still := walk(700, step=1e-6), drifted(still, drift=1e-7)),
    "in another frame": lambda: (walk(700), moved(drifted(walk(700)))),
    "nothing in common": lambda: (walk(700), walk(700, seed=9)),
    "one pose far off": lambda: (walk(301), with_outlier(drifted(walk(301)))),
    "two poses": lambda: (walk(2), drifted(walk(2))),
    "three poses": lambda: (walk(3), drifted(walk(3))),
}


@pytest.mark.parametrize("case", CASES)
def test_made_trajectories(case: str) -> None:
    check(*CASES[case]())


@settings(max_examples=25)
@given(st.integers(2, 60), st.integers(0, 1000), st.floats(0.0, 10.0), st.floats(0.0, 0.1))
def test_random_trajectories(n: int, seed: int, step: float, drift: float) -> None:
    groundtruth = walk(n, seed, step)
    check(groundtruth, drifted(groundtruth, seed + 1, drift))


@pytest.mark.real
@pytest.mark.parametrize("name", ["freiburg1_desk2", "freiburg1_room", "freiburg2_360_kidnap"])
def test_real_estimates(
    name: str, groundtruth: Callable[[str], Trajectory], estimate: Callable[[str], Trajectory]
) -> None:
    true = clean(groundtruth(name), "ground truth", rotations=True).trajectory
    found = match(true, clean(estimate(f"{name}-rgbdslam"), "estimate", rotations=True).trajectory)
    check(found.groundtruth, found.estimate)


def test_a_perfect_estimate_has_no_error() -> None:
    result = evaluate_rpe_all_pairs(walk(300), moved(walk(300)))
    assert result.translation < 1e-10
    assert result.rotation is not None
    assert result.rotation < 1e-5


def test_only_doubtful_distances_are_summed_directly(monkeypatch: pytest.MonkeyPatch) -> None:
    """An outlier drowns the digits of the distances that it does not take part in, and only of those."""
    summed: list[int] = []
    direct = allpairs._Differences.direct

    def counted(self: allpairs._Differences, distance: int) -> float:
        summed.append(distance)
        return direct(self, distance)

    monkeypatch.setattr(allpairs._Differences, "direct", counted)
    translational_rmse(walk(301), drifted(walk(301)))
    assert summed == []
    translational_rmse(walk(301), with_outlier(drifted(walk(301))))
    assert summed == list(range(151, 301))


def test_equation_3_is_the_mean_over_the_distances() -> None:
    groundtruth = walk(50)
    result = evaluate_rpe_all_pairs(groundtruth, drifted(groundtruth))
    assert (result.poses, result.pairs, result.step) == (50, 1225, 10_000_000)
    assert result.translation == pytest.approx(np.mean(result.translational_rmse))
    assert result.rotation == pytest.approx(np.mean(result.rotational_rmse))
    assert result.notes == ()


def test_rotation_can_be_left_out() -> None:
    result = evaluate_rpe_all_pairs(walk(50), drifted(walk(50)), rotation=False)
    assert result.rotation is result.rotational_rmse is None


def test_scale_is_applied() -> None:
    groundtruth = walk(50)
    half = Trajectory(groundtruth.stamps, groundtruth.positions / 2.0, groundtruth.quaternions)
    assert evaluate_rpe_all_pairs(groundtruth, half, scale=2.0).translation < 1e-12
    assert evaluate_rpe_all_pairs(groundtruth, half).translation > 0.01


def test_uneven_steps_are_said() -> None:
    whole = walk(100)
    holed = whole.take(np.r_[0:40, 60:100])
    notes = evaluate_rpe_all_pairs(whole, holed).notes
    assert len(notes) == 1
    assert "1 of 79 steps" in notes[0]


def test_one_pose_is_refused() -> None:
    with pytest.raises(InputError, match="only one pose"):
        evaluate_rpe_all_pairs(walk(50), walk(50).take(slice(0, 1)))
