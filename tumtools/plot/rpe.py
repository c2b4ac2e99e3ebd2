# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Relative pose error over time (figure 6 of the paper), and against the distance of the pairs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tumtools.model.time import format_stamp
from tumtools.plot.style import BLACK, BLUE, VERMILION, broken_at_gaps, new_figure, note, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from tumtools.evaluate.allpairs import AllPairsResult
    from tumtools.evaluate.geometry import Array
    from tumtools.evaluate.rpe import RpeResult

_ROWS = (("translation", "m", BLUE), ("rotation", "deg", VERMILION))


def plot_rpe(result: RpeResult, title: str | None = None) -> Figure:
    """Draw the errors of pairs over the time of their first pose.

    Args:
        result: Of `evaluate_rpe`.
        title: Above the picture.

    """
    order = np.argsort(result.estimate_stamps[:, 0], kind="stable")
    stamps = result.estimate_stamps[order, 0]
    seconds = (stamps - stamps[0]) / 1e9
    errors = (result.translational_errors[order], np.degrees(result.rotational_errors[order]))
    rmse = (result.translation.rmse, result.rotation.rmse)
    with style():
        figure = new_figure(6.6, 4.8)
        for axes, (what, unit, color), error, level in zip(
            figure.subplots(2, 1, sharex=True), _ROWS, errors, rmse, strict=True
        ):
            if result.delta is None:  # neighbours have nothing in common that a line could show
                axes.plot(seconds, error, ".", color=color, markersize=1.5)
            else:
                line = broken_at_gaps(stamps, np.stack([seconds, error], axis=1))
                axes.plot(*line.T, color=color, linewidth=0.9)
            _finish(axes, f"{what} ({unit})", level, f"dashed: RMSE {level:.4g} {unit}")
        axes.set_xlabel(f"time of the pair's first pose (s since {format_stamp(int(stamps[0]), 9)})")
        figure.align_ylabels()
        figure.axes[0].set_title(title or f"Relative pose error, {result.described}")
    return figure


def _finish(axes: Axes, label: str, level: float, text: str) -> None:
    """Draw a level, and label a panel whose values are not negative."""
    axes.axhline(level, color=BLACK, linewidth=1.0, linestyle=(0, (4, 2)))
    axes.set_ylabel(label)
    axes.set_ylim(bottom=0.0)
    axes.margins(x=0.01)
    note(axes, text)


def plot_distances(result: AllPairsResult, title: str | None = None) -> Figure:
    """Draw RMSE(D) against the distance of the poses, and the average over all distances.

    Args:
        result: Of `evaluate_rpe_all_pairs`.
        title: Above the picture.

    """
    seconds = np.arange(1, result.poses) * (result.step / 1e9)
    curves: list[tuple[Array, float]] = [(result.translational_rmse, result.translation)]
    if result.rotational_rmse is not None and result.rotation is not None:
        curves.append((result.rotational_rmse, result.rotation))
    with style():
        figure = new_figure(6.6, 2.4 * len(curves))
        grid = figure.subplots(len(curves), 1, sharex=True, squeeze=False)[:, 0]
        for axes, (what, unit, color), (rmse, mean) in zip(grid, _ROWS, curves, strict=False):
            axes.plot(seconds, rmse, color=color)
            _finish(axes, f"{what} RMSE ({unit})", mean, f"dashed: mean {mean:.4g} {unit}")
        axes.set_xlabel(f"distance of the poses (s), 1 frame = {result.step / 1e6:.1f} ms")
        figure.align_ylabels()
        figure.axes[0].set_title(title or f"Relative pose error, all {result.pairs} pairs")
    return figure
