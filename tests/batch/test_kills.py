# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What happens when everything is killed: nothing is lost, nothing is done twice, nothing is left over."""

from __future__ import annotations

import os
import random
import shutil
import signal
import time
from typing import TYPE_CHECKING

import pytest

from tests.batch.batches import FOUR_TARGETS, Batch
from tumtools.digest import digest
from tumtools.sources import open_source

if TYPE_CHECKING:
    from pathlib import Path

KILLS = 10


def kill_somewhere(batch: Batch, longest: float) -> bool:
    """Start a run, kill its whole process group some time after it has begun; False if it had ended."""
    process = batch.start("batch", "run", "plan.json", "--workers", "2")
    claims = batch.out / ".tumtools" / "claims"
    before = {path.name for path in claims.glob("*")}
    while process.poll() is None and not {path.name for path in claims.glob("*")} - before:
        time.sleep(0.002)
    time.sleep(random.uniform(0, longest))
    ended = process.poll() is not None
    if not ended:
        os.killpg(process.pid, signal.SIGKILL)
    process.communicate(timeout=60)
    return not ended


def survive(batch: Batch, longest: float) -> int:
    """Kill runs until the work is done or ten are killed; return how many were."""
    random.seed(8)
    batch.plan()
    kills, proven = 0, {}
    for _ in range(KILLS):
        killed = kill_somewhere(batch, longest)
        kills += killed
        after = batch.ledger()
        redone = [task for task, entry in proven.items() if after.get(task) != entry]
        assert redone == [], "done again after its ledger entry was written"
        proven = after
        if not killed:
            break
    assert all(entry["state"] == "done" for entry in proven.values())
    counts = batch.run("--workers", "2")
    assert counts["done"] + counts["done before"] == 24
    final = batch.ledger()
    assert {task: final[task] for task in proven} == proven
    assert counts["done before"] == len(proven)
    assert batch.status("--full") == {"done": 24}
    assert batch.strays() == []
    assert list((batch.out / ".tumtools" / "claims").iterdir()) == []
    return kills


def assert_digests_match(batch: Batch, real: str = "") -> None:
    """Each output of a lossless task holds what its source holds."""
    checked = 0
    for entry in batch.ledger().values():
        if not entry["losses"] and (not real or real in entry["output"]):
            with open_source(batch.out / entry["output"]) as output, open_source(entry["source"]) as source:
                assert digest(output).value == entry["written"]["digest"] == digest(source).value
            checked += 1
    assert checked


def test_ten_kills_lose_nothing_and_repeat_nothing(tmp_path: Path) -> None:
    batch = Batch(tmp_path, sources=6, targets=FOUR_TARGETS)
    assert survive(batch, 0.12) >= 3
    assert_digests_match(batch)


@pytest.mark.real
@pytest.mark.slow
def test_ten_kills_with_the_real_sequence(tmp_path: Path, real_sequence: Path) -> None:
    batch = Batch(tmp_path, sources=5, targets=FOUR_TARGETS)
    shutil.copytree(real_sequence, tmp_path / "data" / real_sequence.name)
    assert survive(batch, 0.8) >= 3
    assert_digests_match(batch, real_sequence.name)
