# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A destination without room, or without leave to write: what fails says so, and what is done stays done."""

from __future__ import annotations

import json
import shutil
import subprocess
from typing import TYPE_CHECKING

import pytest

from tests.batch.batches import FOUR_TARGETS, Batch

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Path]:
    """Mount a disk with room for some outputs."""
    folder = tmp_path / "disk"
    folder.mkdir()
    if shutil.which("mount") is None:
        pytest.skip("there is no program `mount`")
    mount = ["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", str(folder)]
    done = subprocess.run(mount, capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip(f"mounting a small disk is not permitted here: {done.stderr.strip()}")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


def remount(disk: Path, options: str) -> None:
    subprocess.run(["mount", "-o", f"remount,{options}", str(disk)], check=True)


def test_tasks_fail_with_the_reason_and_are_done_once_there_is_room(tmp_path: Path, disk: Path) -> None:
    batch = Batch(tmp_path, sources=4, targets=FOUR_TARGETS, destination="disk/out")
    batch.plan()
    counts = batch.run("--workers", "2", code=1)
    assert counts["failed"] > 0
    assert counts["done"] > 0
    done = {task: entry for task, entry in batch.ledger().items() if entry["state"] == "done"}
    assert len(done) == counts["done"]
    assert batch.strays() == []
    told = [entry for entry in batch.ledger().values() if entry["state"] == "failed"]
    assert all("No space left on device" in entry["reason"] for entry in told)
    states = batch.status("--full", code=1 if told else 0)
    assert states["done"] == len(done)
    assert sum(states.values()) == 16
    remount(disk, "size=50m")
    assert batch.run("--workers", "2")["done"] == 16 - len(done)
    assert batch.status("--full") == {"done": 16}
    assert {task: batch.ledger()[task] for task in done} == done
    assert batch.strays() == []


def test_a_disk_that_cannot_be_written_to_is_one_error(tmp_path: Path, disk: Path) -> None:
    batch = Batch(tmp_path, sources=2, destination="disk/out")
    batch.plan()
    remount(disk, "ro")
    message = batch.call("batch", "run", "plan.json", code=4)
    assert message.count("the destination cannot be written to: Read-only file system") == 1
    assert message.count("\n") <= 2
    remount(disk, "rw")
    assert batch.run()["done"] == 2
    remount(disk, "ro")
    assert json.loads(batch.call("batch", "status", "plan.json", "--full", "--json"))["counts"]["done"] == 2
