# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Absolute trajectory error (figure 7a of the paper)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap

from tumtools.plot.style import BLACK, ERROR_MAP, GREY, broken_at_gaps, equal_axes, new_figure, note, style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tumtools.evaluate.ate import AteResult


def plot_ate(result: AteResult, title: str | None = None) -> Figure:
    """Draw ground truth and aligned estimate from above, the estimate coloured by its error.

    Every matched pose is joined with its ground truth; long grey lines are large errors.

    Args:
        result: Of `evaluate_ate`.
        title: Above the picture.

    """
    true, judged = result.groundtruth.positions[:, :2], result.estimate.positions[:, :2]
    with style():
        figure = new_figure(6.2, 5.0)
        axes = figure.add_subplot()
        axes.add_collection(
            LineCollection(
                list(np.stack([true, judged], axis=1)), colors=GREY, linewidths=0.5, label="difference"
            )
        )
        path = broken_at_gaps(result.groundtruth.stamps, true)
        axes.plot(*path.T, color=BLACK, linewidth=1.0, label="ground truth")
        points = axes.scatter(
            judged[:, 0],
            judged[:, 1],
            c=result.errors,
            cmap=LinearSegmentedColormap.from_list("error", ERROR_MAP),
            s=5.0,
            vmin=0.0,
            zorder=3,
            linewidths=0.0,
            label="estimate",
        )
        bar = figure.colorbar(points, ax=axes, fraction=0.045, pad=0.02)
        bar.set_label("absolute trajectory error (m)")
        equal_axes(axes, "x", "y")
        axes.set_title(title or "Absolute trajectory error")
        note(axes, f"RMSE {result.statistics.rmse:.4f} m of {result.pairs} poses")
        figure.legend(loc="outside lower center", ncols=3)
    return figure
