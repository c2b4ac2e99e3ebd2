# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What `tumtools batch plan` prints."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

import click

from tumtools.cli import output
from tumtools.printable import printable

if TYPE_CHECKING:
    from tumtools.batch.plan import Plan

_MOST_LOSSES = 12
_MOST_PROBLEMS = 20


def print_plan(plan: Plan, *, as_json: bool) -> None:
    """Print what a plan amounts to."""
    losses = Counter((task.target.label, loss) for task in plan.tasks for loss in task.losses)
    problems = [task for task in plan.tasks if task.problem]
    bytes_in = sum({task.source.uri: task.bytes_in for task in plan.tasks}.values())
    bytes_out = sum(task.bytes_out for task in plan.tasks)
    sources = len({task.source.uri for task in plan.tasks})
    if as_json:
        output.print_json(
            {
                "plan": plan.id,
                "destination": plan.destination,
                "tasks": len(plan.tasks),
                "sources": sources,
                "opened": plan.opened,
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
    known = f"about {output.size(bytes_in)} to read and {output.size(bytes_out)} to write"
    output.message(
        f"{_count(len(plan.tasks), 'task')}: {_count(sources, 'source')}, "
        f"{_count(len(plan.targets), 'target')}, "
        f"{known if bytes_in else 'of unknown size'}"
    )
    if plan.opened < sources:
        output.message(
            f"{plan.opened} of {sources} sources were opened; what the others would lose is not known yet"
        )
    told = list(dict.fromkeys(task.problem for task in problems))
    for text in told[:_MOST_PROBLEMS]:
        output.warning(printable(f"will fail unless mended: {text}"))
    if len(told) > _MOST_PROBLEMS:
        output.warning(f"and {len(told) - _MOST_PROBLEMS} more; --json tells all")
    if losses:
        click.echo("would be lost:")
        rows = [(target, what, str(count)) for (target, what), count in losses.most_common(_MOST_LOSSES)]
        output.print_table(rows, ("target", "what", "tasks"))


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"
