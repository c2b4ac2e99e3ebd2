# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""All-pairs RPE (equation 3, translation): FFT against vectorised brute force, and its growth with n.

With tumtools installed: `python benchmarks/all_pairs_rpe.py`. Times are the best of several runs in one
process; what counts are the ratios.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import numpy as np

from tumtools.evaluate.allpairs import rotational_rmse, translational_rmse
from tumtools.evaluate.geometry import matrices, normalised
from tumtools.model.signals import Trajectory

if TYPE_CHECKING:
    from collections.abc import Callable

BRUTE_FORCE_UP_TO = 5000
ROTATION_UP_TO = 20_000


def make(n: int) -> tuple[Trajectory, Trajectory]:
    """Make a smooth path in a room, and a drifting estimate of it."""
    random = np.random.default_rng(n)
    t = np.arange(n) / 100.0
    positions = np.stack([2.0 * np.sin(0.3 * t), 1.5 * np.cos(0.2 * t), 0.3 * np.sin(0.7 * t)], axis=1)
    half = np.stack([0.4 * np.sin(0.5 * t), 0.3 * np.cos(0.3 * t), 0.05 * t], axis=1) / 2.0
    quaternions = normalised(np.concatenate([np.sin(half), np.ones((n, 1))], axis=1))
    stamps = 1_305_031_102_000_000_000 + np.arange(n) * 10_000_000
    drift = np.cumsum(random.normal(0.0, 5e-4, (n, 3)), axis=0)
    turned = quaternions + np.cumsum(random.normal(0.0, 1e-4, (n, 4)), axis=0)
    return Trajectory(stamps, positions, quaternions), Trajectory(stamps, positions + drift, turned)


def brute_force(groundtruth: Trajectory, estimate: Trajectory) -> np.ndarray:
    """RMSE(D) distance by distance, each vectorised over all pairs; |(q_j - q_i) - M_i (p_j - p_i)|."""
    q, p = groundtruth.positions, estimate.positions
    rotations_q = matrices(normalised(groundtruth.quaternions))
    rotations_p = matrices(normalised(estimate.quaternions))
    m = rotations_q @ np.swapaxes(rotations_p, 1, 2)
    result = np.empty(len(q) - 1)
    for d in range(1, len(q)):
        error = (q[d:] - q[:-d]) - np.einsum("nij,nj->ni", m[:-d], p[d:] - p[:-d])
        result[d - 1] = np.sqrt(np.mean(np.einsum("ni,ni->n", error, error)))
    return result


def best(function: Callable[[], object], runs: int) -> float:
    """Return the shortest time of several runs, seconds."""
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return min(times)


def main() -> None:
    """Print the table."""
    print("     n   FFT ms   brute ms   ratio   relative difference   rotation, blockwise ms")
    for n in (500, 1000, 2000, 2400, 5000, 10_000, 20_000, 40_000):
        pair = make(n)
        fast = best(lambda pair=pair: translational_rmse(*pair), 5)
        line = f"{n:6d} {1e3 * fast:8.2f}"
        if n <= BRUTE_FORCE_UP_TO:
            slow = best(lambda pair=pair: brute_force(*pair), 2)
            exact = brute_force(*pair)
            difference = np.max(np.abs(translational_rmse(*pair) / exact - 1.0))
            line += f" {1e3 * slow:10.1f} {slow / fast:7.0f} {difference:21.1e}"
        else:
            line += f" {'-':>10} {'-':>7} {'-':>21}"
        rotation = 1e3 * best(lambda pair=pair: rotational_rmse(*pair), 1) if n <= ROTATION_UP_TO else None
        print(line + (f" {rotation:24.1f}" if rotation is not None else f" {'-':>24}"))


if __name__ == "__main__":
    main()
