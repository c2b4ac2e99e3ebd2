# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Measure batches: scaling with workers, overhead of small tasks, and large plans.

Usage: python benchmarks/batch.py [scaling] [overhead] [plan]
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
ENVIRONMENT = os.environ | {"PYTHONPATH": str(ROOT)}
TARGET = '[[target]]\nto = "{to}"\n'


class Cost(NamedTuple):
    """Seconds on the clock and of processors, and MiB at most, of a program and its children."""

    seconds: float
    processor: float
    memory: float

    def __str__(self) -> str:
        return f"{self.seconds:.1f} s ({self.processor:.1f} s of processors, {self.memory:.0f} MiB at most)"


def tumtools(*words: str, folder: Path) -> Cost:
    """Run the program; return what it took."""
    start = time.perf_counter()
    process = subprocess.Popen([sys.executable, "-m", "tumtools", "-q", *words], cwd=folder, env=ENVIRONMENT,
                               stdout=subprocess.DEVNULL)  # fmt: skip
    _, code, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(code)
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, words)
    return Cost(time.perf_counter() - start, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024)


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
        seconds = tumtools("batch", "run", "p.json", "--workers", str(workers), folder=folder).seconds
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
        print(f"{tasks} small tasks, {what}: {tumtools('batch', *words, folder=folder)}")


def plan(folder: Path, sources: int = 25_000) -> None:
    """Print time and memory of a plan with 100 000 tasks, with the manifest's defaults and by size only."""
    (folder / "data").mkdir()
    tumtools("synth", "one", "--frames", "4", folder=folder)
    tumtools("convert", "one", "one.mcap", "--to", "mcap", folder=folder)
    for number in range(sources):
        (folder / "data" / f"{number}.mcap").hardlink_to(folder / "one.mcap")
    targets = "".join(TARGET.format(to=to) for to in ("mcap", "rosbag1", "rawlog", "tum"))
    for head in ('estimate = "size"', ""):
        manifest(folder, "data/*.mcap", targets, head)
        cost = tumtools("batch", "plan", "m.toml", "-o", "p.json", folder=folder)
        size = (folder / "p.json").stat().st_size / 1e6
        print(f"plan with {4 * sources} tasks, {head or 'default'}: {cost}, {size:.0f} MB on disk")


def main() -> None:
    measurements = {"plan": plan, "overhead": overhead, "scaling": scaling}
    for name in sys.argv[1:] or measurements:
        with tempfile.TemporaryDirectory() as folder:
            measurements[name](Path(folder))


if __name__ == "__main__":
    main()
