# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools diff`."""

from __future__ import annotations

import math

import click

from tumtools.cli import options, output


@click.command(name="diff")
@click.argument("a")
@click.argument("b")
@click.option("--stamp-tolerance", type=click.FloatRange(0), default=0.0, metavar="S", help="Seconds.")
@click.option(
    "--value-tolerance",
    type=click.FloatRange(0),
    default=0.0,
    metavar="X",
    help="Metres, quaternion components and m/s2.",
)
@click.option("--depth-tolerance", type=click.FloatRange(0), default=0.0, metavar="M", help="Metres.")
@click.option("--colour-tolerance", type=click.IntRange(0, 255), default=0, metavar="N", help="Levels.")
@click.option("--ignore-text", is_flag=True, help="Compare values only, not how text files are written.")
@options.read_options
@options.jobs_option
@options.json_option
def command(
    a: str,
    b: str,
    stamp_tolerance: float,
    value_tolerance: float,
    depth_tolerance: float,
    colour_tolerance: int,
    ignore_text: bool,
    topics: tuple[str, ...],
    salvage: bool,
    jobs: int,
    as_json: bool,
) -> int:
    """Compare the contents of A and B, of any formats. Exit code 0 if they are the same, 1 if not."""
    from tumtools.diff import Tolerances, diff
    from tumtools.errors import UsageError
    from tumtools.sources import open_source

    read = options.make_read_options(topics, salvage)
    for value in (stamp_tolerance, value_tolerance, depth_tolerance):
        if not math.isfinite(value):
            raise UsageError(f"a tolerance of {value} is no number that differences can be held against")
    limits = Tolerances(round(stamp_tolerance * 1e9), value_tolerance, depth_tolerance, colour_tolerance)
    with open_source(a, read) as first, open_source(b, read) as second:
        frames = sum(info.count for info in first.info.images.values())
        with output.progress_bar("diff", frames) as bar:
            result = diff(first, second, limits, jobs=jobs, progress=bar)
    if not (result.differences or result.images or result.rows):
        output.warning("neither has a stream with anything in it: nothing was compared")
    differences = [one for one in result.differences if not (ignore_text and one.what == "text")]
    if as_json:
        output.print_json(
            {
                "a": a,
                "b": b,
                "same": not differences,
                "compared": {"images": result.images, "pixels": result.pixels, "rows": result.rows},
                "differences": [
                    {name: getattr(one, name) for name in one.__dataclass_fields__} for one in differences
                ],
            }
        )
    elif differences:
        rows = [
            (
                one.stream,
                one.what,
                str(one.count),
                f"{one.largest:.6g} {one.unit}" if one.largest is not None else "-",
                one.first,
            )
            for one in differences
        ]
        output.print_table(rows, ("stream", "what", "count", "largest", "first"))
    else:
        click.echo(
            f"same content: {result.images} pairs of images ({result.pixels} pixels), "
            f"{result.rows} rows compared"
        )
    return 1 if differences else 0
