# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools synth`."""

from __future__ import annotations

from pathlib import Path

import click

from tumtools.cli import options, output


@click.command(name="synth")
@click.argument("target", metavar="OUT")
@click.option(
    "--frames", type=click.IntRange(1, 100_000), default=60, show_default=True, help="Images per stream."
)
@click.option(
    "--seed", type=click.IntRange(0), default=0, show_default=True, help="Decides path, room and noise."
)
@click.option(
    "--camera",
    type=click.Choice(["fr1", "fr2", "fr3"]),
    default="fr1",
    show_default=True,
    help="Whose intrinsics and distortion.",
)
@click.option("--force", is_flag=True, help="Replace OUT.")
@options.jobs_option
def command(target: str, frames: int, seed: int, camera: str, force: bool, jobs: int) -> None:
    """Make a synthetic sequence in OUT, a folder or a .tgz file: a hand-held Kinect in a furnished room.

    The same options give the same bytes. Depth, accelerometer and ground truth agree with each other.
    """
    from tumtools.convert import ConvertOptions, convert
    from tumtools.formats.options import WriteOptions
    from tumtools.synthetic import synthesize

    sequence = synthesize(frames, seed, camera)
    # Reading it back would render every image again; `tumtools diff` proves the writer in the tests.
    how = ConvertOptions(verify=False, force=force)
    with output.progress_bar("synth", 2 * frames) as bar:
        report = convert(sequence, Path(target), "tum", WriteOptions(jobs=jobs), how, progress=bar)
    output.said(f"wrote {report.target}: {report.frames} images, {output.size(report.nbytes)}")
