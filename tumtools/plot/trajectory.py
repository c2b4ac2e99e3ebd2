# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Trajectories from above or from the side (figure 2 of the paper)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from tumtools.errors import InputError, UsageError
from tumtools.evaluate.trajectories import clean
from tumtools.plot.style import BLACK, CYCLE, GREY, broken_at_gaps, equal_axes, new_figure, style

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from tumtools.evaluate.geometry import Array
    from tumtools.model.signals import Trajectory

PLANES: Final = ("xy", "xz", "yz")
_ENDS: Final = (("o", "white", "start"), ("s", "", "end"))
_SHORT_LABEL: Final = 18
"""Labels up to this length fit side by side."""


def plot_trajectories(
    trajectories: Mapping[str, Trajectory], plane: str = "xy", title: str | None = None
) -> Figure:
    """Draw paths with their start and end; the first one in black, as the ground truth.

    Args:
        trajectories: Label -> poses.
        plane: One of `PLANES`; `xy` is the view from above.
        title: Above the picture.

    Raises:
        InputError: A trajectory has no usable row, or there is none.
        UsageError: An unknown plane.

    """
    if plane not in PLANES:
        msg = f"unknown plane {plane!r}; there are {', '.join(PLANES)}"
        raise UsageError(msg)
    if not trajectories:
        raise InputError("there is no trajectory to draw")
    columns = ["xyz".index(axis) for axis in plane]
    with style():
        figure = new_figure(5.6, 5.0)
        axes = figure.add_subplot()
        for number, (label, trajectory) in enumerate(trajectories.items()):
            poses = clean(trajectory, label, rotations=False).trajectory
            path = poses.positions[:, columns]
            color, line = (BLACK, "-") if number == 0 else CYCLE[(number - 1) % len(CYCLE)]
            drawn = broken_at_gaps(poses.stamps, path)
            axes.plot(*drawn.T, color=color, linestyle=line, linewidth=1.1 if number else 1.6, label=label)
            mark_ends(axes, path, color)
        for marker, fill, label in _ENDS:
            axes.plot(
                [], [], marker=marker, markerfacecolor=fill or GREY, color=GREY, linestyle="none", label=label
            )
        equal_axes(axes, plane[0], plane[1])
        if title:
            axes.set_title(title)
        longest = max(map(len, trajectories))
        figure.legend(loc="outside lower left", ncols=3 if longest <= _SHORT_LABEL else 1)
    return figure


def mark_ends(axes: Axes, path: Array, color: str) -> None:
    """Put an open circle on the start and a square on the end of a path [n, 2]."""
    for row, (marker, fill, _) in zip((0, -1), _ENDS, strict=True):
        axes.plot(
            *path[row],
            marker=marker,
            markersize=6.5,
            markerfacecolor=fill or color,
            markeredgecolor=color,
            markeredgewidth=1.4,
            linestyle="none",
            zorder=5,
        )
