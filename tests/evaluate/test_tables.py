# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
from __future__ import annotations

import numpy as np

from tests.evaluate.conftest import drifted, walk
from tumtools.evaluate import tables
from tumtools.evaluate.ate import evaluate_ate
from tumtools.evaluate.rpe import evaluate_rpe
from tumtools.formats.tum.text import parse
from tumtools.model.signals import Trajectory


def numbers(text: str) -> np.ndarray:
    return np.array([[float(field) for field in line.split()] for line in text.splitlines()])


def test_saved_estimate_is_the_aligned_one() -> None:
    result = evaluate_ate(walk(30), drifted(walk(30)))
    text = tables.aligned_positions(result)
    assert text.splitlines()[0].startswith("1305031102.000000 ")
    assert not text.endswith("\n")
    np.testing.assert_allclose(numbers(text)[:, 1:], result.aligned.positions, atol=1e-6)


def test_saved_pairs_differ_by_the_errors() -> None:
    result = evaluate_ate(walk(30), drifted(walk(30)))
    rows = numbers(tables.ate_pairs(result))
    assert rows.shape == (30, 8)
    np.testing.assert_allclose(np.linalg.norm(rows[:, 1:4] - rows[:, 5:8], axis=1), result.errors, atol=3e-6)


def test_saved_trajectory_can_be_read_and_measured_again() -> None:
    result = evaluate_ate(walk(30), drifted(walk(30)))
    table = parse(tables.aligned_trajectory(result.aligned).encode(), "groundtruth", "aligned.txt")
    again = Trajectory(table.stamps, table.values[:, :3], table.values[:, 3:])
    assert again.stamps.tolist() == walk(30).stamps.tolist()
    assert (
        abs(evaluate_ate(walk(30), again, alignment="none").statistics.rmse - result.statistics.rmse) < 1e-8
    )


def test_stamps_keep_more_than_six_decimals_where_they_have_them() -> None:
    assert list(tables.stamps_as_text(np.array([1_500_000_000, 2_000_000_001]))) == [
        "1.500000000",
        "2.000000001",
    ]
    assert list(tables.stamps_as_text(np.array([1_500_000_000]))) == ["1.500000"]


def test_saved_relative_errors_are_in_metres_and_radians() -> None:
    result = evaluate_rpe(walk(60), drifted(walk(60)), delta=5, unit="f")
    rows = numbers(tables.rpe_pairs(result))
    assert rows.shape == (result.pairs, 6)
    np.testing.assert_allclose(rows[:, 4], result.translational_errors, atol=1e-6)
    np.testing.assert_allclose(rows[:, 5], result.rotational_errors, atol=1e-6)
    np.testing.assert_allclose(rows[:, 1] - rows[:, 0], 0.05, atol=1e-6)


def test_only_the_scripts_form_has_the_median_in_radians() -> None:
    result = evaluate_rpe(walk(60), drifted(walk(60)), delta=5, unit="f")
    lines = dict(line.split(" ", 1) for line in tables.rpe_as_scripts(result))
    assert lines["compared_pose_pairs"] == f"{result.pairs} pairs"
    assert lines["rotational_error.rmse"] == f"{result.rotation.rmse:f} deg"
    assert lines["rotational_error.median"] == f"{np.radians(result.rotation.median):f} deg"
