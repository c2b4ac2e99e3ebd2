# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools info`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from tumtools.cli import options, output

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from tumtools.model.sequence import Sequence


@click.command(name="info")
@options.source_argument
@options.read_options
@options.json_option
def command(source: str, topics: tuple[str, ...], salvage: bool, as_json: bool) -> None:
    """Show what SOURCE holds: streams, counts, times, rates, camera, and what would not be carried over.

    Of a sequence that has not been fetched, show what the catalogue knows.
    """
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


def describe(source: str, sequence: Sequence) -> dict[str, object]:
    """Return what there is to say of a sequence, for JSON."""
    from dataclasses import asdict

    from tumtools.cli.report import loss_document

    info = sequence.info
    streams: dict[str, dict[str, object]] = {}
    for name, images in info.images.items():
        streams[name] = _times(sequence.image_stamps(name)) | {
            "encoding": images.encoding,
            "compression": images.compression,
            "width": images.width,
            "height": images.height,
            "depth_units_per_metre": images.depth_units_per_metre,
            "bytes": images.nbytes,
            "source": images.source,
            "frame_id": images.frame_id,
        }
    for name, signal in (("accelerometer", sequence.accelerometer), ("groundtruth", sequence.groundtruth)):
        if signal is not None:
            streams[name] = _times(signal.stamps)
    return {
        "source": source,
        "name": info.name,
        "format": info.format,
        "camera": info.camera,
        "streams": streams,
        "calibrations": sorted(sequence.cameras),
        "licence": info.licence,
        "citation": info.citation,
        "details": {title: [dict(row) for row in rows] for title, rows in sequence.details().items()},
        "digest": None if info.digest is None else {name: asdict(one) for name, one in info.digest.items()},
        "not_carried": [loss_document(loss) for loss in info.not_carried],
        "warnings": list(info.warnings),
    }


def _times(stamps: npt.NDArray[np.int64]) -> dict[str, object]:
    import numpy as np

    if not len(stamps):
        return {"count": 0, "first": None, "last": None, "duration_s": None, "median_rate_hz": None}
    ordered = np.sort(stamps)
    step = float(np.median(np.diff(ordered))) if len(ordered) > 1 else 0.0
    return {
        "count": len(stamps),
        "first": str(int(ordered[0])),
        "last": str(int(ordered[-1])),
        "duration_s": (int(ordered[-1]) - int(ordered[0])) / 1e9,
        "median_rate_hz": 1e9 / step if step else None,
    }


def _print(document: dict[str, object]) -> None:
    from tumtools.model.time import format_stamp

    click.echo(output.style(str(document["name"]), bold=True) + f"  ({document['format']})")
    click.echo(f"camera: {document['camera'] or 'unknown'}")
    if document["licence"]:
        click.echo(f"licence of the data: {document['licence']}")
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
    for title, table in details.items() if isinstance(details, dict) else ():
        click.echo(f"{title}:")
        cells = [["-" if value is None else str(value) for value in row.values()] for row in table]
        output.print_table([tuple(row) for row in cells], tuple(table[0]))
    if document["digest"]:
        click.echo("carries a digest of its content; compare it with: tumtools digest --check")
    not_carried = document["not_carried"]
    for loss in not_carried if isinstance(not_carried, list) else ():
        click.echo(f"not carried over: {loss['stream']}: {loss['what']}, {loss['count']} ({loss['why']})")
    warnings = document["warnings"]
    for text in warnings if isinstance(warnings, list) else ():
        output.warning(str(text))
