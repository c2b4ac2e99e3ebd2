# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools stats`."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import TYPE_CHECKING

import click

from tumtools.cli import evaluation, options, output

if TYPE_CHECKING:
    from tumtools.evaluate.summary import Summary

_STAMPS = ("first", "last")


@click.command(name="stats")
@click.argument("sources", metavar="SOURCE...", nargs=-1, required=True)
@click.option(
    "--format",
    "layout",
    type=click.Choice(["text", "markdown", "latex", "csv", "json"]),
    default="text",
    show_default=True,
    help="How to print.",
)
@options.read_options
@options.json_option
def command(
    sources: tuple[str, ...], layout: str, topics: tuple[str, ...], salvage: bool, as_json: bool
) -> None:
    """Print motion, lengths, frame counts, rates, drops and coverage of SOURCEs.

    Velocities and the "page's length" are those of the benchmark's page and of Table I of its paper,
    made of the motion over one second. The path length is that of the line through all poses.
    """
    from tumtools.evaluate import reports
    from tumtools.evaluate.summary import summarise
    from tumtools.sources import open_source

    reading = options.make_read_options(topics, salvage)
    summaries: list[Summary] = []
    for source in sources:
        with open_source(source, reading) as sequence:
            summaries.append(summarise(sequence))
        evaluation.print_notes(tuple(f"{source}: {note}" for note in summaries[-1].notes))
    if as_json or layout == "json":
        output.print_json({"sequences": [document(*pair) for pair in zip(sources, summaries, strict=True)]})
    elif layout == "text" and len(summaries) == 1:
        _print(summaries[0])
    elif layout == "text":
        head, rows = reports.cells(_told_apart(sources, summaries))
        output.print_table(rows, head)
    else:
        table = {"markdown": reports.markdown, "latex": reports.latex, "csv": reports.as_csv}[layout]
        click.echo(output.lines(table(_told_apart(sources, summaries))))


def _told_apart(sources: tuple[str, ...], summaries: list[Summary]) -> list[Summary]:
    """Name sequences by their source where several have the same name, as a folder and its trajectory."""
    names = [summary.name for summary in summaries]
    return [
        replace(summary, name=source) if names.count(summary.name) > 1 else summary
        for source, summary in zip(sources, summaries, strict=True)
    ]


def document(source: str, summary: Summary) -> dict[str, object]:
    """Return statistics for JSON; stamps are strings."""
    return {
        "source": source,
        "name": summary.name,
        "motion": None if summary.motion is None else _plain(asdict(summary.motion)),
        "streams": {name: _plain(asdict(stream)) for name, stream in summary.streams.items()},
        "pairs": summary.pairs,
    }


def _plain(values: dict[str, object]) -> dict[str, object]:
    """Turn stamps into text."""
    stamps = {key: None if values[key] is None else str(values[key]) for key in _STAMPS}
    return values | stamps


def _print(summary: Summary) -> None:
    from tumtools.evaluate.reports import COLUMNS

    click.echo(output.style(summary.name, bold=True))
    rows = [(column.title, column.text(summary)) for column in COLUMNS[1:]]
    width = max(len(title) for title, _ in rows)
    for title, text in rows:
        if text:
            output.echo(f"{title:{width}}  {text}")
    click.echo()
    lines = [
        (
            name,
            str(stream.count),
            f"{stream.duration:.3f}",
            _rate(stream.median_rate),
            _rate(stream.mean_rate),
            "-" if stream.dropped is None else str(stream.dropped),
            f"{stream.largest_gap:.3f}",
            "-"
            if stream.with_groundtruth is None
            else f"{100.0 * stream.with_groundtruth / stream.count:.1f} %",
        )
        for name, stream in summary.streams.items()
    ]
    head = (
        "stream",
        "count",
        "duration s",
        "median Hz",
        "mean Hz",
        "dropped",
        "longest gap s",
        "with ground truth",
    )
    output.print_table(lines, head)


def _rate(rate: float | None) -> str:
    return "-" if rate is None else f"{rate:.2f}"
