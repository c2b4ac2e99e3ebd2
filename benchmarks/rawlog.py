# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Frames per second of tum -> rawlog and of reading a rawlog, full-size real images, in one run.

    python benchmarks/rawlog.py [--frames 720] [--jobs 2] [--runs 3] [--converter PROGRAM]

The 90 real frames of `$TUMTOOLS_REAL_DATA` are repeated under later stamps on a memory file system. A
frame is a pair of colour and depth. Each figure is the best of all runs; converting is with verification
unless it says otherwise.

PROGRAM is MRPT's own converter, `rgbd_dataset2rawlog`, which ruins the depth. The budget is 400 frames/s on
the machine where that program ran at 41; with it, the budget is that for the machine at hand. Debian has
its source in `mrpt-doc` (`/usr/share/doc/mrpt-doc/samples`), to be built with `libmrpt-dev` and cmake. Whole
programs are run by turns with it, since a machine may change its speed.
"""

from __future__ import annotations

import argparse
import os
import resource
import shutil
import sys
import tempfile
import time
from collections import deque
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Final

sys.path.insert(0, str(Path(__file__).parent))

from timing import TUMTOOLS, Job, print_ratio, print_results, run_by_turns

from tumtools.convert import ConvertOptions, convert
from tumtools.formats.options import WriteOptions
from tumtools.images.codec import pixels_of
from tumtools.images.parallel import ordered_map
from tumtools.sources import open_source

if TYPE_CHECKING:
    from collections.abc import Callable

    from tumtools.model.sequence import Frame

REAL = Path(os.environ.get("TUMTOOLS_REAL_DATA", Path(__file__).parents[2] / "shared" / "data"))
CORES: Final = 2
BUDGET, CONVERTER_RATE = 400, 41
"""Frames per second that a conversion should do on so many cores, where MRPT's converter does that."""
CONVERTER_BUDGET: Final = 10.0
"""How many times as fast as MRPT's converter a conversion should be."""


def repeat(source: Path, target: Path, frames: int) -> None:
    """Write a folder with the images of another one again and again, later each time."""
    for stream in ("rgb", "depth"):
        (target / stream).mkdir(parents=True)
        rows = [
            line.split() for line in (source / f"{stream}.txt").read_text().splitlines() if line[0] != "#"
        ]
        lines = []
        for number in range(frames):
            stamp, name = rows[number % len(rows)]
            seconds, part = stamp.split(".")
            later = f"{int(seconds) + 5 * (number // len(rows))}.{part}"
            shutil.copyfile(source / name, target / stream / f"{later}.png")
            lines.append(f"{later} {stream}/{later}.png\n")
        (target / f"{stream}.txt").write_text("".join(lines))
    for name in ("accelerometer.txt", "groundtruth.txt"):
        shutil.copyfile(source / name, target / name)


@dataclass(frozen=True)
class Rate:
    """Frames per second: by the clock, and what the processor time would give on two idle cores."""

    clock: float
    idle: float


def timed(what: str, frames: int, runs: int, work: Callable[[], object], target: Path | None = None) -> Rate:
    """Run some work so many times, its target removed before each; print and return the best."""
    best = Rate(0, 0)
    for _ in range(runs):
        if target is not None:
            shutil.rmtree(target, ignore_errors=True)
        begin, cpu = time.perf_counter(), time.process_time()
        work()
        seconds, cpu = time.perf_counter() - begin, time.process_time() - cpu
        best = Rate(max(best.clock, frames / seconds), max(best.idle, CORES * frames / cpu))
    print(f"{what:34} {best.clock:6.0f} frames/s  {best.idle:6.0f} on {CORES} idle cores")
    return best


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--frames", type=int, default=720)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--converter", type=Path)
    arguments = parser.parse_args()
    frames, jobs = arguments.frames, arguments.jobs
    time_it = partial(timed, frames=frames, runs=arguments.runs)
    unverified = ConvertOptions(verify=False)
    rates = {}
    with tempfile.TemporaryDirectory(dir="/dev/shm" if Path("/dev/shm").is_dir() else None) as name:  # noqa: S108 - a memory file system
        folder = Path(name)
        tum, copy = folder / "tum", folder / "copy"
        repeat(REAL / "rgbd_dataset_freiburg1_rpy", tum, frames)
        time_it("copy of the files", work=partial(shutil.copytree, tum, copy), target=copy)
        with open_source(tum) as source:
            for dialect in ("modern", "legacy"):
                target, options = folder / dialect, WriteOptions(dialect=dialect, jobs=jobs)
                for what, chosen in (
                    (f"convert {dialect}, no verify", unverified),
                    (f"convert {dialect}", None),
                ):
                    work = partial(convert, source, target, "rawlog", options, chosen)
                    rates[what] = time_it(what, work=work, target=target)
        for dialect in ("modern", "legacy"):
            path = folder / dialect
            time_it(f"open {dialect}", work=partial(read, path, jobs, None))
            time_it(f"read {dialect}, depth decoded", work=partial(read, path, jobs, ("depth",)))
            time_it(f"read {dialect}, all decoded", work=partial(read, path, jobs, ("rgb", "depth")))
        budget = float(BUDGET)
        if arguments.converter:
            seconds = against_converter(arguments.converter, tum, folder, jobs, arguments.runs)
            budget *= frames / seconds / CONVERTER_RATE
            print(f"MRPT's converter: {frames / seconds:.1f} frames/s here")
    for what, rate in rates.items():
        print_ratio(f"{what}, by the clock", rate.clock, budget, at_least=True, unit="/s")
        print_ratio(f"{what}, on idle cores", rate.idle, budget, at_least=True, unit="/s")
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"peak memory {peak:.0f} MB; {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}")


def against_converter(program: Path, tum: Path, folder: Path, jobs: int, runs: int) -> float:
    """Run MRPT's converter and whole conversions by turns, and print how many times as fast these are.

    Returns:
        Seconds that MRPT's converter takes, the best of all runs.

    """
    target = folder / "target"

    def remove() -> None:
        for path in folder.glob(f"{target.name}*"):
            shutil.rmtree(path) if path.is_dir() else path.unlink()

    convert_it = (*TUMTOOLS, "convert", tum, target, "--to", "rawlog", "--jobs", str(jobs))
    theirs = "MRPT's converter"
    programs = {
        theirs: Job((program, tum, target), remove),
        "tum -> rawlog": Job(convert_it, remove),
        "  without verification": Job((*convert_it, "--no-verify"), remove),
        "  nor a digest": Job((*convert_it, "--no-verify", "--no-digest"), remove),
    }
    results = run_by_turns(programs, runs)
    print_results(results)
    for name in list(programs)[1:]:
        ratios = [
            one / other for one, other in zip(results[theirs].seconds, results[name].seconds, strict=True)
        ]
        what = f"{theirs} / {name.strip()}, median of pairs"
        print_ratio(what, median(ratios), CONVERTER_BUDGET, at_least=True)
    return min(results[theirs].seconds)


def read(path: Path, jobs: int, decoded: tuple[str, ...] | None) -> None:
    """Load every image and decode those of some streams; with None only open the sequence."""

    def use(frame: Frame) -> int:
        image = frame.load()
        return pixels_of(image).nbytes if decoded and frame.stream in decoded else image.nbytes

    with open_source(path) as sequence:
        if decoded is not None:
            deque(ordered_map(use, sequence.images(), jobs), maxlen=0)


if __name__ == "__main__":
    main()
