# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What the benchmarks share: programs run by turns, their times and peak memory, ratios against a budget."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from dataclasses import dataclass, field
from statistics import median
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

TUMTOOLS = (sys.executable, "-m", "tumtools")


@dataclass(frozen=True)
class Job:
    """A program to run.

    Attributes:
        command: What to run.
        before: Called before each run, not timed (removes the last result).

    """

    command: Sequence[str | Path]
    before: Callable[[], None] = lambda: None


@dataclass
class Result:
    """Runs of one job.

    Attributes:
        seconds: Wall time of each run.
        cpu: User and system time of each run, children included.
        peak: Largest resident memory of a run, in bytes.

    """

    seconds: list[float] = field(default_factory=list)
    cpu: list[float] = field(default_factory=list)
    peak: int = 0

    @property
    def best(self) -> float:
        """The shortest wall time: what other programs on the machine disturbed least."""
        return min(self.seconds)


def run_by_turns(jobs: dict[str, Job], rounds: int) -> dict[str, Result]:
    """Run each job so many times and once before that, by turns: a busy machine slows all of them."""
    results = {name: Result() for name in jobs}
    for turn in range(rounds + 1):
        for name, job in jobs.items():
            job.before()
            seconds, cpu, peak = _run(job.command)
            if turn:
                results[name].seconds.append(seconds)
                results[name].cpu.append(cpu)
            results[name].peak = max(results[name].peak, peak)
    return results


def _run(command: Sequence[str | Path]) -> tuple[float, float, int]:
    start = time.perf_counter()
    process = subprocess.Popen(
        [str(word) for word in command], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    )
    _, status, usage = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - start
    process.returncode = os.waitstatus_to_exitcode(status)
    message = process.stderr.read() if process.stderr else b""
    if process.stderr:
        process.stderr.close()
    if process.returncode:
        sys.exit(f"{command} ended with {process.returncode}: {message.decode()}")
    return seconds, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024


def print_results(results: dict[str, Result]) -> None:
    print(f"{'':44}{'best s':>9}{'median s':>10}{'CPU s':>8}{'peak MB':>9}")
    for name, result in results.items():
        print(
            f"{name:44}{result.best:9.3f}{median(result.seconds):10.3f}{min(result.cpu):8.3f}"
            f"{result.peak / 1e6:9.0f}"
        )


def print_ratio(what: str, value: float, budget: float, *, at_least: bool = False, unit: str = "x") -> bool:
    """Print a figure beside its budget; return whether it is kept."""
    kept = value >= budget if at_least else value <= budget
    limit = "at least" if at_least else "at most"
    print(f"{what:60}{value:9.2f} {unit} ({limit} {budget:g}) {'ok' if kept else 'MISSED'}")
    return kept
