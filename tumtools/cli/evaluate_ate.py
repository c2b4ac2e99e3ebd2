# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools evaluate ate`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from tumtools.cli import evaluation, evaluation_options, options, output

if TYPE_CHECKING:
    from tumtools.evaluate.align import Mode
    from tumtools.evaluate.associate import Method
    from tumtools.evaluate.ate import AteResult


@click.command(name="ate")
@evaluation_options.pair_arguments
@click.option(
    "--align",
    "alignment",
    type=click.Choice(["se3", "sim3", "none"]),
    default="se3",
    show_default=True,
    help="Rotate and move the estimate onto the ground truth; and scale it; or not.",
)
@evaluation_options.matching_options
@evaluation_options.time_options
@click.option("--save", metavar="FILE", help="Write the aligned estimate: stamp x y z.")
@click.option("--save-trajectory", metavar="FILE", help="Write the aligned estimate as a trajectory file.")
@click.option("--save-associations", metavar="FILE", help="Write the pairs: stamp1 x1 y1 z1 stamp2 x2 y2 z2.")
@evaluation_options.file_options
@options.json_option
@click.pass_context
def command(
    context: click.Context,
    groundtruth: str,
    estimate: str,
    groundtruth_topic: str | None,
    estimate_topic: str | None,
    alignment: Mode,
    max_difference: int,
    method: Method,
    offset: int,
    scale: float,
    interpolate: bool,
    max_hole: int | None,
    save: str | None,
    save_trajectory: str | None,
    save_associations: str | None,
    picture: str | None,
    tum_output: bool,
    force: bool,
    as_json: bool,
) -> None:
    """Absolute trajectory error: how far the aligned ESTIMATE is from GROUNDTRUTH.

    Both are trajectory files, sequences in any format, or names of sequences of the benchmark.
    """
    from tumtools.evaluate import documents, tables
    from tumtools.evaluate.ate import evaluate_ate

    evaluation.one_output(tum_output=tum_output, json=as_json)
    if interpolate:
        evaluation.without_effect(context, ("max_difference", "method"), "with --interpolate")
    evaluation.different_files(save, save_trajectory, save_associations, picture)
    true, judged = evaluation.read_pair(
        (groundtruth, groundtruth_topic), (estimate, estimate_topic), positions_do=(not interpolate, True)
    )
    with evaluation.measuring(groundtruth, estimate):
        result = evaluate_ate(
            true,
            judged,
            alignment=alignment,
            max_difference=max_difference,
            offset=offset,
            scale=scale,
            method=method,
            max_hole=evaluation.hole(interpolate, max_hole),
        )
    evaluation.print_notes(result.notes)
    for path, render in (
        (save, tables.aligned_positions),
        (save_trajectory, lambda found: tables.aligned_trajectory(found.aligned)),
        (save_associations, tables.ate_pairs),
    ):
        if path:
            evaluation.write_text(path, render(result), force=force)
    if picture:
        from tumtools.plot.ate import plot_ate
        from tumtools.plot.style import save as save_picture

        save_picture(plot_ate(result), picture, force=force)
    if as_json:
        output.print_json(
            {"measure": "ate", "groundtruth": groundtruth, "estimate": estimate} | documents.ate(result)
        )
    elif tum_output:
        click.echo("\n".join(tables.ate_as_scripts(result)))
    else:
        _print(result, "interpolated" if interpolate else "")


def _print(result: AteResult, how: str) -> None:
    click.echo(
        f"{result.pairs} pairs of {result.estimate_count} estimated, {result.groundtruth_count} true poses, "
        + (how or f"at most {result.largest_difference / 1e6:.3f} ms apart")
    )
    if result.alignment.scale != 1.0:
        click.echo(f"scale of the alignment: {result.alignment.scale:.6f}")
    units = {"sse": "m2"}
    rows = [
        (name, f"{value:.6f}", units.get(name, "m")) for name, value in result.statistics.as_dict().items()
    ]
    output.print_table(rows, ("absolute error", "translation", ""))
