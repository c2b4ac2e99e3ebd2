# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""TUM to MCAP and back against `cp -r`, .tgz to MCAP against `tar xzf`, peak memory, start-up of `--help`.

    python benchmarks/core.py SEQUENCE [--rounds 3] [--repeat 10] [--folder /dev/shm]

SEQUENCE is a folder in the benchmark's layout. A sequence that is so many times as long is made of it in a
temporary folder, each image again under stamps that are shifted by the length of the sequence.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tarfile
import tempfile
from functools import partial
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from timing import TUMTOOLS, Job, Result, print_ratio, print_results, run_by_turns

from tumtools.model.time import format_stamp, parse_stamp

COPY_BUDGET, TAR_BUDGET, MEMORY_BUDGET, START_BUDGET = 3.0, 1.5, 200e6, 0.120


SEQUENCE = Path(__file__).parents[2] / "shared" / "data" / "rgbd_dataset_freiburg1_rpy"


def lengthen(source: Path, target: Path, times: int) -> None:
    """Write a sequence that is `times` as long."""
    target.mkdir()
    lines = {path.name: path.read_text().splitlines() for path in source.glob("*.txt")}
    rows = {name: [line for line in text if not line.startswith("#")] for name, text in lines.items()}
    stamps = [parse_stamp(row.split()[0]) for text in rows.values() for row in text]
    length = max(stamps) - min(stamps) + 33_000_000
    length -= length % 100_000  # the ground truth has four decimals
    for name, text in rows.items():
        out = [line for line in lines[name] if line.startswith("#")]
        for turn in range(times):
            for row in text:
                first, rest = row.split(" ", 1)
                decimals = len(first.partition(".")[2])
                stamp = format_stamp(parse_stamp(first) + turn * length, decimals)
                if rest.endswith(".png"):
                    folder = rest.partition("/")[0]
                    (target / folder).mkdir(exist_ok=True)
                    shutil.copyfile(source / rest, target / folder / f"{stamp}.png")
                    rest = f"{folder}/{stamp}.png"
                out.append(f"{stamp} {rest}")
        (target / name).write_text("\n".join(out) + "\n")


def pack(source: Path, target: Path) -> None:
    """Pack a folder in the order of its names, as the published archives are."""
    with tarfile.open(target, "w:gz", compresslevel=6) as archive:
        archive.add(source, source.name)


def remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def measure(folder: Path, sequence: Path, rounds: int) -> tuple[dict[str, Result], bool]:
    archive, back, copy = folder / "x.mcap", folder / "back", folder / "copy"
    default, packed, unpacked = folder / "default.mcap", folder / "x.tgz", folder / "unpacked"
    from_tgz = folder / "tgz.mcap"
    pack(sequence, packed)

    def empty() -> None:
        remove(unpacked)
        unpacked.mkdir()

    convert = (*TUMTOOLS, "convert")
    to_mcap = ("--to", "mcap", "--archive")
    jobs = {
        "cp -r": Job(("cp", "-r", sequence, copy), partial(remove, copy)),
        "tum -> mcap --archive": Job((*convert, sequence, archive, *to_mcap), partial(remove, archive)),
        "  without verification": Job(
            (*convert, sequence, archive, *to_mcap, "--no-verify"), partial(remove, archive)
        ),
        "mcap -> tum": Job((*convert, archive, back, "--to", "tum"), partial(remove, back)),
        "  without verification (tum)": Job(
            (*convert, archive, back, "--to", "tum", "--no-verify"), partial(remove, back)
        ),
        "tum -> mcap (raw depth)": Job(
            (*convert, sequence, default, "--to", "mcap"), partial(remove, default)
        ),
        "tar xzf": Job(("tar", "xzf", packed, "-C", unpacked), empty),
        ".tgz -> mcap --archive": Job((*convert, packed, from_tgz, *to_mcap), partial(remove, from_tgz)),
        "  without verification (tgz)": Job(
            (*convert, packed, from_tgz, *to_mcap, "--no-verify"), partial(remove, from_tgz)
        ),
    }
    results = run_by_turns(jobs, rounds)
    print_results(results)
    best = {name: result.best for name, result in results.items()}
    peak = max(result.peak for name, result in results.items() if "->" in name)
    kept = [
        print_ratio(
            "tum -> mcap --archive / cp -r", best["tum -> mcap --archive"] / best["cp -r"], COPY_BUDGET
        ),
        print_ratio("mcap -> tum / cp -r", best["mcap -> tum"] / best["cp -r"], COPY_BUDGET),
        print_ratio(
            "tar xzf / .tgz -> mcap --archive",
            best["tar xzf"] / best[".tgz -> mcap --archive"],
            TAR_BUDGET,
            at_least=True,
        ),
        print_ratio("peak memory", peak / 1e6, MEMORY_BUDGET / 1e6, unit="MB"),
    ]
    for path in (archive, back, copy, default, packed, unpacked, from_tgz):
        remove(path)
    return results, all(kept)


def print_per_frame(short: dict[str, Result], long: dict[str, Result]) -> None:
    """Print ratios of what the further frames cost, without start-up; processor time for busy machines."""
    for name, other in (
        ("tum -> mcap --archive", "cp -r"),
        ("mcap -> tum", "cp -r"),
        (".tgz -> mcap --archive", "tar xzf"),
    ):
        wall = [long[one].best - short[one].best for one in (name, other)]
        cpu = [min(long[one].cpu) - min(short[one].cpu) for one in (name, other)]
        what = f"{name} / {other}"
        print(f"{what:44} by the clock {wall[0] / wall[1]:5.2f} x, processor {cpu[0] / cpu[1]:5.2f} x")


def measure_start(rounds: int) -> bool:
    jobs = {
        "python -c pass": Job((sys.executable, "-c", "pass")),
        "tumtools --help": Job((*TUMTOOLS, "--help")),
    }
    results = run_by_turns(jobs, rounds)
    print_results(results)
    more = results["tumtools --help"].best - results["python -c pass"].best
    return print_ratio("tumtools --help - python -c pass", more * 1000, START_BUDGET * 1000, unit="ms")


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("sequence", type=Path, nargs="?", default=SEQUENCE)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument(
        "--repeat", type=int, default=10, help="how many times as long the second sequence is"
    )
    parser.add_argument("--folder", type=Path, default=Path("/dev/shm"), help="where files go")  # noqa: S108 - a memory file system
    arguments = parser.parse_args()
    kept = [measure_start(arguments.rounds)]
    with tempfile.TemporaryDirectory(dir=arguments.folder) as name:
        lengths = []
        for times in (1, arguments.repeat):
            sequence = Path(name, f"times{times}")
            lengthen(arguments.sequence, sequence, times)
            print(f"\n{arguments.sequence.name}, {times} times as long")
            results, in_budget = measure(Path(name), sequence, arguments.rounds)
            lengths.append(results)
            kept.append(in_budget)
            remove(sequence)
        print("\nwhat the further frames cost")
        print_per_frame(*lengths)
    return 0 if all(kept) else 1


if __name__ == "__main__":
    sys.exit(main())
