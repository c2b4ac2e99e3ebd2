# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The engine dask: on processes of its own, and on a scheduler that others started and that loses one."""

from __future__ import annotations

import os
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


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGTERM])
def test_a_scheduler_that_is_gone_is_one_error_and_its_tasks_are_as_they_were(
    tmp_path: Path, how: signal.Signals
) -> None:
    batch = Batch(tmp_path, sources=30)
    batch.plan()
    with dask_processes(tmp_path / "dask", ENVIRONMENT) as (address, processes):
        run = batch.start("batch", "run", "plan.json", "--engine", "dask", "--address", address)
        while run.poll() is None and len(batch.ledger()) < 2:
            time.sleep(0.005)
        assert run.poll() is None
        processes[-1].send_signal(how)
        stdout, stderr = run.communicate(timeout=120)
    assert run.returncode == 4, stdout + stderr
    assert "Traceback" not in stderr
    assert f"error: the dask scheduler at {address} is gone" in stderr
    assert {entry["state"] for entry in batch.ledger().values()} == {"done"}


def test_a_scheduler_without_workers_is_waited_for_with_a_word(tmp_path: Path) -> None:
    batch = Batch(tmp_path)
    batch.plan()
    with dask_processes(tmp_path / "dask", ENVIRONMENT, workers=0) as (address, _):
        run = batch.start("batch", "run", "plan.json", "--engine", "dask", "--address", address)
        assert run.stderr is not None
        assert f"waiting for workers: the dask scheduler at {address} has none" in run.stderr.readline()
        run.send_signal(signal.SIGINT)
        _, stderr = run.communicate(timeout=60)
    assert (run.returncode, "Traceback" in stderr) == (130, False)


def test_ctrl_c_of_an_embedded_cluster_prints_no_tracebacks(tmp_path: Path) -> None:
    require_dask()
    batch = Batch(tmp_path, sources=100, head='estimate = "off"')
    batch.plan()
    for seconds in (1.0, 1.5, None):
        run = batch.start("batch", "run", "plan.json", "--engine", "dask", "--workers", "2")
        before, begin = len(batch.ledger()), time.monotonic()
        while run.poll() is None and (
            time.monotonic() - begin < seconds if seconds else len(batch.ledger()) == before
        ):
            time.sleep(0.01)
        assert run.poll() is None
        os.killpg(run.pid, signal.SIGINT)
        _, stderr = run.communicate(timeout=60)
        # Where it comes while Python makes a class, Python ends by the signal itself; shells say 130, too.
        assert run.returncode in {130, -signal.SIGINT}
        told = [line for line in stderr.splitlines() if line and not line.startswith("cut short after")]
        assert told == ["interrupted; nothing half-written was left behind"]
