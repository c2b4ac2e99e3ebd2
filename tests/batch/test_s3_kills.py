# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Ten kills, three processes with claims, and dask, in a bucket whose server fails one request in ten."""

from __future__ import annotations

import hashlib
import json
import signal
import time
from typing import TYPE_CHECKING, Any

import pytest

from tests.batch import batches
from tests.batch.batches import FOUR_TARGETS, Batch
from tests.batch.dask_processes import dask_processes
from tests.batch.kills import survive
from tests.batch.s3_server import BUCKET, Flaky, objects, s3_server, unfinished_uploads

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

pytestmark = [pytest.mark.interop, pytest.mark.slow]


@pytest.fixture
def server(monkeypatch: pytest.MonkeyPatch) -> Iterator[Flaky]:
    with s3_server(0.1) as (application, environment):
        monkeypatch.setattr(batches, "ENVIRONMENT", batches.ENVIRONMENT | environment)
        yield application


class Bucket:
    """A batch with its destination in the bucket."""

    def __init__(self, batch: Batch) -> None:
        self.batch = batch

    def claims(self) -> frozenset[object]:
        return frozenset(objects("out/.tumtools/claims/").items())

    def ledger(self) -> dict[str, Any]:
        entries = {name: json.loads(data) for name, data in objects("out/.tumtools/ledger/").items()}
        return {entry["task"]: entry for entry in entries.values()}

    def tree(self) -> dict[str, str]:
        """Return the hashes of the outputs; nothing but they and the ledger may be there."""
        outputs = tuple(task["output"] for task in json.loads(self.batch.plan_file.read_text())["tasks"])
        found = {name.removeprefix("out/"): data for name, data in objects("out/").items()}
        tree = {name: data for name, data in found.items() if not name.startswith(".tumtools/ledger/")}
        assert [
            name
            for name in tree
            if not any(name == output or name.startswith(f"{output}/") for output in outputs)
        ] == []
        return {name: hashlib.sha256(data).hexdigest() for name, data in tree.items()}


def in_bucket(folder: Path, sources: int, targets: str = FOUR_TARGETS) -> Bucket:
    folder.mkdir()
    bucket = Bucket(Batch(folder, sources=sources, targets=targets, destination=f"s3://{BUCKET}/out"))
    bucket.batch.plan()
    return bucket


def tree_of_local(folder: Path, sources: int, targets: str = FOUR_TARGETS) -> dict[str, str]:
    folder.mkdir()
    local = Batch(folder, sources=sources, targets=targets)
    local.plan()
    local.run()
    return local.tree()


def test_ten_kills(tmp_path: Path, server: Flaky) -> None:
    bucket = in_bucket(tmp_path / "bucket", 6)
    scratch = tmp_path / "scratch"
    survive(bucket, 24, "--workers", "2", "--scratch", str(scratch), longest=0.3)
    assert list(scratch.iterdir()) == []
    assert bucket.tree() == tree_of_local(tmp_path / "local", 6)
    assert server.failed > 50
    assert unfinished_uploads() == 0, "files that fit into a part are uploaded in one request"


def test_claims_in_three_processes(tmp_path: Path, server: Flaky) -> None:
    bucket = in_bucket(tmp_path / "bucket", 6)
    words = ("batch", "run", "plan.json", "--json", "--claim", "--workers", "1")
    processes = [bucket.batch.start(*words) for _ in range(3)]
    printed = [process.communicate(timeout=500) for process in processes]
    assert [process.returncode for process in processes] == [0, 0, 0], printed
    assert sum(json.loads(stdout)["counts"]["done"] for stdout, _ in printed) == 24
    assert {entry["attempts"] for entry in bucket.ledger().values()} == {1}
    assert bucket.batch.status("--full") == {"done": 24}
    assert bucket.tree() == tree_of_local(tmp_path / "local", 6)


def test_dask_loses_a_worker(tmp_path: Path, server: Flaky) -> None:
    bucket = in_bucket(tmp_path / "bucket", 6)
    with dask_processes(tmp_path / "dask", batches.ENVIRONMENT) as (address, workers):
        run = bucket.batch.start(
            "batch", "run", "plan.json", "--json", "--lease", "10", "--engine", "dask", "--address", address
        )
        victim = workers[0]
        while run.poll() is None and not (
            len(bucket.ledger()) >= 3
            and any(f'"pid": {victim.pid},' in str(claim) for claim in bucket.claims())
        ):
            time.sleep(0.01)
        assert run.poll() is None, "the run ended before a worker could be killed"
        victim.send_signal(signal.SIGKILL)
        stdout, stderr = run.communicate(timeout=500)
    assert run.returncode == 0, stdout + stderr
    counts = json.loads(stdout)["counts"]
    # What the worker had noted before it was killed, and not yet told, is found to be done before.
    assert counts["done"] + counts["done before"] == 24
    assert bucket.batch.status("--full") == {"done": 24}
    assert bucket.tree() == tree_of_local(tmp_path / "local", 6)
