# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Bags against what users write today: the two peer scripts (OpenCV and rosbags) and rosbags-convert.

Run from the checkout: `python benchmarks/rosbags.py`. Each way is a program of its own, start-up included;
times are the best of `--runs`, and what counts are the ratios. Files are on a memory file system. The real
sequence has 90 pairs of images; `--repeat` makes it longer, as most are.

`TUMTOOLS_REAL_DATA` and `TUMTOOLS_PEERS` name the folders of the data and of the scripts (default
`../shared/data`, `../shared/peers`), `TUMTOOLS_PEER_PYTHON` a Python that has OpenCV and rosbags.
"""

from __future__ import annotations

import argparse
import os
import shutil
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from core import lengthen

ROOT = Path(__file__).parents[1]
DATA = Path(os.environ.get("TUMTOOLS_REAL_DATA", ROOT / "../shared/data")).resolve()
PEERS = Path(os.environ.get("TUMTOOLS_PEERS", ROOT / "../shared/peers")).resolve()
PEER_PYTHON = os.environ.get("TUMTOOLS_PEER_PYTHON", sys.executable)
ROSBAGS_CONVERT = (
    os.environ.get("TUMTOOLS_ROSBAGS_CONVERT")
    or shutil.which("rosbags-convert")
    or str(Path(sys.executable).with_name("rosbags-convert"))
)
SEQUENCE = DATA / "rgbd_dataset_freiburg1_rpy"


def run(arguments: list[str | Path], target: Path) -> tuple[float, float]:
    """Run a program that makes a target; return seconds and its largest memory in MB."""
    shutil.rmtree(target, ignore_errors=True)
    target.unlink(missing_ok=True)
    start = time.perf_counter()
    pid = os.posix_spawn(
        str(arguments[0]),
        list(map(str, arguments)),
        os.environ | {"PYTHONPATH": str(ROOT)},
        file_actions=[(os.POSIX_SPAWN_OPEN, stream, os.devnull, os.O_WRONLY, 0) for stream in (1, 2)],
    )
    _, status, usage = os.wait4(pid, 0)
    seconds = time.perf_counter() - start
    if os.waitstatus_to_exitcode(status):
        sys.exit(f"failed: {' '.join(map(str, arguments))}")
    return seconds, usage.ru_maxrss / 1024


def best(arguments: list[str | Path], target: Path, runs: int) -> tuple[float, float]:
    """Return the shortest time and the largest memory of several runs."""
    results = [run(arguments, target) for _ in range(runs)]
    return min(seconds for seconds, _ in results), max(memory for _, memory in results)


def convert(source: Path, target: Path, to: str, *options: str) -> list[str | Path]:
    """Return the command line of our conversion."""
    return [sys.executable, "-m", "tumtools", "convert", source, target, "--to", to, *options]


def image_bytes(folder: Path) -> int:
    """Return the size of all images of a sequence."""
    return sum(file.stat().st_size for file in folder.rglob("*.png"))


def compare(
    title: str, ours: list[str | Path], theirs: list[str | Path], targets: tuple[Path, Path], runs: int
) -> None:
    """Print one line of the table."""
    peer, peer_memory = best(theirs, targets[1], runs)
    quick, memory = best([*ours, "--no-verify"], targets[0], runs)
    checked, _ = best(ours, targets[0], runs)
    times = f"{quick:7.2f} s {checked:8.2f} s {peer:7.2f} s"
    ratios = f"{peer / quick:7.1f} x {peer / checked:7.1f} x"
    print(f"{title:28} {times} {ratios} {memory:7.0f} MB {peer_memory:6.0f} MB")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--repeat", type=int, default=1, help="how many times as long the sequence is")
    parser.add_argument("--folder", type=Path, default=Path("/dev/shm"), help="where files go")  # noqa: S108 - a memory file system
    options = parser.parse_args()
    runs = options.runs
    with tempfile.TemporaryDirectory(dir=options.folder) as name:
        work = Path(name)
        sequence = work / SEQUENCE.name
        lengthen(SEQUENCE, sequence, options.repeat)
        columns = ("ours", "verified", "peer", "ratio", "verified", "memory", "peer")
        print(" " * 28 + "".join(f"{column:>10}" for column in columns))
        bags = work / "ours.bag", work / "theirs.bag"
        peer: list[str | Path] = [PEER_PYTHON, PEERS / "tum_to_bag_naive.py", sequence, bags[1]]
        compare("tum -> rosbag1 raw", convert(sequence, bags[0], "rosbag1"), peer, bags, runs)
        folders = work / "ours", work / "theirs"
        peer = [PEER_PYTHON, PEERS / "bag_to_tum_naive.py", bags[0], folders[1]]
        compare("rosbag1 raw -> tum", convert(bags[0], folders[0], "tum"), peer, folders, runs)
        sizes = [image_bytes(folder) for folder in (*folders, sequence)]
        of_peer, of_source = sizes[0] / sizes[1], sizes[0] / sizes[2]
        print(f"  images: {of_peer:.3f} of the peer's bytes, {of_source:.3f} of the source's")
        recordings = work / "ours.mcap", work / "theirs_mcap"
        peer = [ROSBAGS_CONVERT, "--src", bags[0], "--dst", recordings[1], "--dst-storage", "mcap"]
        ours = convert(bags[0], recordings[0], "mcap", "--color-encoding", "rgb8", "--compression", "none")
        compare("rosbag1 raw -> mcap raw", ours, peer, recordings, runs)
        for compression in ("bz2", "lz4"):
            target = work / f"{compression}.bag"
            seconds, memory = best(
                [*convert(sequence, target, "rosbag1", "--compression", compression), "--no-verify"],
                target,
                1,
            )
            back, back_memory = best([*convert(target, folders[0], "tum"), "--no-verify"], folders[0], 1)
            print(
                f"tum -> rosbag1 {compression}: {seconds:.2f} s, {memory:.0f} MB; "
                f"back: {back:.2f} s, {back_memory:.0f} MB; {target.stat().st_size / 2**20:.0f} MiB"
            )


if __name__ == "__main__":
    main()
