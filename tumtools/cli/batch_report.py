# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What `tumtools batch` prints."""

from __future__ import annotations

import sys
from collections import Counter
from contextlib import contextmanager
from typing import TYPE_CHECKING

import click

from tumtools.batch.ledger import DONE, FAILED, SKIPPED, Entry, document
from tumtools.batch.plan import by_id
from tumtools.batch.status import STATES
from tumtools.batch.task import BUSY, KEPT
from tumtools.cli import output

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from tumtools.batch.plan import Plan, Task
    from tumtools.batch.status import Standing
    from tumtools.batch.task import Outcome

_DONE_BEFORE = "done before"
_COUNTS = (DONE, _DONE_BEFORE, SKIPPED, FAILED, BUSY)
_MOST_LOSSES = 12


def print_plan(plan: Plan, *, as_json: bool) -> None:
    """Print what a plan amounts to."""
    losses = Counter((task.target.label, loss) for task in plan.tasks for loss in task.losses)
    problems = [task for task in plan.tasks if task.problem]
    bytes_in = sum({task.source.uri: task.bytes_in for task in plan.tasks}.values())
    bytes_out = sum(task.bytes_out for task in plan.tasks)
    if as_json:
        output.print_json(
            {
                "plan": plan.id,
                "destination": plan.destination,
                "tasks": len(plan.tasks),
                "bytes_in": bytes_in,
                "bytes_out": bytes_out,
                "losses": [
                    {"target": target, "what": what, "tasks": count}
                    for (target, what), count in sorted(losses.items())
                ],
                "problems": [{"source": task.source.uri, "problem": task.problem} for task in problems],
            }
        )
        return
    sources = len({task.source.uri for task in plan.tasks})
    output.message(
        f"{len(plan.tasks)} tasks: {sources} sources, {len(plan.targets)} targets, "
        f"about {output.size(bytes_in)} to read and {output.size(bytes_out)} to write"
    )
    for text in dict.fromkeys(task.problem for task in problems):
        output.warning(f"will fail unless mended: {text}")
    if losses:
        click.echo("would be lost:")
        rows = [(target, what, str(count)) for (target, what), count in losses.most_common(_MOST_LOSSES)]
        output.print_table(rows, ("target", "what", "tasks"))


@contextmanager
def batch_progress(tasks: list[Task]) -> Iterator[Callable[[Outcome], None]]:
    """Show tasks, bytes and time left while stderr is a terminal; say what fails as it does."""
    sizes = {task.id: task.bytes_in for task in tasks}
    if output.verbosity < 0 or not sys.stderr.isatty() or not tasks:
        yield lambda outcome: _say_failure(outcome, output.message)
        return
    from tqdm import tqdm

    total, done = sum(sizes.values()), 0
    with tqdm(total=len(tasks), desc="batch", unit=" tasks", leave=False, dynamic_ncols=True) as bar:

        def advance(outcome: Outcome) -> None:
            nonlocal done
            done += sizes[outcome.task]
            if total:
                bar.set_postfix_str(f"{output.size(done)} of {output.size(total)}", refresh=False)
            bar.update()
            _say_failure(outcome, lambda text: tqdm.write(text, file=sys.stderr))

        yield advance


def _say_failure(outcome: Outcome, say: Callable[[str], None]) -> None:
    entry = outcome.entry
    if entry is not None and entry.state == FAILED:
        say(f"failed: {entry.output}: {_reason(entry)}")


def _reason(entry: Entry) -> str:
    return entry.reason.partition("\n")[0]


class Report:
    """Counts what came of the tasks of a run."""

    def __init__(self, plan: Plan) -> None:
        self._tasks = by_id(plan)
        self._labels = [target.label for target in plan.targets]
        self._counts: Counter[tuple[str, str]] = Counter()
        self._entries: dict[str, tuple[str, Entry | None]] = {}

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

    def show(self, *, as_json: bool) -> None:
        """Print the table, or the whole as JSON."""
        if as_json:
            documents = [
                {"task": task, "state": state, "entry": None if entry is None else document(entry)}
                for task, (state, entry) in sorted(self._entries.items())
            ]
            totals = {state: self._total(state) for state in _COUNTS}
            output.print_json({"counts": totals, "failed": self.failed, "tasks": documents})
            return
        if not self._counts:
            output.message("nothing to do")
            return
        rows = [(label, *(str(self._counts[label, state]) for state in _COUNTS)) for label in self._labels]
        output.print_table(
            [*rows, ("all", *(str(self._total(state)) for state in _COUNTS))], ("target", *_COUNTS)
        )
        if self.failed:
            output.message("`tumtools batch status PLAN` tells why; `tumtools batch retry PLAN` tries again")

    def _total(self, state: str) -> int:
        return sum(count for (_, counted), count in self._counts.items() if counted == state)


def print_status(standings: list[Standing], *, as_json: bool) -> bool:
    """Print where tasks stand; return whether any failed."""
    counts = Counter(standing.state for standing in standings)
    failed = counts[FAILED] > 0
    if as_json:
        documents = [
            {
                "task": standing.task.id,
                "source": standing.task.source.uri,
                "target": standing.task.target.label,
                "output": standing.task.output,
                "state": standing.state,
                "entry": None if standing.entry is None else document(standing.entry),
            }
            for standing in standings
        ]
        output.print_json({"counts": {state: counts[state] for state in STATES}, "tasks": documents})
        return failed
    labels = dict.fromkeys(standing.task.target.label for standing in standings)
    by_label = Counter((standing.task.target.label, standing.state) for standing in standings)
    shown = [state for state in STATES if counts[state] or state in {DONE, FAILED, "pending"}]
    rows = [(label, *(str(by_label[label, state]) for state in shown)) for label in labels]
    output.print_table([*rows, ("all", *(str(counts[state]) for state in shown))], ("target", *shown))
    for standing in standings:
        if standing.entry is not None and standing.state in {FAILED, SKIPPED}:
            click.echo(f"{standing.state}: {standing.task.output}: {_reason(standing.entry)}")
    return failed
