# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What `tumtools evaluate rpe` draws and prints."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from tumtools.cli import output
from tumtools.evaluate.rpe import RpeResult

if TYPE_CHECKING:
    from tumtools.evaluate.allpairs import AllPairsResult


def draw(result: AllPairsResult | RpeResult, picture: str, *, force: bool) -> None:
    """Draw a result into a file."""
    from tumtools.plot.rpe import plot_distances, plot_rpe
    from tumtools.plot.style import save

    figure = plot_rpe(result) if isinstance(result, RpeResult) else plot_distances(result)
    save(figure, picture, force=force)


def show(result: AllPairsResult | RpeResult) -> None:
    """Print a result for people."""
    if isinstance(result, RpeResult):
        _show_pairs(result)
        return
    click.echo(f"all {result.pairs} pairs of {result.poses} matched poses")
    click.echo(f"translation  {result.translation:.6f} m    mean over all distances of the RMSE")
    if result.rotation is not None:
        click.echo(f"rotation     {result.rotation:.6f} deg")


def _show_pairs(result: RpeResult) -> None:
    click.echo(
        f"{result.described} of {result.estimate_count} estimated, {result.groundtruth_count} true poses; "
        f"{result.candidates - result.pairs} pairs without ground truth"
    )
    rotation = result.rotation.as_dict()
    rows = []
    for name, value in result.translation.as_dict().items():
        square = "2" if name == "sse" else ""
        rows.append((name, f"{value:.6f}", "m" + square, f"{rotation[name]:.6f}", "deg" + square))
    output.print_table(rows, ("relative error", "translation", "", "rotation", ""))
