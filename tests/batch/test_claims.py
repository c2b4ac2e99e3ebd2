# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Claims: one wins, what is not renewed expires, what is lost is noticed."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
import time
from dataclasses import replace
from typing import TYPE_CHECKING

import pytest

from tumtools.batch.claims import Claims
from tumtools.batch.owner import Owner, this_process
from tumtools.batch.stores.local import LocalStore

if TYPE_CHECKING:
    from pathlib import Path

TASK = "0123456789abcdef"


def claim_file(folder: Path) -> Path:
    return folder / ".tumtools" / "claims" / f"{TASK}.json"


def rewrite(folder: Path, **changes: object) -> None:
    path = claim_file(folder)
    path.write_text(json.dumps(json.loads(path.read_text()) | changes))


def test_of_many_threads_one_gets_the_task(tmp_path: Path) -> None:
    together, won = threading.Barrier(8), []

    def take() -> None:
        together.wait()
        with Claims(LocalStore(str(tmp_path))).hold(TASK, 0) as claim:
            if claim is not None:
                won.append(claim)
                time.sleep(0.3)

    threads = [threading.Thread(target=take) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(won) == 1
    assert not claim_file(tmp_path).exists()


def test_a_claim_of_another_machine_lasts_until_it_expires(tmp_path: Path) -> None:
    claims = Claims(LocalStore(str(tmp_path)))
    with claims.hold(TASK, 0):
        rewrite(tmp_path, owner={"host": "elsewhere", "pid": 1, "started": 1})
        with claims.hold(TASK, 0) as second:
            assert second is None
        rewrite(tmp_path, expires=time.time() - 1, attempt=3)
        with claims.hold(TASK, 0) as third:
            assert third is not None
            assert third.attempt == 4


def test_who_was_too_late_to_renew_does_not_get_it_back(tmp_path: Path) -> None:
    claims = Claims(LocalStore(str(tmp_path)))
    with claims.hold(TASK, 0) as first:
        assert first is not None
        assert first.renew()
        rewrite(tmp_path, token="of another")  # noqa: S106 - no password
        theirs = claim_file(tmp_path).read_bytes()
        assert not first.renew()
    assert claim_file(tmp_path).read_bytes() == theirs


def test_a_claim_is_renewed_while_the_work_goes_on(tmp_path: Path) -> None:
    with Claims(LocalStore(str(tmp_path)), lease=0.2).hold(TASK, 0):
        first = claim_file(tmp_path).read_bytes()
        deadline = time.monotonic() + 20
        while claim_file(tmp_path).read_bytes() == first and time.monotonic() < deadline:
            time.sleep(0.02)
        assert claim_file(tmp_path).read_bytes() != first


def test_a_claim_of_a_killed_process_of_this_machine_is_free_at_once(tmp_path: Path) -> None:
    process = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
    owner = replace(this_process(), pid=process.pid)
    assert owner.is_dead(), "another process with that number"
    process.kill()
    process.communicate()
    assert replace(owner, started=this_process().started).is_dead()
    assert not this_process().is_dead()
    assert not Owner("elsewhere", process.pid, 1).is_dead()


def test_a_damaged_claim_counts_as_expired(tmp_path: Path) -> None:
    claim_file(tmp_path).parent.mkdir(parents=True)
    claim_file(tmp_path).write_text("{")
    with Claims(LocalStore(str(tmp_path))).hold(TASK, 0) as claim:
        assert claim is not None


@pytest.mark.parametrize(
    "changes",
    [
        {"expires": "soon"},
        {"expires": None},
        {"expires": float("nan")},
        {"expires": float("inf")},
        {"expires": 10**400},
        {"attempt": "third"},
        {"owner": "me"},
        {"owner": {"host": 7, "pid": 1, "started": 1}},
        {"token": 7},
        {"more": 7},
    ],
    ids=str,
)
def test_a_claim_with_wrong_types_has_expired(tmp_path: Path, changes: dict[str, object]) -> None:
    claims = Claims(LocalStore(str(tmp_path)))
    with claims.hold(TASK, 0):
        rewrite(tmp_path, **changes)
        assert all(claim.has_expired() for claim in claims.all())
        with claims.hold(TASK, 0) as second:
            assert second is not None


@pytest.mark.parametrize("pid", [-1, 0, 2**40])
def test_a_number_that_no_process_has_is_of_one_that_is_gone(pid: int) -> None:
    assert replace(this_process(), pid=pid).is_dead()


def test_a_claim_that_is_nested_too_deeply_has_expired(tmp_path: Path) -> None:
    claims = Claims(LocalStore(str(tmp_path)))
    with claims.hold(TASK, 0):
        claim_file(tmp_path).write_text("[" * 10**5)
        with claims.hold(TASK, 0) as second:
            assert second is not None
