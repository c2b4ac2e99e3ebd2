# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Batches for tests: sources copied from the fixtures, a manifest, and the program as a process."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
FIXTURES = ROOT / "fixtures"
ENVIRONMENT = os.environ | {"PYTHONPATH": str(ROOT), "NO_COLOR": "1", "PYTHONWARNINGS": "default"}

FOUR_TARGETS = """
[[target]]
to = "mcap"

[[target]]
to = "rosbag1"
compression = "lz4"

[[target]]
to = "rawlog"

[[target]]
to = "tum"
ext = "tgz"
"""


class Batch:
    """A folder with sources `data/*`, a manifest and its plan.

    Args:
        folder: An empty folder.
        sources: Number of sources.
        targets: The targets of the manifest, TOML.
        head: Keys of the manifest.
        destination: Where the outputs go.

    """

    def __init__(
        self,
        folder: Path,
        sources: int = 1,
        targets: str = '[[target]]\nto = "mcap"\n',
        head: str = "",
        destination: str = "out",
    ) -> None:
        self.folder = folder
        self.out = folder / destination
        self.plan_file = folder / "plan.json"
        for number in range(sources):
            name = ("full", "early", "fr3", "no_depth", "no_accelerometer", "ir_calibration")[number % 6]
            shutil.copytree(FIXTURES / name, folder / "data" / f"{name}_{number}")
        (folder / "manifest.toml").write_text(
            f'destination = "{destination}"\n{head}\n[[source]]\npath = "data/*"\n{targets}'
        )

    def start(self, *words: str | Path) -> subprocess.Popen[str]:
        """Start the program in a process group of its own."""
        return subprocess.Popen(
            [sys.executable, "-m", "tumtools", *words],
            cwd=self.folder,
            env=ENVIRONMENT,
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,
        )

    def call(self, *words: str | Path, code: int = 0) -> str:
        """Run the program to its end and return what it prints."""
        process = self.start(*words)
        stdout, stderr = process.communicate(timeout=300)
        assert process.returncode == code, f"{words}: {process.returncode}\n{stdout}\n{stderr}"
        return stdout if code == 0 or stdout else stderr

    def plan(self) -> list[dict[str, Any]]:
        """Plan, and return the tasks."""
        self.call("batch", "plan", "manifest.toml", "-o", "plan.json")
        return list(json.loads(self.plan_file.read_text())["tasks"])

    def run(self, *words: str, code: int = 0) -> dict[str, int]:
        """Run the plan and return how many tasks came to which end."""
        counts: dict[str, int] = json.loads(
            self.call("batch", "run", "plan.json", "--json", *words, code=code)
        )["counts"]
        return counts

    def status(self, *words: str, code: int = 0) -> dict[str, int]:
        """Return how many tasks are in which state."""
        counts: dict[str, int] = json.loads(
            self.call("batch", "status", "plan.json", "--json", *words, code=code)
        )["counts"]
        return {state: count for state, count in counts.items() if count}

    def ledger(self) -> dict[str, dict[str, Any]]:
        """Return the entries of the ledger by task."""
        return {
            path.stem: json.loads(path.read_text()) for path in self.out.glob(".tumtools/ledger/*/*.json")
        }

    def tree(self) -> dict[str, str]:
        """Return the hashes of all files below the destination but for the ledger."""
        return hashes(self.out)

    def strays(self) -> list[str]:
        """Return the files below the destination that are neither outputs, ledger entries nor the lock."""
        tasks = json.loads(self.plan_file.read_text())["tasks"]
        outputs = tuple(task["output"] for task in tasks)
        known = {f".tumtools/ledger/{task['id'][:2]}/{task['id']}.json" for task in tasks} | {
            ".tumtools/lock"
        }
        names = [path.relative_to(self.out).as_posix() for path in self.out.rglob("*") if not path.is_dir()]
        return [
            name
            for name in names
            if name not in known
            and not any(name == output or name.startswith(f"{output}/") for output in outputs)
        ]


def hashes(folder: Path) -> dict[str, str]:
    """Return the hashes of all files but for the ledger."""
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and ".tumtools" not in path.parts
    }
