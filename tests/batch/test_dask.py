# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The engine dask: on processes of its own, and on a scheduler that others started and that loses one."""

from __future__ import annotations

import signal
import time
from typing import TYPE_CHECKING

import pytest

from tests.batch.batches import ENVIRONMENT, FOUR_TARGETS, Batch
from tests.batch.dask_processes import dask_processes, require_dask

if TYPE_CHECKING:
    from pathlib import Path

pytestmark = [pytest.mark.interop, pytest.mark.slow]


def test_a_lost_worker_is_a_retry_and_the_bytes_are_those_of_the_local_engine(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    batch = Batch(tmp_path / "a", sources=6, targets=FOUR_TARGETS)
    batch.plan()
    with dask_processes(tmp_path / "dask", ENVIRONMENT) as (address, workers):
        run = batch.start("batch", "run", "plan.json", "--json", "--engine", "dask", "--address", address)
        claims = batch.out / ".tumtools" / "claims"
        while run.poll() is None and len(batch.ledger()) < 3:
            time.sleep(0.005)
        mark = f'"pid": {workers[0].pid},'
        while run.poll() is None and not any(mark in text(path) for path in claims.glob("*")):
            time.sleep(0.001)
        assert run.poll() is None, "the run ended before a worker could be killed"
        workers[0].send_signal(signal.SIGKILL)
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
    require_dask()
    batch = Batch(tmp_path, sources=2)
    batch.plan()
    assert batch.run("--engine", "dask", "--workers", "1")["done"] == 2
