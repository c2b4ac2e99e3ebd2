# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools digest`."""

from __future__ import annotations

import json

import click

from tumtools.cli import options, output


@click.command(name="digest")
@options.source_argument
@click.option("--deep", is_flag=True, help="Print a line of JSON for each image first.")
@options.read_options
@options.jobs_option
@options.json_option
def command(
    source: str, deep: bool, topics: tuple[str, ...], salvage: bool, jobs: int, as_json: bool
) -> None:
    """Print a digest of the content of SOURCE, the same for every format that holds the same content."""
    from tumtools.digest import VERSION, digest
    from tumtools.sources import open_source

    with open_source(source, options.make_read_options(topics, salvage)) as sequence:
        frames = sum(info.count for info in sequence.info.images.values())
        with output.progress_bar("digest", frames) as bar:
            result = digest(sequence, jobs=jobs, deep=deep, progress=bar)
    for stream, stamp, value in result.frames:
        click.echo(json.dumps({"stream": stream, "stamp": str(stamp), "sha256": value}))
    if as_json:
        streams = {name: {"count": one.count, "sha256": one.value} for name, one in result.streams.items()}
        output.print_json(
            {"source": source, "digest_version": VERSION, "sha256": result.value, "streams": streams}
        )
        return
    output.print_table([(name, str(one.count), one.value) for name, one in sorted(result.streams.items())])
    click.echo(f"{result.value}  {source}")
