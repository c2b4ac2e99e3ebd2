# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Kill runs again and again while they work, and see that what was done stays done."""

from __future__ import annotations

import os
import random
import signal
import time
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    import subprocess
    from collections.abc import Mapping

    from tests.batch.batches import Batch

KILLS = 10
POLL_SECONDS = 0.02
"""Looking at the ledger takes time from those who fill it."""


class Watched(Protocol):
    """What can be seen of a batch from outside."""

    batch: Batch

    def claims(self) -> frozenset[object]:
        """Return something of each claim that changes when another process takes it."""

    def ledger(self) -> Mapping[str, object]:
        """Return the entries of the ledger by task."""


def kill_while_it_works(
    watched: Watched, *words: str, more: int, longest: float
) -> subprocess.Popen[str] | None:
    """Start a run and kill its whole process group once it works; None if it ended before.

    Args:
        watched: The batch.
        words: Options of `run`.
        more: Tasks that are done before it is killed, at most.
        longest: Seconds from then on, at most.

    """
    claims, goal = watched.claims(), len(watched.ledger()) + random.randint(0, more)
    process = watched.batch.start("batch", "run", "plan.json", *words)
    while process.poll() is None and not watched.claims() - claims:
        time.sleep(POLL_SECONDS)
    while process.poll() is None and len(watched.ledger()) < goal:
        time.sleep(POLL_SECONDS)
    time.sleep(random.uniform(0, longest))
    if process.poll() is not None:
        process.communicate()
        return None
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate(timeout=60)
    return process


def survive(watched: Watched, tasks: int, *words: str, longest: float, kills: int = KILLS) -> list[int]:
    """Kill runs while they work, then let one end; return how many tasks were done at each kill."""
    random.seed(8)
    done: list[int] = []
    proven: Mapping[str, object] = {}
    while len(done) < kills:
        left = kills - len(done)
        spare = (tasks - len(proven) - 2 * left) // left  # what may be done so that all kills find work
        killed = kill_while_it_works(watched, *words, more=max(spare, 0), longest=longest if spare > 0 else 0)
        assert killed is not None, f"the work was done after {len(done)} kills"
        after = watched.ledger()
        assert {task: after.get(task) for task in proven} == proven, "done again after its entry was written"
        proven = after
        done.append(len(proven))
    time.sleep(1)  # a server may still note what the last run had asked it for before it was killed
    settled = watched.ledger()
    assert {task: settled.get(task) for task in proven} == proven
    proven = settled
    counts = watched.batch.run(*words)
    final = watched.ledger()
    assert {task: final[task] for task in proven} == proven
    assert counts["done before"] == len(proven)
    assert counts["done"] == tasks - len(proven) > 0
    assert watched.batch.status("--full") == {"done": tasks}
    return done
