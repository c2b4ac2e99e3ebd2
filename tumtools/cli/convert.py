# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools convert`."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from tumtools.cli import options, output
from tumtools.cli.report import print_report, report_document
from tumtools.formats.registry import FORMATS

if TYPE_CHECKING:
    from tumtools.formats.options import WriteOptions

_CHOICES = {
    "layout": "Topic and frame names.",
    "profile": "MCAP profile.",
    "storage": "rosbag2 storage.",
    "color_encoding": "Colour images.",
    "depth_encoding": "Depth images; 16UC1 is millimetres and loses up to 0.4 mm.",
    "compression": "Of chunks.",
    "dialect": "rawlog dialect.",
    "groundtruth": "How ground truth is written.",
}
"""Options of the formats with a fixed set of values, which come from the registry."""


def _format_options(command: options.Command) -> options.Command:
    for name, text in reversed(_CHOICES.items()):
        values = list(dict.fromkeys(v for entry in FORMATS.values() for v in entry.options.get(name, ())))
        if values:
            flag = f"--{name.replace('_', '-')}"
            command = click.option(flag, type=click.Choice(values), default=None, help=text)(command)
    return command


@click.command(name="convert")
@click.argument("source", default=".")
@click.argument("target", required=False, metavar="[DEST]")
@click.option("--to", required=True, type=click.Choice(list(FORMATS)), help="Format to write.")
@click.option(
    "--archive", is_flag=True, help="Pass PNG files through, so that the way back gives the same files."
)
@_format_options
@click.option("--ros-distro", default=None, help="ROS 2 release that must read the result.")
@click.option("--camera", default=None, metavar="fr1|fr2|fr3|ros-default|FILE", help="Calibration to write.")
@click.option(
    "--frame-id", "frame_ids", multiple=True, metavar="STREAM=ID", help="Coordinate frame of a stream."
)
@options.read_options
@click.option("--start", metavar="S", help="Seconds from the first stamp, or a stamp since 1970.")
@click.option("--end", metavar="S", help="Seconds from the first stamp, or a stamp since 1970.")
@click.option("--every", type=click.IntRange(1), default=1, metavar="N", help="Keep each n-th image.")
@click.option("--streams", metavar="rgb,depth,...", help="Keep only these streams.")
@click.option("--strict", is_flag=True, help="Refuse to lose anything (exit 3).")
@click.option("--verify/--no-verify", default=True, help="Read the result back and compare it.")
@click.option(
    "--digest/--no-digest",
    default=None,
    help="Keep a digest in DEST, for tumtools digest --check.  [default: where the format can hold one]",
)
@click.option("--dry-run", is_flag=True, help="Tell what would be written and lost; write nothing.")
@click.option("--force", is_flag=True, help="Replace DEST.")
@options.jobs_option
@options.json_option
def command(
    source: str,
    target: str | None,
    to: str,
    topics: tuple[str, ...],
    salvage: bool,
    start: str | None,
    end: str | None,
    every: int,
    streams: str | None,
    strict: bool,
    verify: bool,
    digest: bool | None,
    dry_run: bool,
    force: bool,
    as_json: bool,
    **format_options: object,
) -> None:
    """Convert SOURCE (the current folder unless told) to another format.

    DEST is a name beside SOURCE unless told. The result is read back and compared before it gets its name.
    """
    from tumtools.convert import ConvertOptions, convert, default_target, refuse_source
    from tumtools.sources import locate, open_source

    place = locate(source)
    path = Path(target) if target else default_target(place, to)
    if not target and not os.path.lexists(source):
        path = Path(path.name)  # the sequence of a name lies in the cache, where nobody looks for results
    refuse_source(place, path)
    write_options = _write_options(format_options)
    read_options = options.make_read_options(topics, salvage, streams=streams)
    if not dry_run:
        # Where the target goes there is room for as much as the source holds, or else no target.
        scratch = next(parent for parent in path.absolute().parents if parent.is_dir())
        read_options = replace(read_options, scratch=scratch)
    with open_source(source, read_options) as sequence, output.warnings(sequence.info.warnings):
        if sequence.info.format == "tum":
            # A folder has no topics to choose from: the option names those to write.
            write_options = replace(write_options, topics=read_options.topics)
        selection = options.make_selection(sequence, start, end, every, streams)
        convert_options = ConvertOptions(selection, strict, verify, force, dry_run, digest)
        frames = sum(info.count for info in sequence.info.images.values())
        with (
            output.progress_bar("convert", frames) as bar,
            output.progress_bar("verify", frames) as verify_bar,
        ):
            report = convert(
                sequence, path, to, write_options, convert_options, progress=bar, verify_progress=verify_bar
            )
    for text in report.warnings:
        output.warning(text)
    if as_json:
        warnings = [*sequence.info.warnings, *report.warnings]
        output.print_json({"source": source, **report_document(report), "warnings": warnings})
    else:
        print_report(report)


def _write_options(values: dict[str, object]) -> WriteOptions:
    """Build the options of the format; a camera that is no name is the file of a calibration."""
    from tumtools.formats.options import WriteOptions
    from tumtools.model.camera import CAMERAS

    camera = values.pop("camera")
    if camera is not None and camera not in CAMERAS:
        from tumtools.formats.calibration import read_calibration  # it needs YAML

        # Depth is registered to colour and shares its intrinsics.
        values["cameras"] = dict.fromkeys(("rgb", "depth"), read_calibration(Path(str(camera))))
        camera = None
    values["camera"] = camera
    frame_ids = values.pop("frame_ids")
    pairs = options.parse_pairs(frame_ids if isinstance(frame_ids, tuple) else (), "--frame-id")
    return WriteOptions(frame_ids=pairs, **values)  # type: ignore[arg-type]  # click has checked the types
