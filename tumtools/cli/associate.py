# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools associate`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from tumtools.cli import evaluation, evaluation_options, options, output
from tumtools.errors import InputError

if TYPE_CHECKING:
    from tumtools.evaluate.associate import Association, Method
    from tumtools.evaluate.rows import Rows
    from tumtools.formats.options import ReadOptions

_STREAMS = click.Choice(["rgb", "depth", "ir", "accelerometer", "groundtruth"])


@click.command(name="associate")
@click.argument("first")
@click.argument("second", required=False)
@evaluation_options.matching_options
@click.option(
    "--offset",
    type=evaluation_options.seconds,
    default="0",
    show_default=True,
    metavar="S",
    help="Added to the second stamps.",
)
@click.option("--first-only", is_flag=True, help="Print only the rows of FIRST.")
@click.option(
    "--first-stream", type=_STREAMS, default="rgb", show_default=True, help="Of FIRST, if it is a sequence."
)
@click.option(
    "--second-stream",
    type=_STREAMS,
    default="depth",
    show_default=True,
    help="Of SECOND, if it is a sequence.",
)
@options.read_options
@options.json_option
def command(
    first: str,
    second: str | None,
    max_difference: int,
    method: Method,
    offset: int,
    first_only: bool,
    first_stream: str,
    second_stream: str,
    topics: tuple[str, ...],
    salvage: bool,
    as_json: bool,
) -> None:
    """Pair the rows of FIRST and SECOND by their stamps.

    Both are text files whose rows begin with a stamp, or sequences in any format. Without SECOND, two
    streams of FIRST are paired. Stamps are printed as they are in their file, without the offset.
    """
    from tumtools.evaluate.associate import associate
    from tumtools.evaluate.tables import stamps_as_text

    reading = options.make_read_options(topics, salvage)
    one = _read(first, first_stream, reading)
    two = _read(second or first, second_stream, reading)
    found = associate(one.stamps, two.stamps, max_difference=max_difference, offset=offset, method=method)
    evaluation.print_notes(one.notes + two.notes)
    if not len(found):
        raise InputError(
            f"no rows match within {max_difference / 1e9:g} s ({len(one.stamps)} and {len(two.stamps)} rows)",
            path=first,
            hint="check that they belong together, or set --offset or --max-difference",
        )
    _report(found)
    if as_json:
        output.print_json(document(one, two, found))
        return
    columns = [stamps_as_text(one.stamps[found.first]), (one.texts[row] for row in found.first)]
    if not first_only:
        columns += [stamps_as_text(two.stamps[found.second]), (two.texts[row] for row in found.second)]
    click.echo("\n".join(" ".join(filter(None, row)) for row in zip(*columns, strict=True)))


def _read(source: str, stream: str, reading: ReadOptions) -> Rows:
    """Read a text file, or a stream of a sequence; images are named as in the benchmark's layout."""
    import numpy as np

    from tumtools.evaluate.rows import Rows, is_text, read_rows
    from tumtools.evaluate.tables import stamps_as_text
    from tumtools.sources import open_source

    if is_text(source):
        return read_rows(source)
    with open_source(source, reading) as sequence:
        signal = {"accelerometer": sequence.accelerometer, "groundtruth": sequence.groundtruth}.get(stream)
        stamps = sequence.image_stamps(stream) if signal is None else signal.stamps
        if not len(stamps):
            raise InputError(f"there is no stream '{stream}' in it", path=source)
        if signal is None:
            return Rows(stamps, tuple(f"{stream}/{text}.png" for text in stamps_as_text(stamps)))
        rows = (" ".join(map(repr, row)) for row in np.asarray(signal.values).tolist())
        return Rows(stamps, tuple(rows))


def _report(found: Association) -> None:
    from tumtools.evaluate.trajectories import matched_note

    output.message(
        f"{len(found)} pairs; {found.unmatched_first} of {found.first_count} and {found.unmatched_second} of "
        f"{found.second_count} rows have no partner; "
        f"largest difference {found.largest_difference / 1e6:.3f} ms"
    )
    evaluation.print_notes(matched_note(len(found), min(found.first_count, found.second_count)))


def document(one: Rows, two: Rows, found: Association) -> dict[str, object]:
    """Return the result for JSON."""
    return {
        "pairs": [
            {
                "first": {"stamp": str(int(one.stamps[i])), "text": one.texts[i]},
                "second": {"stamp": str(int(two.stamps[j])), "text": two.texts[j]},
                "difference_ns": int(difference),
            }
            for i, j, difference in zip(found.first, found.second, found.differences, strict=True)
        ],
        "first_rows": found.first_count,
        "second_rows": found.second_count,
        "first_unmatched": found.unmatched_first,
        "second_unmatched": found.unmatched_second,
        "largest_difference_s": found.largest_difference / 1e9,
    }
