# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Measure batches: scaling with workers, overhead of small tasks, and large plans.

Usage: python benchmarks/batch.py [scaling] [overhead] [plan]
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parents[1]
ENVIRONMENT = os.environ | {"PYTHONPATH": str(ROOT)}
TARGET = '[[target]]\nto = "{to}"\n'


def tumtools(*words: str, folder: Path) -> float:
    """Run the program; return the seconds it took."""
    start = time.perf_counter()
    subprocess.run([sys.executable, "-m", "tumtools", "-q", *words], cwd=folder, env=ENVIRONMENT, check=True,
                   stdout=subprocess.DEVNULL)  # fmt: skip
    return time.perf_counter() - start


def manifest(folder: Path, source: str, targets: str, head: str = "") -> None:
    (folder / "m.toml").write_text(f'destination = "out"\n{head}\n[[source]]\npath = "{source}"\n{targets}')


def scaling(folder: Path, sources: int = 8) -> None:
    """Print tasks per minute with one and two workers, on synthetic sequences of 640x480."""
    tumtools("synth", "data/0", "--frames", "40", folder=folder)
    for number in range(1, sources):
        (folder / "data" / str(number)).symlink_to(folder / "data" / "0")
    rates = {}
    for workers in (1, 2, 1, 2):
        manifest(folder, "data/*", TARGET.format(to="mcap"))
        (folder / "m.toml").write_text(
            (folder / "m.toml").read_text().replace('"out"', f'"out{time.time()}"')
        )
        tumtools("batch", "plan", "m.toml", "-o", "p.json", folder=folder)
        seconds = tumtools("batch", "run", "p.json", "--workers", str(workers), folder=folder)
        rates[workers] = max(rates.get(workers, 0.0), 60 * sources / seconds)
    print(
        f"scaling: {rates[1]:.0f} tasks/min with 1 worker, {rates[2]:.0f} with 2: {rates[2] / rates[1]:.2f} x"
    )


def overhead(folder: Path, tasks: int = 1000) -> None:
    """Print how long a thousand tasks take that have next to nothing to convert."""
    (folder / "data").mkdir()
    for number in range(tasks):
        (folder / "data" / f"{number}.txt").write_text("1305031102.1758 1 2 3 0 0 0 1\n")
    manifest(folder, "data/*.txt", TARGET.format(to="mcap"), 'template = "{name}.mcap"')
    for what, words in (
        ("plan", ("plan", "m.toml", "-o", "p.json")),
        ("run", ("run", "p.json", "--workers", "2")),
        ("run again", ("run", "p.json", "--workers", "2")),
        ("status", ("status", "p.json")),
    ):
        print(f"{tasks} small tasks, {what}: {tumtools('batch', *words, folder=folder):.1f} s")


def plan(folder: Path, sources: int = 25_000) -> None:
    """Print time and memory of a plan with 100 000 tasks; its sources are looked at by size only."""
    (folder / "data").mkdir()
    for number in range(sources):
        (folder / "data" / f"{number}.mcap").write_bytes(b"x")
    targets = "".join(TARGET.format(to=to) for to in ("mcap", "rosbag1", "rawlog", "tum"))
    manifest(folder, "data/*.mcap", targets, 'estimate = "size"')
    seconds = tumtools("batch", "plan", "m.toml", "-o", "p.json", folder=folder)
    memory = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
    size = (folder / "p.json").stat().st_size / 1e6
    print(f"plan with {4 * sources} tasks: {seconds:.1f} s, {memory:.0f} MiB at most, {size:.0f} MB on disk")


def main() -> None:
    measurements = {"plan": plan, "overhead": overhead, "scaling": scaling}
    for name in sys.argv[1:] or measurements:
        with tempfile.TemporaryDirectory() as folder:
            measurements[name](Path(folder))


if __name__ == "__main__":
    main()
