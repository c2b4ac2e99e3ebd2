# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`validate --full` against Pillow decoding every image, `--quick` on 10 000 files, memory over the length.

`python benchmarks/validate.py [SEQUENCE]`; a synthetic sequence is made where none is named. Times are the
best of several runs in one process; what counts are the ratios.
"""

from __future__ import annotations

import io
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from PIL import Image

from tumtools.convert import ConvertOptions, convert
from tumtools.formats.options import WriteOptions
from tumtools.synthetic import synthesize
from tumtools.validate.engine import validate

if TYPE_CHECKING:
    from collections.abc import Callable

JOBS = 2
RUNS = 5
QUICK_FILES = 10_000
LENGTHS = (1, 10)
"""How often the images are listed, for the memory."""


def best(function: Callable[[], object]) -> float:
    """Return the shortest time of several runs, seconds."""
    times = []
    for _ in range(RUNS):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return min(times)


def decode_all(folder: Path) -> None:
    """Decode every image with Pillow, one after the other."""
    for path in sorted(folder.glob("*/*.png")):
        np.asarray(Image.open(io.BytesIO(path.read_bytes())))


def repeat(folder: Path, target: Path, times: int, streams: tuple[str, ...] = ("rgb", "depth")) -> None:
    """Make a sequence in which the images come several times, as links, a minute apart."""
    for stream in streams:
        (target / stream).mkdir(parents=True)
        lines = []
        for number in range(times):
            for path in sorted((folder / stream).iterdir()):
                whole, part = path.stem.split(".")
                name = f"{int(whole) + 60 * number}.{part}"
                (target / stream / f"{name}.png").symlink_to(path.resolve())
                lines.append(f"{name} {stream}/{name}.png\n")
        (target / f"{stream}.txt").write_text("".join(lines))


def peak_of(folder: Path) -> float:
    """Return the peak memory of validating a folder in a process of its own, MB."""
    # Not ru_maxrss, which begins with the memory of the process that started this one.
    code = (
        "import re, sys; from tumtools.validate.engine import validate; validate(sys.argv[1]);"
        "print(int(re.search(r'VmHWM:\\s*(\\d+)', open('/proc/self/status').read())[1]) / 1e3)"
    )
    return float(subprocess.check_output([sys.executable, "-c", code, folder], text=True))


def main() -> None:
    """Print the figures."""
    with tempfile.TemporaryDirectory() as scratch:
        if len(sys.argv) > 1:
            folder = Path(sys.argv[1])
        else:
            folder = Path(scratch, "synthetic")
            convert(synthesize(60), folder, "tum", WriteOptions(), ConvertOptions(verify=False))
        pillow, full = best(lambda: decode_all(folder)), best(lambda: validate(folder, jobs=JOBS))
        print(f"full: {full:.3f} s with {JOBS} threads, {pillow / full:.2f} x as fast as Pillow with one")
        images = len(list(folder.glob("*/*.png")))
        many = Path(scratch, "many")
        repeat(folder, many, -(-QUICK_FILES // images))
        count = len(list(many.glob("*/*.png")))
        print(f"quick: {best(lambda: validate(many, full=False)):.2f} s for {count} files")
        for times in LENGTHS:
            long = Path(scratch, f"long{times}")
            repeat(folder, long, times)
            print(f"peak memory over {times * images} images: {peak_of(long):.0f} MB")
            shutil.rmtree(long)


if __name__ == "__main__":
    main()
