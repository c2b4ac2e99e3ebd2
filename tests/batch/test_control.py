# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Batches from Python: the functions of the public API."""

from __future__ import annotations

import shutil
from typing import TYPE_CHECKING

import pytest

from tests.batch.batches import FIXTURES
from tumtools import api

if TYPE_CHECKING:
    from pathlib import Path


@pytest.fixture
def manifest(tmp_path: Path) -> Path:
    for name in ("full", "early"):
        shutil.copytree(FIXTURES / name, tmp_path / "data" / name)
    path = tmp_path / "manifest.toml"
    path.write_text('destination = "out"\n[[source]]\npath = "data/*"\n[[target]]\nto = "mcap"\n')
    return path


def states(plan: api.BatchPlan | Path) -> list[str]:
    return [standing.state for standing in api.batch_status(plan)]


def test_plan_run_status_and_retry(manifest: Path) -> None:
    image = next((manifest.parent / "data/full/rgb").glob("*.png"))
    good = image.read_bytes()
    image.write_bytes(good[:-20])
    plan = api.plan_batch(manifest)
    file = manifest.parent / "plan.json"
    api.write_batch_plan(plan, file)
    assert api.read_batch_plan(file) == plan
    assert states(plan) == ["pending", "pending"]
    outcomes = list(api.run_batch(file, "inline"))
    assert [outcome.entry.state for outcome in outcomes if outcome.entry] == ["done", "failed"]
    assert states(file) == ["done", "failed"]
    image.write_bytes(good)
    (outcome,) = api.retry_batch(plan, "local", api.EngineSettings(workers=1))
    assert outcome.entry is not None
    assert outcome.entry.attempts == 2
    assert states(plan) == ["done", "done"]


def test_a_run_that_is_closed_early_is_continued_by_the_next(manifest: Path) -> None:
    plan = api.plan_batch(manifest)
    run = api.run_batch(plan, "inline")
    next(run)
    run.close()
    assert states(plan) == ["done", "pending"]
    (outcome,) = api.run_batch(plan, "inline", options=api.BatchOptions(shard=(2, 2)))
    assert outcome.how == "worked"
    assert states(plan) == ["done", "done"]
