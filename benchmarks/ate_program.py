# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""ATE as a program, start-up included: `tumtools evaluate ate` against `evo_ape`, alternating.

The trajectories have the size of fr2/xyz: 36 820 rows of ground truth, 3 600 frames. evo is found on
the PATH or in the folder that TUMTOOLS_EVO names.
With tumtools installed: `python benchmarks/ate_program.py`.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from tumtools.evaluate.geometry import normalised
from tumtools.model.time import format_stamp

ROWS, FRAMES, RUNS = 36_820, 3_600, 7


def make(n: int, duration: float, noise: float) -> str:
    """Make a trajectory file with four decimals, as the published ones."""
    random = np.random.default_rng(n)
    t = np.linspace(0.0, duration, n)
    positions = np.stack([np.sin(0.3 * t), np.cos(0.2 * t), 0.3 * np.sin(0.7 * t)], axis=1)
    half = np.stack([0.2 * np.sin(0.5 * t), 0.2 * np.cos(0.3 * t), 0.1 * np.sin(t)], axis=1)
    quaternions = normalised(np.concatenate([half, np.ones((n, 1))], axis=1))
    stamps = 1_311_867_170_000_000_000 + np.rint(t * 1e4).astype(np.int64) * 100_000
    positions += random.normal(0.0, noise, (n, 3))
    numbers = np.concatenate([positions, quaternions], axis=1).tolist()
    rows = (" ".join(f"{value:.4f}" for value in row) for row in numbers)
    times = (format_stamp(stamp, 4) for stamp in stamps.tolist())
    return "".join(f"{stamp} {row}\n" for stamp, row in zip(times, rows, strict=True))


def seconds(command: list[str], home: str) -> float:
    """Run a program and return how long it took."""
    start = time.perf_counter()
    subprocess.run(command, check=True, capture_output=True, env=os.environ | {"HOME": home})
    return time.perf_counter() - start


def main() -> None:
    """Print medians and their ratio."""
    evo = shutil.which("evo_ape", path=os.environ.get("TUMTOOLS_EVO"))
    if evo is None:
        sys.exit("evo_ape is not installed (TUMTOOLS_EVO names its folder)")
    with tempfile.TemporaryDirectory() as folder:
        true, estimate = Path(folder, "true.txt"), Path(folder, "estimate.txt")
        true.write_text(make(ROWS, 121.5, 0.0))
        estimate.write_text(make(FRAMES, 121.5, 0.01))
        ours = [sys.executable, "-m", "tumtools", "evaluate", "ate", str(true), str(estimate)]
        theirs = [evo, "tum", str(true), str(estimate), "-a", "--t_max_diff", "0.02"]
        times = [(seconds(ours, folder), seconds(theirs, folder)) for _ in range(RUNS + 1)][1:]
    mine, other = np.median(times, axis=0)
    print(f"tumtools {mine:.3f} s   evo_ape {other:.3f} s   ratio {other / mine:.2f} (at least 1.5)")


if __name__ == "__main__":
    main()
