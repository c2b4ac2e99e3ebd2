# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What `--verify` and `--digest` cost, against reading the result once.

Run from the checkout: `python benchmarks/verify.py`. Everything runs in one process, by turns; processor
times of all threads are compared within each of `--runs`, and the medians are shown. To read the result is
to fetch each image from it and to look at each byte; nothing is decoded. "Decode" is `tumtools digest`.
`TUMTOOLS_REAL_DATA` names the folder of the data (default `../shared/data`); without it a synthetic
sequence is taken.
"""

from __future__ import annotations

import argparse
import os
import shutil
import statistics
import sys
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from isal import isal_zlib  # noqa: E402 - after the path

from tumtools.convert import ConvertOptions, convert  # noqa: E402 - after the path
from tumtools.digest import digest  # noqa: E402 - after the path
from tumtools.formats.options import WriteOptions  # noqa: E402 - after the path
from tumtools.formats.registry import FORMATS  # noqa: E402 - after the path
from tumtools.images.parallel import ordered_map  # noqa: E402 - after the path
from tumtools.sources import open_source  # noqa: E402 - after the path
from tumtools.synthetic import synthesize  # noqa: E402 - after the path

if TYPE_CHECKING:
    from collections.abc import Callable

    from tumtools.model.sequence import Frame

SEQUENCE = Path(os.environ.get("TUMTOOLS_REAL_DATA", ROOT / "../shared/data")) / "rgbd_dataset_freiburg1_rpy"
CASES: tuple[tuple[str, dict[str, object]], ...] = (
    ("tum", {}),
    ("mcap", {"archive": True}),
    ("mcap", {}),
    ("rosbag1", {}),
    ("rosbag2", {"archive": True}),
    ("rawlog", {}),
)


def processor_time(work: Callable[[], object]) -> float:
    start = time.process_time()
    work()
    return time.process_time() - start


def read(path: Path) -> None:
    """Load everything that is in a file, and look at each byte once."""

    def load(frame: Frame) -> int:
        image = frame.load()
        data = image.compressed if image.compressed is not None else image.pixels
        return int(isal_zlib.crc32(data))

    with open_source(path) as sequence:
        for _ in ordered_map(load, sequence.images(), 2):
            pass


def decode(path: Path) -> None:
    """Decode everything that is in a file, and hash it."""
    with open_source(path) as sequence:
        digest(sequence, jobs=2)


def remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def measure(
    source: Path, target: Path, to: str, options: dict[str, object], runs: int
) -> dict[str, list[float]]:
    """Return the processor times of each way."""

    def write(*, verify: bool, digest: bool | None = False) -> None:
        remove(target)
        with open_source(source) as sequence:
            how = ConvertOptions(verify=verify, digest=digest)
            convert(sequence, target, to, WriteOptions(**options), how)  # type: ignore[arg-type]  # as named

    ways: dict[str, Callable[[], object]] = {
        "plain": lambda: write(verify=False),
        "verify": lambda: write(verify=True),
        "read": lambda: read(target),
        "decode": lambda: decode(target),
    }
    if FORMATS[to].writer.needs(WriteOptions(**options)).keeps_digest:  # type: ignore[arg-type]  # as named
        ways["digest"] = lambda: write(verify=False, digest=True)
    found: dict[str, list[float]] = {name: [] for name in ways}
    for _ in range(runs):
        for name, way in ways.items():
            found[name].append(processor_time(way))
    remove(target)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=5)
    arguments = parser.parse_args()
    memory = Path("/dev/shm")  # noqa: S108 - a folder of our own is made in it
    with tempfile.TemporaryDirectory(dir=memory if memory.is_dir() else None) as name:
        folder = Path(name)
        if SEQUENCE.is_dir():
            shutil.copytree(SEQUENCE, folder / "source")
        else:
            convert(synthesize(30), folder / "source", "tum")
        print("to                       convert  + verify      read    decode   verify/read  + digest")
        for to, options in CASES:
            label = " ".join([to, *(f"--{option}" for option in options)])
            found = measure(folder / "source", folder / "target", to, options, arguments.runs)
            pairs = zip(found["verify"], found["plain"], strict=True)
            extra = statistics.median(more - less for more, less in pairs)
            plain, once, decoded = (statistics.median(found[name]) for name in ("plain", "read", "decode"))
            digests = zip(found.get("digest", ()), found["plain"], strict=False)
            shares = [more / less - 1 for more, less in digests]
            shown = format(statistics.median(shares), "+.0%") if shares else "-"
            times = "".join(f"{seconds * 1e3:7.0f} ms" for seconds in (plain, extra, once, decoded))
            print(f"{label:22}{times} {extra / once:11.2f} x {shown:>9}")


if __name__ == "__main__":
    main()
