# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What `tumtools batch run` prints in the end."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from tumtools.batch.ledger import DONE, FAILED, SKIPPED, Entry, document
from tumtools.batch.losses import sum_up
from tumtools.batch.plan import by_id
from tumtools.batch.task import BUSY, KEPT
from tumtools.cli import output
from tumtools.cli.batch_losses import losses_document, print_losses

if TYPE_CHECKING:
    from tumtools.batch.plan import Plan
    from tumtools.batch.task import Outcome

_DONE_BEFORE = "done before"
_COUNTS = (DONE, _DONE_BEFORE, SKIPPED, FAILED, BUSY)


class Report:
    """Counts what came of the tasks of a run."""

    def __init__(self, plan: Plan) -> None:
        self._tasks = by_id(plan)
        self._labels = [target.label for target in plan.targets]
        self._counts: Counter[tuple[str, str]] = Counter()
        self._entries: dict[str, tuple[str, Entry | None]] = {}

    @property
    def begun(self) -> bool:
        """Whether anything came of any task."""
        return bool(self._entries)

    @property
    def failed(self) -> bool:
        """Whether any task failed."""
        return any(state == FAILED for _, state in self._counts)

    def add(self, outcome: Outcome) -> None:
        """Count a task."""
        state = outcome.entry.state if outcome.entry else BUSY
        if outcome.how == KEPT and state == DONE:
            state = _DONE_BEFORE
        self._counts[self._tasks[outcome.task].target.label, state] += 1
        self._entries[outcome.task] = state, outcome.entry

    def show(self, *, as_json: bool, of: int | None = None) -> None:
        """Print the table and what was lost, or the whole as JSON.

        Args:
            as_json: Which.
            of: Of how many tasks, where the run was cut short.

        """
        losses = sum_up(
            (self._tasks[task], self._entries[task][1]) for task in self._tasks if task in self._entries
        )
        if as_json:
            documents = [
                {
                    "task": task,
                    "source": self._tasks[task].source.uri,
                    "target": self._tasks[task].target.label,
                    "output": self._tasks[task].output,
                    "state": state,
                    "entry": None if entry is None else document(entry),
                }
                for task, (state, entry) in sorted(self._entries.items())
            ]
            output.print_json(
                {
                    "counts": {state: self._total(state) for state in _COUNTS},
                    "failed": self.failed,
                    "interrupted": of is not None,
                    "losses": losses_document(losses),
                    "tasks": documents,
                }
            )
            return
        if of is not None:
            output.message(
                f"cut short after {len(self._entries)} of {of} tasks; "
                "`tumtools batch run PLAN` goes on with what is not done"
            )
            if not self._counts:
                return
        if not self._counts:
            output.message("nothing to do")
            return
        rows = [(label, *(str(self._counts[label, state]) for state in _COUNTS)) for label in self._labels]
        output.print_table(
            [*rows, ("all", *(str(self._total(state)) for state in _COUNTS))], ("target", *_COUNTS)
        )
        print_losses(losses)
        if self.failed:
            output.message("`tumtools batch status PLAN` tells why; `tumtools batch retry PLAN` tries again")

    def _total(self, state: str) -> int:
        return sum(count for (_, counted), count in self._counts.items() if counted == state)
