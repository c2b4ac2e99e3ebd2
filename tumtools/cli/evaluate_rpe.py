# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools evaluate rpe`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from tumtools.cli import evaluation, evaluation_options, options, output

if TYPE_CHECKING:
    from tumtools.evaluate.allpairs import AllPairsResult
    from tumtools.evaluate.associate import Method
    from tumtools.evaluate.rpe import RpeResult, Unit

_DISTANCE = ("delta", "unit")
_FIXED_ONLY = (*_DISTANCE, "random", "max_pairs", "seed", "tum_output")
_MATCHING = ("max_difference", "method")
_ALL_ONLY = (*_MATCHING, "no_rotation")


@click.command(name="rpe")
@evaluation_options.pair_arguments
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
@evaluation_options.matching_options
@evaluation_options.time_options
@click.option("--save", metavar="FILE", help="Write the pairs and their errors; with --all-pairs, distances.")
@evaluation_options.file_options
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
    from tumtools.cli.evaluate_rpe_report import draw, show
    from tumtools.evaluate import documents, tables
    from tumtools.evaluate.allpairs import evaluate_rpe_all_pairs
    from tumtools.evaluate.rpe import RANDOM_PAIRS, Sampling, evaluate_rpe

    evaluation.one_output(tum_output=tum_output, json=as_json)
    if all_pairs:
        evaluation.without_effect(context, _FIXED_ONLY, "with --all-pairs")
    else:
        evaluation.without_effect(context, _ALL_ONLY, "without --all-pairs")
    if random:
        evaluation.without_effect(context, _DISTANCE, "with --random")
    elif not max_pairs:
        evaluation.without_effect(context, ("seed",), "without --random or --max-pairs")
    if interpolate:
        evaluation.without_effect(context, _MATCHING, "with --interpolate")
    evaluation.different_files(save, picture)
    true, judged = evaluation.read_pair(
        (groundtruth, groundtruth_topic), (estimate, estimate_topic), positions_do=(False, False)
    )
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
        draw(result, picture, force=force)
    if as_json:
        numbers = documents.all_pairs(average) if all_pairs else documents.rpe(pairs)
        output.print_json({"measure": "rpe", "groundtruth": groundtruth, "estimate": estimate} | numbers)
    elif tum_output:
        click.echo("\n".join(tables.rpe_as_scripts(pairs)))
    else:
        show(result)
