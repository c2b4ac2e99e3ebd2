# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools formats`."""

from __future__ import annotations

import click

from tumtools.cli import options, output
from tumtools.formats.registry import FORMATS


@click.command(name="formats")
@options.json_option
def command(as_json: bool) -> None:
    """List the formats, what is read and written of each, and their options."""
    if as_json:
        output.print_json(
            {
                "formats": [
                    {
                        "name": entry.name,
                        "title": entry.title,
                        "reads": entry.reads,
                        "writes": entry.writes,
                        "options": {name: list(values) for name, values in entry.options.items()},
                    }
                    for entry in FORMATS.values()
                ]
            }
        )
        return
    for entry in FORMATS.values():
        click.echo(output.style(entry.name, bold=True) + f"  {entry.title}")
        click.echo(f"  reads:  {entry.reads}")
        click.echo(f"  writes: {entry.writes}")
        for name, values in entry.options.items():
            if values:
                flag = f"--{name.replace('_', '-')}"
                click.echo(f"  {flag} {'|'.join(values)}  (default {values[0]})")
