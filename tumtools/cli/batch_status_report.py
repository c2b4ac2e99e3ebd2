# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What `tumtools batch status` prints."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from tumtools.batch.ledger import DONE, FAILED, SKIPPED, document
from tumtools.batch.losses import sum_up
from tumtools.batch.status import STATES
from tumtools.cli import output
from tumtools.cli.batch_losses import losses_document, print_losses
from tumtools.cli.batch_progress import reason

if TYPE_CHECKING:
    from tumtools.batch.status import Standing

_TOLD = {FAILED, SKIPPED, "changed", "unknown", "running", "interrupted"}
"""States whose tasks are named."""
_ALWAYS = {DONE, FAILED, "pending"}
"""Columns that are shown even when there is no such task."""


def print_status(standings: list[Standing], *, as_json: bool) -> None:
    """Print where tasks stand, what was lost, and why tasks are not done."""
    counts = Counter(standing.state for standing in standings)
    losses = sum_up(
        (standing.task, standing.entry) for standing in standings if standing.state in {DONE, "unknown"}
    )
    if as_json:
        output.print_json(
            {
                "counts": {state: counts[state] for state in STATES},
                "losses": losses_document(losses),
                "tasks": [_document(standing) for standing in standings],
            }
        )
        return
    labels = dict.fromkeys(standing.task.target.label for standing in standings)
    by_label = Counter((standing.task.target.label, standing.state) for standing in standings)
    shown = [state for state in STATES if counts[state] or state in _ALWAYS]
    rows = [(label, *(str(by_label[label, state]) for state in shown)) for label in labels]
    output.print_table([*rows, ("all", *(str(counts[state]) for state in shown))], ("target", *shown))
    print_losses(losses)
    for standing in standings:
        if standing.state in _TOLD:
            why = _why(standing)
            output.echo(f"{standing.state}: {standing.task.output}{f': {why}' if why else ''}")


def _why(standing: Standing) -> str:
    if standing.claim is not None and standing.state in {"running", "interrupted"}:
        return standing.claim.owner.words
    if standing.changed or standing.unknown:
        return standing.changed or standing.unknown
    why = reason(standing.entry) if standing.entry is not None else ""
    return f"{why}; an older output is there" if standing.stale else why


def _document(standing: Standing) -> dict[str, object]:
    return {
        "task": standing.task.id,
        "source": standing.task.source.uri,
        "target": standing.task.target.label,
        "output": standing.task.output,
        "state": standing.state,
        "changed": standing.changed,
        "unknown": standing.unknown,
        "stale": standing.stale,
        "entry": None if standing.entry is None else document(standing.entry),
    }
