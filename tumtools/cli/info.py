# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools info`."""

from __future__ import annotations

import click

from tumtools.cli import options, output

_STAMPS = frozenset({"first", "last"})
"""Columns of a format's own tables that are stamps: nanoseconds for programs, seconds for people."""


@click.command(name="info")
@options.source_argument
@options.read_options
@options.json_option
def command(source: str, topics: tuple[str, ...], salvage: bool, as_json: bool) -> None:
    """Show what SOURCE holds: streams, counts, times, rates, camera, and what would not be carried over.

    Of a sequence that has not been fetched, show what the catalogue knows.
    """
    from tumtools.cli.description import describe
    from tumtools.cli.entry import entry_to_show, show_entry
    from tumtools.sources import open_source

    entry = entry_to_show(source)
    if entry is not None:
        show_entry(entry, as_json=as_json)
        return
    with open_source(source, options.make_read_options(topics, salvage, lenient=True)) as sequence:
        document = describe(source, sequence)
    if as_json:
        output.print_json(document)
    else:
        _print(document)


def _print(document: dict[str, object]) -> None:
    from tumtools.model.time import format_stamp

    click.echo(output.style(str(document["name"]), bold=True) + f"  ({document['format']})")
    output.echo(f"camera: {document['camera'] or 'unknown'}")
    if document["licence"]:
        output.echo(f"licence of the data: {document['licence']}")
    rows = []
    streams = document["streams"]
    for name, stream in streams.items() if isinstance(streams, dict) else ():
        shape = (
            f"{stream['width']}x{stream['height']} {stream['encoding']}" if stream.get("encoding") else "-"
        )
        if stream.get("compression"):
            shape += f" ({stream['compression']})"
        if stream.get("depth_units_per_metre"):
            shape += f", {stream['depth_units_per_metre']:g} per metre"
        first, rate = stream["first"], stream["median_rate_hz"]
        rows.append(
            (
                name,
                str(stream["count"]),
                format_stamp(int(first), 9) if first else "-",
                f"{stream['duration_s']:.3f}" if first else "-",
                f"{rate:.1f}" if rate else "-",
                shape,
                str(stream.get("source") or "-"),
            )
        )
    output.print_table(rows, ("stream", "count", "first stamp", "duration s", "median Hz", "images", "from"))
    details = document["details"]
    _print_details(details if isinstance(details, dict) else {})
    if document["digest"]:
        output.echo("carries a digest of its content; compare it with: tumtools digest --check")
    not_carried = document["not_carried"]
    for loss in not_carried if isinstance(not_carried, list) else ():
        output.echo(f"not carried over: {loss['stream']}: {loss['what']}, {loss['count']} ({loss['why']})")
    notes = document["notes"]
    for text in notes if isinstance(notes, list) else ():
        output.echo(f"note: {text}")
    warnings = document["warnings"]
    for text in warnings if isinstance(warnings, list) else ():
        output.warning(str(text))


def _print_details(details: dict[str, list[dict[str, object]]]) -> None:
    """Print what only this format knows; nothing of a table without rows, as that of a damaged file."""
    from tumtools.model.time import format_stamp

    for title, table in details.items():
        if not table:
            continue
        output.echo(f"{title}:")
        cells = [
            tuple(
                "-" if value is None else format_stamp(int(str(value)), 9) if name in _STAMPS else str(value)
                for name, value in row.items()
            )
            for row in table
        ]
        output.print_table(cells, tuple(table[0]))
