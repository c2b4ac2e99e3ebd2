# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The same input gives the same bytes, whatever the hash seed, time zone, locale, threads and folder."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

FULL = Path(__file__).parents[1] / "fixtures" / "full"
ROOT = Path(__file__).parents[1]
WORLDS = [
    ({"PYTHONHASHSEED": "1", "TZ": "UTC", "LC_ALL": "C"}, "1"),
    ({"PYTHONHASHSEED": "4711", "TZ": "Pacific/Kiritimati", "LC_ALL": "C.UTF-8"}, "5"),
    ({"PYTHONHASHSEED": "0", "TZ": "America/St_Johns", "LC_ALL": "tr_TR.UTF-8", "PYTHONUTF8": "1"}, "2"),
]


@pytest.mark.parametrize(
    ("suffix", "options"),
    [
        (".mcap", ["--to", "mcap"]),
        (".mcap", ["--to", "mcap", "--archive"]),
        (".mcap", ["--to", "mcap", "--color-encoding", "rgb8", "--compression", "lz4"]),
        (".tgz", ["--to", "tum"]),
    ],
)
def test_the_bytes_do_not_depend_on_the_world(tmp_path: Path, suffix: str, options: list[str]) -> None:
    results = []
    for number, (environment, jobs) in enumerate(WORLDS):
        folder = tmp_path / str(number)
        shutil.copytree(FULL, folder / "full")
        source = "full" if number else str(folder / "full")
        arguments = ["convert", source, f"x{suffix}", *options, "--jobs", jobs]
        command = [sys.executable, "-m", "tumtools", *arguments]
        env = {**os.environ, **environment, "PYTHONPATH": str(ROOT)}
        subprocess.run(command, cwd=folder, env=env, capture_output=True, check=True)
        results.append((folder / f"x{suffix}").read_bytes())
    assert len(set(results)) == 1
