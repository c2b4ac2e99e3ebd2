# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The benchmark's own scripts, to the last digit that they print."""

from __future__ import annotations

import csv
from typing import TYPE_CHECKING

import numpy as np
import pytest

from tumtools.evaluate.ate import evaluate_ate
from tumtools.evaluate.rpe import evaluate_rpe

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path
    from typing import Any

    from tumtools.model.signals import Trajectory

pytestmark = pytest.mark.real

SEQUENCES = [
    *(f"freiburg1_{name}" for name in ("360", "desk", "desk2", "floor", "room", "rpy", "xyz")),
    "freiburg2_360_kidnap",
    "freiburg2_desk",
]
RPE = {"rpe_1s": (1.0, "s"), "rpe_1f": (1.0, "f"), "rpe_1m": (1.0, "m")}
PRINTED = ("rmse", "mean", "median", "std", "min", "max")


def printed(numbers: dict[str, float]) -> dict[str, str]:
    return {name: f"{value:f}" for name, value in numbers.items()}


@pytest.fixture(params=SEQUENCES[:-1])
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def test_absolute_error(
    name: str,
    groundtruth: Callable[[str], Trajectory],
    estimate: Callable[[str], Trajectory],
    reference: dict[str, Any],
) -> None:
    result = evaluate_ate(groundtruth(name), estimate(f"{name}-rgbdslam"))
    ours = {f"absolute_translational_error.{key}": getattr(result.statistics, key) for key in PRINTED}
    ours["compared_pose_pairs"] = result.pairs
    assert printed(ours) == printed(reference[name]["ate"])


@pytest.mark.parametrize("case", RPE)
def test_relative_error(
    case: str,
    name: str,
    groundtruth: Callable[[str], Trajectory],
    estimate: Callable[[str], Trajectory],
    reference: dict[str, Any],
) -> None:
    delta, unit = RPE[case]
    result = evaluate_rpe(groundtruth(name), estimate(f"{name}-rgbdslam"), delta=delta, unit=unit)
    ours = {f"translational_error.{key}": getattr(result.translation, key) for key in PRINTED}
    ours |= {f"rotational_error.{key}": getattr(result.rotation, key) for key in PRINTED}
    # The scripts print this one in radians.
    ours["rotational_error.median"] = float(np.radians(result.rotation.median))
    ours["compared_pose_pairs"] = result.pairs
    assert printed(ours) == printed(reference[name][case])


def test_the_table_of_all_sequences(
    groundtruth: Callable[[str], Trajectory],
    estimate: Callable[[str], Trajectory],
    real_data: Path,
) -> None:
    text = (real_data / "reference/evaluation.tsv").read_text().splitlines()[1:]
    rows = list(csv.DictReader(text, delimiter="\t"))
    assert [row["sequence"] for row in rows] == SEQUENCES
    for row in rows:
        pair = groundtruth(row["sequence"]), estimate(f"{row['sequence']}-rgbdslam")
        ate = evaluate_ate(*pair)
        ours = {"sequence": row["sequence"], "ate_pairs": str(ate.pairs)}
        ours |= {f"ate_{key}{'_m' * (key == 'rmse')}": f"{getattr(ate.statistics, key):f}" for key in PRINTED}
        for short, unit in (("1s", "s"), ("1f", "f")):
            rpe = evaluate_rpe(*pair, unit=unit)
            ours[f"rpe{short}_pairs"] = str(rpe.pairs)
            ours |= {f"rpe{short}_t_{key}": f"{getattr(rpe.translation, key):f}" for key in PRINTED}
            for key in PRINTED:
                ours[f"rpe{short}_r_{key}{'_deg' * (key == 'rmse')}"] = f"{getattr(rpe.rotation, key):f}"
        assert ours == row


@pytest.mark.parametrize(
    ("arguments", "pairs", "numbers"),
    [
        (
            {},
            2223,
            {
                "rmse": 0.008144,
                "mean": 0.007514,
                "median": 0.007432,
                "std": 0.003140,
                "min": 0.000332,
                "max": 0.024329,
            },
        ),
        ({"method": "nearest", "max_difference": 10_000_000}, 2174, {"rmse": 0.008119}),
        ({"method": "nearest", "max_difference": 20_000_000}, 2225, {"rmse": 0.008146}),
    ],
)
def test_orb_slam2_on_fr2_desk_as_published(
    arguments: dict[str, Any],
    pairs: int,
    numbers: dict[str, float],
    groundtruth: Callable[[str], Trajectory],
    estimate: Callable[[str], Trajectory],
) -> None:
    result = evaluate_ate(groundtruth("freiburg2_desk"), estimate("fr2_desk_ORB"), **arguments)
    assert result.pairs == pairs
    assert {key: f"{getattr(result.statistics, key):f}" for key in numbers} == printed(numbers)
