# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What happens when everything is killed: nothing is lost, nothing is done twice, nothing is left over."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

from tests.batch.batches import FOUR_TARGETS, Batch
from tests.batch.kills import survive
from tumtools.digest import digest
from tumtools.sources import open_source

if TYPE_CHECKING:
    from pathlib import Path


class Folder:
    """A batch with a local destination."""

    def __init__(self, batch: Batch) -> None:
        self.batch = batch

    def claims(self) -> frozenset[object]:
        found = set()
        for path in (self.batch.out / ".tumtools" / "claims").glob("*"):
            try:
                found.add((path.name, path.stat().st_mtime_ns))
            except FileNotFoundError:
                continue
        return frozenset(found)

    def ledger(self) -> dict[str, dict[str, Any]]:
        return self.batch.ledger()


def assert_nothing_is_left_over(batch: Batch) -> None:
    assert batch.strays() == []
    assert list((batch.out / ".tumtools" / "claims").iterdir()) == []


def assert_digests_match(batch: Batch, name: str = "") -> int:
    """Each output of a lossless task holds what its source holds; return how many were compared."""
    checked = 0
    for entry in batch.ledger().values():
        if not entry["losses"] and name in entry["output"]:
            with open_source(batch.out / entry["output"]) as output, open_source(entry["source"]) as source:
                assert digest(output).value == entry["written"]["digest"] == digest(source).value
            checked += 1
    return checked


def test_kills_lose_nothing_and_repeat_nothing(tmp_path: Path) -> None:
    batch = Batch(tmp_path, sources=3, targets=FOUR_TARGETS)
    assert len(batch.plan()) == 12
    survive(Folder(batch), 12, "--workers", "2", longest=0.1, kills=2)
    assert_nothing_is_left_over(batch)
    assert assert_digests_match(batch) >= 3


@pytest.mark.real
@pytest.mark.slow
def test_ten_kills_with_the_real_sequence(tmp_path: Path, real_sequence: Path) -> None:
    batch = Batch(tmp_path, sources=3, targets=FOUR_TARGETS)
    for number in range(3):
        (tmp_path / "data" / f"{real_sequence.name}_{number}").symlink_to(real_sequence)
    assert len(batch.plan()) == 24
    survive(Folder(batch), 24, "--workers", "2", longest=1.5)
    assert_nothing_is_left_over(batch)
    assert assert_digests_match(batch, f"{real_sequence.name}_0") >= 3
