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
        "left_out_frames": report.left_out_frames,
        "left_out_rows": report.left_out_rows,
        "lossless": not report.losses,
        "losses": [loss_document(loss) for loss in report.losses],
        "warnings": list(report.warnings),
    }


def loss_document(loss: Loss) -> dict[str, object]:
    """Return a loss for JSON; its error without the noise of binary fractions."""
    fields = {name: getattr(loss, name) for name in loss.__dataclass_fields__}
    error = loss.largest_error
    return fields | {"largest_error": None if error is None else float(f"{error:.9g}")}


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
    left_out = _left_out(report)
    if left_out:
        say(f"left out as asked: {left_out}")
    if not report.losses:
        say("nothing else lost" if left_out else "nothing lost")
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


def _left_out(report: Report) -> str:
    """Say which streams and how much of the others are not in the target because the options say so."""
    counts = ((report.left_out_frames, "images"), (report.left_out_rows, "rows"))
    return ", ".join([*report.left_out, *(f"{count} {what}" for count, what in counts if count)])
