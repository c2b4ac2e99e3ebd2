# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""How `tumtools batch` shows what tasks lost."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from tumtools.cli import output
from tumtools.cli.report import loss_document
from tumtools.printable import printable

if TYPE_CHECKING:
    from tumtools.batch.losses import TargetLoss

_MOST_ROWS = 20


def losses_document(losses: list[TargetLoss]) -> list[dict[str, object]]:
    """Return losses for JSON."""
    return [{"target": one.target, **loss_document(one.loss), "outputs": list(one.outputs)} for one in losses]


def print_losses(losses: list[TargetLoss]) -> None:
    """Print what was lost, a row for each target and kind of loss."""
    if not losses:
        return
    click.echo("lost:")
    rows = [
        (
            one.target,
            one.loss.stream,
            one.loss.what,
            str(one.loss.count),
            f"{one.loss.largest_error:.3g} {one.loss.unit}" if one.loss.largest_error is not None else "-",
            _names(one.outputs),
        )
        for one in losses[:_MOST_ROWS]
    ]
    output.print_table(rows, ("target", "stream", "what", "count", "largest error", "in"))
    if len(losses) > _MOST_ROWS:
        click.echo(f"and {len(losses) - _MOST_ROWS} more kinds of loss; --json tells all")


def _names(outputs: tuple[str, ...]) -> str:
    more = f" and {len(outputs) - 1} more" if len(outputs) > 1 else ""
    return printable(f"{outputs[0]}{more}")
