# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What `tumtools batch status` prints."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

import click

from tumtools.batch.ledger import DONE, FAILED, SKIPPED, document
from tumtools.batch.losses import sum_up
from tumtools.batch.status import STATES
from tumtools.cli import output
from tumtools.cli.batch_losses import losses_document, print_losses
from tumtools.cli.batch_progress import reason

if TYPE_CHECKING:
    from tumtools.batch.status import Standing

_ALWAYS = {DONE, FAILED, "pending"}
"""Columns that are shown even when there is no such task."""


def print_status(standings: list[Standing], *, as_json: bool) -> bool:
    """Print where tasks stand; return whether any failed."""
    counts = Counter(standing.state for standing in standings)
    failed = counts[FAILED] > 0
    losses = sum_up((standing.task, standing.entry) for standing in standings if standing.state == DONE)
    if as_json:
        output.print_json(
            {
                "counts": {state: counts[state] for state in STATES},
                "losses": losses_document(losses),
                "tasks": [_document(standing) for standing in standings],
            }
        )
        return failed
    labels = dict.fromkeys(standing.task.target.label for standing in standings)
    by_label = Counter((standing.task.target.label, standing.state) for standing in standings)
    shown = [state for state in STATES if counts[state] or state in _ALWAYS]
    rows = [(label, *(str(by_label[label, state]) for state in shown)) for label in labels]
    output.print_table([*rows, ("all", *(str(counts[state]) for state in shown))], ("target", *shown))
    print_losses(losses)
    for standing in standings:
        if standing.entry is not None and standing.state in {FAILED, SKIPPED}:
            click.echo(f"{standing.state}: {standing.task.output}: {reason(standing.entry)}")
    return failed


def _document(standing: Standing) -> dict[str, object]:
    return {
        "task": standing.task.id,
        "source": standing.task.source.uri,
        "target": standing.task.target.label,
        "output": standing.task.output,
        "state": standing.state,
        "entry": None if standing.entry is None else document(standing.entry),
    }
