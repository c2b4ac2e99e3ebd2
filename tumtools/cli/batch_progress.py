# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What `tumtools batch run` shows while it runs."""

from __future__ import annotations

import sys
import time
from collections import Counter
from contextlib import contextmanager
from datetime import timedelta
from typing import TYPE_CHECKING, Final

from tumtools.batch.ledger import FAILED, SKIPPED
from tumtools.cli import output
from tumtools.printable import printable

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from tumtools.batch.ledger import Entry
    from tumtools.batch.plan import Task
    from tumtools.batch.task import Outcome


_SAY_SECONDS: Final = 60.0


@contextmanager
def batch_progress(tasks: list[Task]) -> Iterator[Callable[[Outcome], None]]:
    """Show tasks, bytes and time left while stderr is a terminal; say what fails or is skipped."""
    sizes = {task.id: task.bytes_in for task in tasks}
    total, done = sum(sizes.values()), 0
    if output.verbosity < 0 or not sys.stderr.isatty() or not tasks:
        yield _Lines(len(tasks))
        return
    from tqdm import tqdm

    with tqdm(total=len(tasks), desc="batch", unit=" tasks", leave=False, dynamic_ncols=True) as bar:

        def advance(outcome: Outcome) -> None:
            nonlocal done
            done += sizes[outcome.task]
            if total:
                bar.set_postfix_str(f"{output.size(done)} of {output.size(total)}", refresh=False)
            bar.update()
            _say_why(outcome, lambda text: tqdm.write(text, file=sys.stderr))

        yield advance


class _Lines:
    """For logs: what fails or is skipped, and where the batch stands now and then."""

    def __init__(self, total: int) -> None:
        self._total = total
        self._counts: Counter[str] = Counter()
        self._begin = self._said = time.monotonic()

    def __call__(self, outcome: Outcome) -> None:
        _say_why(outcome, output.message)
        self._counts["failed" if outcome.entry and outcome.entry.state == FAILED else "well"] += 1
        now, done = time.monotonic(), self._counts.total()
        if now - self._said >= _SAY_SECONDS and done < self._total:
            self._said = now
            left = (now - self._begin) / done * (self._total - done)
            output.message(
                f"{done} of {self._total} tasks, {self._counts['failed']} failed, "
                f"about {timedelta(seconds=round(left))} left"
            )


def reason(entry: Entry) -> str:
    """Return in one line why a task failed or was skipped."""
    if entry.bug:
        return f"{entry.reason.partition(chr(10))[0]} (a bug of tumtools; status --json has the trace)"
    return printable(entry.reason.replace("\n  hint: ", "; hint: "))


def _say_why(outcome: Outcome, say: Callable[[str], None]) -> None:
    """Say why there is no output."""
    entry = outcome.entry
    if entry is not None and entry.state in {FAILED, SKIPPED}:
        say(printable(f"{entry.state}: {entry.output}: {reason(entry)}"))
