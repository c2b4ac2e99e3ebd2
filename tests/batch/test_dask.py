# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The engine dask: on processes of its own, and on a scheduler that others started and that loses one."""

from __future__ import annotations

import importlib.util
import os
import signal
import subprocess
import sys
import time
from typing import TYPE_CHECKING

import pytest

from tests.batch.batches import ENVIRONMENT, FOUR_TARGETS, Batch
from tests.interop.programs import missing

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

pytestmark = pytest.mark.interop


@pytest.fixture(autouse=True)
def _needs_dask() -> None:
    if importlib.util.find_spec("distributed") is None:
        missing("dask[distributed]")


@pytest.fixture
def processes(tmp_path: Path) -> Iterator[list[subprocess.Popen[bytes]]]:
    """Start a scheduler and two workers; the scheduler's address is in `address`."""
    folder = tmp_path / "dask"
    folder.mkdir()

    def start(*words: str) -> subprocess.Popen[bytes]:
        log = (folder / f"{words[0]}.log").open("ab")
        with log:
            return subprocess.Popen(
                [sys.executable, "-m", "distributed.cli.dask_" + words[0], *words[1:]],
                cwd=folder,
                env=ENVIRONMENT | {"PYTHONWARNINGS": "ignore", "DASK_TEMPORARY_DIRECTORY": str(folder)},
                stdout=log,
                stderr=log,
            )

    file = folder / "scheduler.json"
    started = [
        start(
            "scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(file)
        )
    ]
    worker = ("--nthreads", "1", "--no-nanny", "--no-dashboard", "--host", "127.0.0.1")
    started += [start("worker", "--scheduler-file", str(file), *worker) for _ in range(2)]
    yield started
    for process in started:
        process.kill()
        process.wait()


def address_of(folder: Path) -> str:
    import json

    file = folder / "dask" / "scheduler.json"
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline:
        if file.exists() and file.read_text().endswith("}"):
            return str(json.loads(file.read_text())["address"])
        time.sleep(0.05)
    raise TimeoutError


def test_a_lost_worker_is_a_retry_and_the_bytes_are_those_of_the_local_engine(
    tmp_path: Path, processes: list[subprocess.Popen[bytes]]
) -> None:
    (tmp_path / "a").mkdir()
    batch = Batch(tmp_path / "a", sources=6, targets=FOUR_TARGETS)
    batch.plan()
    run = batch.start(
        "batch", "run", "plan.json", "--json", "--engine", "dask", "--address", address_of(tmp_path)
    )
    claims = batch.out / ".tumtools" / "claims"
    while run.poll() is None and len(batch.ledger()) < 3:
        time.sleep(0.005)
    victim = processes[1]
    while run.poll() is None and not any(f'"pid": {victim.pid},' in text(path) for path in claims.glob("*")):
        time.sleep(0.001)
    assert run.poll() is None, "the run ended before a worker could be killed"
    os.kill(victim.pid, signal.SIGKILL)
    stdout, stderr = run.communicate(timeout=120)
    assert run.returncode == 0, stdout + stderr
    assert batch.status("--full") == {"done": 24}
    assert batch.strays() == []
    (tmp_path / "b").mkdir()
    local = Batch(tmp_path / "b", sources=6, targets=FOUR_TARGETS)
    local.plan()
    local.run()
    assert batch.tree() == local.tree()


def text(path: Path) -> str:
    try:
        return path.read_text()
    except FileNotFoundError:
        return ""


def test_an_embedded_cluster(tmp_path: Path) -> None:
    batch = Batch(tmp_path, sources=2)
    batch.plan()
    assert batch.run("--engine", "dask", "--workers", "1")["done"] == 2
