# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""One plan, several plain processes: shards and claims."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from tests.batch.batches import FOUR_TARGETS, Batch

if TYPE_CHECKING:
    from pathlib import Path


def test_three_processes_with_claims_do_each_task_once(tmp_path: Path) -> None:
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
    batch = Batch(tmp_path / "a", sources=6, targets=FOUR_TARGETS)
    batch.plan()
    words = ("batch", "run", "plan.json", "--claim", "--workers", "1", "--json")
    processes = [batch.start(*words) for _ in range(3)]
    outputs = [process.communicate(timeout=120) for process in processes]
    assert [process.returncode for process in processes] == [0, 0, 0], outputs
    done = [json.loads(stdout)["counts"]["done"] for stdout, _ in outputs]
    assert sum(done) == 24
    assert batch.status("--full") == {"done": 24}
    assert {entry["attempts"] for entry in batch.ledger().values()} == {1}
    assert batch.strays() == []
    local = Batch(tmp_path / "b", sources=6, targets=FOUR_TARGETS)
    local.plan()
    local.run()
    assert batch.tree() == local.tree()


def test_shards_together_do_all(tmp_path: Path) -> None:
    batch = Batch(tmp_path, sources=3)
    batch.plan()
    assert [batch.run("--shard", f"{index}/2")["done"] for index in (1, 2)] == [2, 1]
    assert batch.status() == {"done": 3}
