# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools evaluate rpe`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from tumtools.cli import evaluation, options, output
from tumtools.errors import UsageError

if TYPE_CHECKING:
    from tumtools.evaluate.allpairs import AllPairsResult
    from tumtools.evaluate.associate import Method
    from tumtools.evaluate.rpe import RpeResult, Unit

_FIXED_ONLY = ("delta", "unit", "random", "max_pairs", "seed", "tum_output")
_ALL_ONLY = ("max_difference", "method", "no_rotation")


@click.command(name="rpe")
@evaluation.pair_arguments
@click.option("--delta", type=float, default=1.0, show_default=True, help="Distance of the poses of a pair.")
@click.option(
    "--unit",
    type=click.Choice(["s", "m", "rad", "deg", "f"]),
    default="s",
    show_default=True,
    help="Of --delta: seconds, metres or angle along the estimate, frames.",
)
@click.option("--random", is_flag=True, help="Compare random pairs of any distance instead.")
@click.option(
    "--max-pairs", type=click.IntRange(2), metavar="N", help="Use at most N pairs, chosen by --seed."
)
@click.option(
    "--seed", type=click.IntRange(0, 2**64 - 1), default=0, show_default=True, help="Of the choice."
)
@click.option(
    "--all-pairs", is_flag=True, help="Average over all distances, exactly (equation 3 of the paper)."
)
@click.option("--no-rotation", is_flag=True, help="With --all-pairs: leave out the slower rotational part.")
@evaluation.matching_options
@evaluation.time_options
@click.option("--save", metavar="FILE", help="Write the pairs and their errors; with --all-pairs, distances.")
@evaluation.file_options
@options.json_option
@click.pass_context
def command(
    context: click.Context,
    groundtruth: str,
    estimate: str,
    groundtruth_topic: str | None,
    estimate_topic: str | None,
    delta: float,
    unit: Unit,
    random: bool,
    max_pairs: int | None,
    seed: int,
    all_pairs: bool,
    no_rotation: bool,
    max_difference: int,
    method: Method,
    offset: int,
    scale: float,
    interpolate: bool,
    max_hole: int | None,
    save: str | None,
    picture: str | None,
    tum_output: bool,
    force: bool,
    as_json: bool,
) -> None:
    """Relative pose error: how far ESTIMATE drifts over a distance, compared with GROUNDTRUTH.

    Both are trajectory files, sequences in any format, or names of sequences of the benchmark.
    A ground-truth pose may be as far in time as twice the median step of the ground truth, as in the
    benchmark's script; with --all-pairs, --max-difference and --method associate.
    """
    from tumtools.evaluate import documents, tables
    from tumtools.evaluate.allpairs import evaluate_rpe_all_pairs
    from tumtools.evaluate.rpe import RANDOM_PAIRS, Sampling, evaluate_rpe

    evaluation.one_output(tum_output=tum_output, json=as_json)
    _refuse(context, _FIXED_ONLY if all_pairs else _ALL_ONLY, all_pairs)
    true = evaluation.read_trajectory(groundtruth, groundtruth_topic, "--groundtruth-topic")
    judged = evaluation.read_trajectory(estimate, estimate_topic, "--estimate-topic")
    hole = evaluation.hole(interpolate, max_hole)
    result: AllPairsResult | RpeResult
    with evaluation.measuring(groundtruth, estimate):
        if all_pairs:
            result = average = evaluate_rpe_all_pairs(
                true,
                judged,
                rotation=not no_rotation,
                max_difference=max_difference,
                offset=offset,
                scale=scale,
                method=method,
                max_hole=hole,
            )
        else:
            sampling = Sampling(max_pairs or RANDOM_PAIRS, seed, random) if random or max_pairs else None
            result = pairs = evaluate_rpe(
                true,
                judged,
                delta=delta,
                unit=unit,
                sampling=sampling,
                offset=offset,
                scale=scale,
                max_hole=hole,
            )
    evaluation.print_notes(result.notes)
    if save:
        evaluation.write_text(
            save, tables.distances(average) if all_pairs else tables.rpe_pairs(pairs), force=force
        )
    if picture:
        _draw(result, picture, force=force)
    if as_json:
        numbers = documents.all_pairs(average) if all_pairs else documents.rpe(pairs)
        output.print_json({"measure": "rpe", "groundtruth": groundtruth, "estimate": estimate} | numbers)
    elif tum_output:
        click.echo("\n".join(tables.rpe_as_scripts(pairs)))
    else:
        _print(result)


def _refuse(context: click.Context, names: tuple[str, ...], all_pairs: bool) -> None:
    """Refuse options that have no effect here."""
    given = [
        f"--{name.replace('_', '-')}"
        for name in names
        if context.get_parameter_source(name) is click.core.ParameterSource.COMMANDLINE
    ]
    if given:
        raise UsageError(f"{given[0]} has no effect {'with' if all_pairs else 'without'} --all-pairs")


def _draw(result: AllPairsResult | RpeResult, picture: str, *, force: bool) -> None:
    from tumtools.evaluate.rpe import RpeResult
    from tumtools.plot.rpe import plot_distances, plot_rpe
    from tumtools.plot.style import save

    figure = plot_rpe(result) if isinstance(result, RpeResult) else plot_distances(result)
    save(figure, picture, force=force)


def _print(result: AllPairsResult | RpeResult) -> None:
    from tumtools.evaluate.rpe import RpeResult

    if not isinstance(result, RpeResult):
        click.echo(f"all {result.pairs} pairs of {result.poses} matched poses")
        click.echo(f"translation  {result.translation:.6f} m    mean over all distances of the RMSE")
        if result.rotation is not None:
            click.echo(f"rotation     {result.rotation:.6f} deg")
        return
    click.echo(
        f"{result.pairs} pairs of {result.estimate_count} estimated, {result.groundtruth_count} true poses; "
        f"{result.candidates - result.pairs} pairs without ground truth"
    )
    rotation = result.rotation.as_dict()
    rows = []
    for name, value in result.translation.as_dict().items():
        square = "2" if name == "sse" else ""
        rows.append((name, f"{value:.6f}", "m" + square, f"{rotation[name]:.6f}", "deg" + square))
    output.print_table(rows, ("relative error", "translation", "", "rotation", ""))
