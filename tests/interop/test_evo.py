# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The same numbers as evo on the same pairs; evo runs as a program, in an environment of its own.

It is found on the PATH, or in the folder that the environment variable TUMTOOLS_EVO names.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import zipfile
from typing import TYPE_CHECKING

import pytest

from tests.evaluate.conftest import drifted, load, walk
from tests.interop.programs import missing
from tumtools.evaluate.allpairs import translational_rmse
from tumtools.evaluate.ate import evaluate_ate
from tumtools.evaluate.matching import match
from tumtools.evaluate.tables import aligned_trajectory
from tumtools.evaluate.trajectories import clean

if TYPE_CHECKING:
    from pathlib import Path

pytestmark = pytest.mark.interop

PRINTED = ("rmse", "mean", "median", "std", "min", "max", "sse")


def evo(tmp_path: Path, program: str, *arguments: str | Path) -> dict[str, float]:
    """Run a program of evo and return its statistics."""
    found = shutil.which(program, path=os.environ.get("TUMTOOLS_EVO"))
    if found is None:
        missing("evo")
    results = tmp_path / "results.zip"
    results.unlink(missing_ok=True)
    subprocess.run(
        [found, "tum", *arguments, "--save_results", results],
        check=True,
        capture_output=True,
        env=os.environ | {"HOME": str(tmp_path)},
    )
    with zipfile.ZipFile(results) as archive:
        numbers: dict[str, float] = json.loads(archive.read("stats.json"))
    return numbers


@pytest.fixture(params=["made", "freiburg1_desk", "freiburg2_desk"])
def files(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[Path, Path]:
    """Ground truth and estimate."""
    if request.param != "made":
        real_data = request.getfixturevalue("real_data")
        return (
            real_data / f"groundtruth/rgbd_dataset_{request.param}-groundtruth.txt",
            real_data / f"estimates/{request.param}-rgbdslam.txt",
        )
    for name, trajectory in (("true.txt", walk(400)), ("estimate.txt", drifted(walk(400)))):
        (tmp_path / name).write_text(aligned_trajectory(trajectory))
    return tmp_path / "true.txt", tmp_path / "estimate.txt"


@pytest.mark.parametrize(("mode", "arguments"), [("se3", ["-a"]), ("sim3", ["-as"]), ("none", [])])
def test_absolute_error(mode: str, arguments: list[str], files: tuple[Path, Path], tmp_path: Path) -> None:
    theirs = evo(tmp_path, "evo_ape", *files, *arguments, "--t_max_diff", "0.02")
    true, estimate = map(load, files)
    ours = evaluate_ate(true, estimate, alignment=mode, method="nearest", max_difference=20_000_000)
    for name in PRINTED:
        assert getattr(ours.statistics, name) == pytest.approx(theirs[name], rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("distance", [1, 10, 100])
def test_relative_error_at_a_distance_in_frames(
    distance: int, files: tuple[Path, Path], tmp_path: Path
) -> None:
    """RMSE(D) of all pairs is evo's RMSE for the delta D; both take the paper's equation 1."""
    arguments = ["--delta", str(distance), "--delta_unit", "f", "--all_pairs", "--t_max_diff", "0.02"]
    theirs = evo(tmp_path, "evo_rpe", *files, *arguments)
    true, estimate = (clean(load(path), "", rotations=True).trajectory for path in files)
    found = match(true, estimate, method="nearest", max_difference=20_000_000)
    ours = translational_rmse(found.groundtruth, found.estimate)[distance - 1]
    assert ours == pytest.approx(theirs["rmse"], rel=1e-6)
