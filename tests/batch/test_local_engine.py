# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The local engine: what crashes, hangs or eats all memory is one job, and the others go on."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import threading
import time
from typing import TYPE_CHECKING, Any, cast

import pytest

from tests.batch.batches import FIXTURES, Batch
from tumtools.batch.engines.engine import EngineSettings
from tumtools.batch.engines.interrupts import children_undisturbed
from tumtools.batch.engines.local import LocalEngine
from tumtools.batch.manifest import read_manifest
from tumtools.batch.plan import make_plan
from tumtools.batch.task import Job
from tumtools.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path


class Hostile:
    """What happens when the worker unpacks it."""

    def __init__(self, function: Callable[..., object], *arguments: object) -> None:
        self._reduced = function, arguments

    def __reduce__(self) -> tuple[Any, ...]:
        return self._reduced


def good_job(folder: Path) -> Job:
    shutil.copytree(FIXTURES / "trajectory", folder / "data")
    (folder / "m.toml").write_text(
        'destination = "out"\n[[source]]\npath = "data"\n[[target]]\nto = "mcap"\n'
    )
    plan = make_plan(read_manifest(folder / "m.toml"))
    return Job(plan.tasks[0], plan.destination, plan.policy, 60.0, None, time.time())


@pytest.mark.parametrize(
    ("hostile", "settings", "reason"),
    [
        (Hostile(os.kill, 0, signal.SIGKILL), {}, "SIGKILL"),
        (Hostile(os._exit, 3), {}, "exit code 3"),
        (Hostile(time.sleep, 600), {"timeout": 5.0}, "longer than 5 s"),
        (Hostile(bytearray, 10**10), {"memory_limit": 2 * 10**9}, "out of memory"),
    ],
    ids=["crash", "exit", "hang", "memory"],
)
def test_one_bad_job_fails_alone(
    tmp_path: Path, hostile: Hostile, settings: dict[str, Any], reason: str
) -> None:
    if hostile._reduced[0] is os.kill:
        hostile = Hostile(eval, "__import__('os').kill(__import__('os').getpid(), 9)")
    good = good_job(tmp_path)
    engine = LocalEngine(EngineSettings(workers=1, **settings))
    try:
        engine.submit(cast("Job", hostile))
        engine.submit(good)
        first, second = list(engine.as_completed())
    finally:
        engine.shutdown()
    assert first.outcome is None
    assert reason in first.reason
    assert second.outcome is not None
    assert second.outcome.entry is not None
    assert second.outcome.entry.state == "done"


def test_ctrl_c_keeps_the_state_and_leaves_nothing_half_done(tmp_path: Path) -> None:
    batch = Batch(tmp_path, sources=6, targets='[[target]]\nto = "mcap"\n[[target]]\nto = "rosbag1"\n')
    batch.plan()
    process = batch.start("batch", "run", "plan.json", "--workers", "2")
    while process.poll() is None and not batch.ledger():
        time.sleep(0.01)
    os.killpg(process.pid, signal.SIGINT)
    _, stderr = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "Traceback" not in stderr
    assert not list((batch.out / ".tumtools" / "claims").iterdir())
    assert batch.strays() == []
    assert all(entry["state"] == "done" for entry in batch.ledger().values())
    batch.run()
    assert batch.status("--full") == {"done": 12}


def test_a_limit_that_the_system_refuses_is_refused_before_any_worker_starts(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with pytest.raises(UsageError, match="--memory-limit"):
        LocalEngine(EngineSettings(memory_limit=10**19))
    monkeypatch.setattr("resource.getrlimit", lambda _: (10**9, 10**9))
    with pytest.raises(UsageError, match="1000000000 bytes at most"):
        LocalEngine(EngineSettings(memory_limit=2 * 10**9))
    LocalEngine(EngineSettings(memory_limit=10**9))


def test_ctrl_c_while_workers_start_prints_no_tracebacks(tmp_path: Path) -> None:
    batch = Batch(tmp_path, sources=2)
    batch.plan()
    for milliseconds in range(220, 420, 20):
        shutil.rmtree(batch.out, ignore_errors=True)
        process = batch.start("batch", "run", "plan.json", "--workers", "2")
        time.sleep(milliseconds / 1000)
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGINT)
        _, stderr = process.communicate(timeout=60)
        # Before the program is imported, Python itself tells of the interrupt; never do the workers.
        assert "spawn_main" not in stderr
        assert "resource_tracker" not in stderr


def test_signals_that_come_while_a_child_starts_are_dealt_with_afterwards() -> None:
    came: list[str] = []

    def stop() -> None:
        with children_undisturbed():
            signal.raise_signal(signal.SIGINT)
            # By way of a thread that does not block it, such as those of numerical libraries.
            thread = threading.Thread(target=raise_unblocked)
            thread.start()
            thread.join()
            came.append("started")
        came.append("never")

    def raise_unblocked() -> None:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
        signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        stop()
    assert came == ["started"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
