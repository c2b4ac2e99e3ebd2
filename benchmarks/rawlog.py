# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Frames per second of tum -> rawlog and of reading a rawlog, full-size real images, in one run.

    python benchmarks/rawlog.py [--frames 720] [--jobs 2]

The 90 real frames of `$TUMTOOLS_REAL_DATA` are repeated under later stamps on a memory file system. A
frame is a pair of colour and depth. MRPT's own converter does 41 frames/s on two cores (and ruins the depth).
"""

from __future__ import annotations

import argparse
import os
import resource
import shutil
import tempfile
import time
from collections import deque
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from tumtools.convert import ConvertOptions, convert
from tumtools.formats.options import WriteOptions, no_progress
from tumtools.formats.rawlog import writer
from tumtools.images.codec import pixels_of
from tumtools.images.parallel import ordered_map
from tumtools.sources import open_source

if TYPE_CHECKING:
    from collections.abc import Callable

    from tumtools.model.sequence import Frame

REAL = Path(os.environ.get("TUMTOOLS_REAL_DATA", Path(__file__).parents[2] / "shared" / "data"))


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


def timed(what: str, frames: int, work: Callable[[], object]) -> float:
    """Print frames per second by the clock, and what the CPU time would give on two idle cores."""
    begin, cpu = time.perf_counter(), time.process_time()
    work()
    seconds, cpu = time.perf_counter() - begin, time.process_time() - cpu
    idle = f"{2 * frames / cpu:6.0f} on 2 idle cores" if cpu > 0.01 * seconds else ""
    print(f"{what:34} {frames / seconds:6.0f} frames/s  {idle}")
    return seconds


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--frames", type=int, default=720)
    parser.add_argument("--jobs", type=int, default=2)
    arguments = parser.parse_args()
    frames, jobs = arguments.frames, arguments.jobs
    options = {dialect: WriteOptions(dialect=dialect, jobs=jobs) for dialect in ("modern", "legacy")}
    modern, quick = options["modern"], ConvertOptions(verify=False)
    with tempfile.TemporaryDirectory(dir="/dev/shm" if Path("/dev/shm").is_dir() else None) as name:  # noqa: S108 - a memory file system
        folder = Path(name)
        repeat(REAL / "rgbd_dataset_freiburg1_rpy", folder / "tum", frames)
        shutil.copytree(folder / "tum", folder / "warm")
        copying = timed(
            "copy of the files", frames, partial(shutil.copytree, folder / "tum", folder / "copy")
        )
        with open_source(folder / "tum") as source:
            for dialect, chosen in options.items():
                target = folder / dialect
                timed(f"write {dialect}", frames, partial(writer.write, source, target, chosen, no_progress))
            work = partial(convert, source, folder / "a", "rawlog", modern, quick)
            spent = timed("convert --no-verify", frames, work)
            timed("convert", frames, partial(convert, source, folder / "b", "rawlog", modern))
        for dialect in options:
            path = folder / dialect
            timed(f"open {dialect}", frames, partial(read, path, jobs, None))
            timed(f"read {dialect}, depth decoded", frames, partial(read, path, jobs, ("depth",)))
            timed(f"read {dialect}, all decoded", frames, partial(read, path, jobs, ("rgb", "depth")))
        print(f"convert --no-verify takes {spent / copying:.1f} x the time of the copy")
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"peak memory {peak:.0f} MB; {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}")


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
