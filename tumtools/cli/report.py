# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The report of a conversion, for people and as JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from tumtools.cli import output

if TYPE_CHECKING:
    from tumtools.convert import Report
    from tumtools.model.sequence import Loss


def report_document(report: Report) -> dict[str, object]:
    """Return a report for JSON."""
    return {
        "target": str(report.target),
        "format": report.format,
        "dry_run": report.dry_run,
        "frames": report.frames,
        "rows": report.rows,
        "bytes": report.nbytes,
        "bytes_estimated": report.dry_run,
        "verified": report.verified,
        "left_out": list(report.left_out),
        "lossless": not report.losses,
        "losses": [loss_document(loss) for loss in report.losses],
        "warnings": list(report.warnings),
    }


def loss_document(loss: Loss) -> dict[str, object]:
    """Return a loss for JSON."""
    return {name: getattr(loss, name) for name in loss.__dataclass_fields__}


def print_report(report: Report) -> None:
    """Print what was done, and what was lost."""
    done = "would write" if report.dry_run else "wrote"
    about = "about " if report.dry_run else ""
    checked = ", read back and compared" if report.verified else ""
    say = click.echo if report.dry_run else output.said  # a dry run has no other result
    say(
        f"{done} {report.target}: {report.frames} images, {report.rows} rows, "
        f"{about}{output.size(report.nbytes)}{checked}"
    )
    if report.left_out:
        say(f"left out as asked: {', '.join(report.left_out)}")
    if not report.losses:
        say("nothing else lost" if report.left_out else "nothing lost")
        return
    rows = [
        (
            loss.stream,
            loss.what,
            str(loss.count),
            f"{loss.largest_error:.3g} {loss.unit}" if loss.largest_error is not None else "-",
            loss.why,
        )
        for loss in report.losses
    ]
    click.echo("lost:")
    output.print_table(rows, ("stream", "what", "count", "largest error", "why"))
