# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Trajectories to measure: real ones and made ones."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np
import pytest

from tumtools.formats.tum.text import parse
from tumtools.model.signals import Trajectory

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path
    from typing import Any


def load(path: Path) -> Trajectory:
    table = parse(path.read_bytes(), "groundtruth", str(path))
    return Trajectory(table.stamps, table.values[:, :3], table.values[:, 3:])


@pytest.fixture(scope="session")
def groundtruth(real_data: Path) -> Callable[[str], Trajectory]:
    return lambda name: load(real_data / f"groundtruth/rgbd_dataset_{name}-groundtruth.txt")


@pytest.fixture(scope="session")
def estimate(real_data: Path) -> Callable[[str], Trajectory]:
    return lambda name: load(real_data / f"estimates/{name}.txt")


@pytest.fixture(scope="session")
def reference(real_data: Path) -> dict[str, Any]:
    """What the benchmark's own scripts print for these."""
    numbers: dict[str, Any] = json.loads((real_data / "reference/evaluation_detail.json").read_text())
    return numbers


def walk(
    n: int, seed: int = 0, step: float = 0.02, start: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> Trajectory:
    """A random walk of a camera at 100 Hz: steps in metres, turns of about two degrees."""
    random = np.random.default_rng(seed)
    positions = np.cumsum(random.normal(0.0, step, (n, 3)), axis=0) + np.array(start)
    quaternion, quaternions = np.array([0.0, 0.0, 0.0, 1.0]), []
    for turn in random.normal(0.0, 0.02, (n, 3)):
        x, y, z, w = quaternion
        matrix = np.array([[w, -z, y, x], [z, w, -x, y], [-y, x, w, z], [-x, -y, -z, w]])
        quaternion = matrix @ np.array([*turn, 1.0])
        quaternion /= np.linalg.norm(quaternion)
        quaternions.append(quaternion)
    stamps = 1_305_031_102_000_000_000 + np.arange(n) * 10_000_000
    return Trajectory(stamps, positions, np.array(quaternions))


def drifted(trajectory: Trajectory, seed: int = 1, drift: float = 0.001) -> Trajectory:
    """The same as an estimate would have it: positions and rotations drift, each frame jitters."""
    random = np.random.default_rng(seed)
    n = len(trajectory)
    positions = (
        trajectory.positions
        + np.cumsum(random.normal(0.0, drift, (n, 3)), axis=0)
        + random.normal(0.0, drift, (n, 3))
    )
    quaternions = trajectory.quaternions + np.cumsum(random.normal(0.0, drift / 4, (n, 4)), axis=0)
    return Trajectory(trajectory.stamps, positions, quaternions)
