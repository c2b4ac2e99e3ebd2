# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A dask scheduler and two workers, each a process of its own."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
import time
from contextlib import contextmanager
from typing import TYPE_CHECKING

from tests.interop.programs import missing

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

_SECONDS = 120


def require_dask() -> None:
    """Skip the test where dask is missing."""
    if importlib.util.find_spec("distributed") is None:
        missing("dask[distributed]")


@contextmanager
def dask_processes(
    folder: Path, environment: Mapping[str, str], workers: int = 2
) -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """Start them in an empty folder; give the scheduler's address, the workers, and last the scheduler."""
    require_dask()
    folder.mkdir()
    file = folder / "scheduler.json"
    quiet = {"PYTHONWARNINGS": "ignore", "DASK_TEMPORARY_DIRECTORY": str(folder)}

    def start(*words: str) -> subprocess.Popen[bytes]:
        with (folder / f"{words[0]}.log").open("ab") as log:
            return subprocess.Popen(
                [sys.executable, "-m", f"distributed.cli.dask_{words[0]}", *words[1:]],
                cwd=folder,
                env={**environment, **quiet},
                stdout=log,
                stderr=log,
            )

    common = ("--host", "127.0.0.1", "--no-dashboard", "--scheduler-file", str(file))
    started = [start("scheduler", "--port", "0", *common)]
    started += [start("worker", "--nthreads", "1", "--no-nanny", *common) for _ in range(workers)]
    try:
        yield _address(file), [*started[1:], started[0]]
    finally:
        for process in started:
            process.kill()
            process.wait()


def _address(file: Path) -> str:
    deadline = time.monotonic() + _SECONDS
    while time.monotonic() < deadline:
        if file.exists() and file.read_text().endswith("}"):
            return str(json.loads(file.read_text())["address"])
        time.sleep(0.05)
    raise TimeoutError
