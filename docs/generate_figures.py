# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Draw the figures of the documentation from the synthetic sequence (`python docs/generate_figures.py`)."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.images.codec import pixels_of
from tumtools.plot.style import BLUE, GREY, VERMILION, new_figure, note, save, style
from tumtools.synthetic import synthesize
from tumtools.validate.depth_scale import DISPARITY_STEP, measure_depth_scale
from tumtools.validate.gravity import READINGS, fit_gravity

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy.typing as npt
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from tumtools.model.signals import Accelerometer, Trajectory

    Floats = npt.NDArray[np.float64]

FOLDER: Final = Path(__file__).resolve().parent / "explanation" / "figures"
_FRAMES: Final = 300
_UNITS: Final = 5000
_SHOWN_METRES: Final = (1.5, 3.0)
_RINGS_DEGREES: Final = (5, 10)
_EVERY: Final = 8
"""Of the poses, each n-th is drawn."""


def depth_scale() -> Figure:
    """Draw how the depths of one image lie, and which factor each of their steps means."""
    counts = np.unique(pixels_of(next(synthesize(1).images(["depth"])).load()))
    counts = counts[counts > 0]
    figure = new_figure(7.2, 3.0)
    left, right = figure.subplots(1, 2, width_ratios=(3, 2))
    depths = counts / _UNITS
    shown = depths[(depths >= _SHOWN_METRES[0]) & (depths <= _SHOWN_METRES[1])]
    for row, values in enumerate((_stretched(1 / shown), _stretched(shown))):
        left.vlines(values, row - 0.3, row + 0.3, color=BLUE, linewidth=0.8)
    left.set_yticks([0, 1], ["1/Z", "Z"])
    left.set_xticks([0, 1], [f"{shown[0]:.2f} m", f"{shown[-1]:.2f} m"])
    left.grid(visible=False)
    left.set_title("All depths that occur")
    note(left, "even in 1/Z only")
    millimetres = np.unique(np.rint(counts / 5).astype(np.uint16))
    for values, colour, name in ((counts, BLUE, "1/5000 m"), (millimetres, VERMILION, "millimetres")):
        _draw_factors(right, values, colour, name)
    right.set_xscale("log")
    right.set_xticks([500, 1000, 2000, 5000], ["500", "1000", "2000", "5000"])
    right.minorticks_off()
    right.set_xlabel("counts a metre that one step means")
    right.set_ylabel("steps")
    right.set_title("The factor")
    right.legend(loc="upper center")
    return figure


def _stretched(values: Floats) -> Floats:
    """Map the smallest depth to 0 and the greatest to 1."""
    result: Floats = (values - values[0]) / (values[-1] - values[0])
    return result


def _draw_factors(axes: Axes, counts: npt.NDArray[np.uint16], colour: str, name: str) -> None:
    far = counts[len(counts) // 3 :].astype(np.float64)  # nearer ones are hidden by rounding, as in the rule
    factors = DISPARITY_STEP / -np.diff(1 / far)
    axes.hist(factors, np.geomspace(400, 8000, 60).tolist(), color=colour, alpha=0.8, label=name)
    scale = measure_depth_scale(counts)
    if scale is not None:
        axes.axvline(scale.units_per_metre, color=colour, linestyle="--", linewidth=0.8)


def gravity() -> Figure:
    """Draw from above where accelerations point in the world, for three readings of the quaternions."""
    sequence = synthesize(_FRAMES, streams=("groundtruth", "accelerometer"))
    poses, accelerations = sequence.groundtruth, sequence.accelerometer
    figure = new_figure(7.2, 2.6)
    if poses is None or accelerations is None:
        return figure
    readings = list(READINGS)[:3]
    for axes, reading in zip(figure.subplots(1, len(readings)), readings, strict=True):
        fit = fit_gravity(poses, accelerations, reading)
        if fit is not None:
            _draw_directions(axes, _around(poses, accelerations, reading, np.array(fit.up)))
            axes.set_title(reading)
            note(axes, f"{fit.rms_degrees:.1f}° rms")
    return figure


def _around(poses: Trajectory, accelerations: Accelerometer, reading: str, up: Floats) -> Floats:
    """Return by how many degrees each acceleration, turned into the world, is off the common direction.

    Returns:
        Along two axes at right angles to it, shape [n, 2].

    """
    order, inverse = READINGS[reading]
    x, y, z, w = poses.quaternions[::_EVERY, list(order)].T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    matrices = np.array(rows).transpose((2, 1, 0) if inverse else (2, 0, 1))
    window = np.ones(51) / 51  # 0.1 s at 500 Hz
    smooth = np.stack([np.convolve(column, window, mode="same") for column in accelerations.values.T])
    times, at = accelerations.stamps.astype(np.float64), poses.stamps[::_EVERY].astype(np.float64)
    means = np.stack([np.interp(at, times, column) for column in smooth], axis=1)
    means /= np.linalg.norm(means, axis=1, keepdims=True)
    # Given the direction, the best mounting of the accelerometer follows from one decomposition.
    left, _, right = np.linalg.svd(np.einsum("ijk,j,il->kl", matrices, up, means))
    mounting = left @ np.diag([1, 1, np.linalg.det(left) * np.linalg.det(right)]) @ right
    in_world = np.einsum("ijk,ik->ij", matrices, means @ mounting.T)
    first = np.cross(up, [0.0, 1.0, 0.0] if abs(up[1]) < 0.9 else [1.0, 0.0, 0.0])  # noqa: PLR2004 - not along it
    first /= np.linalg.norm(first)
    across = np.stack([in_world @ first, in_world @ np.cross(up, first)], axis=1)
    inside = slice(10, -10)  # the means at the ends lack a half
    result: Floats = np.degrees(np.arcsin(np.clip(across[inside], -1, 1)))
    return result


def _draw_directions(axes: Axes, degrees: Floats) -> None:
    turn = np.linspace(0, 2 * np.pi, 60)
    for ring in _RINGS_DEGREES:
        axes.plot(ring * np.cos(turn), ring * np.sin(turn), color=GREY, linewidth=0.8)
        axes.text(0, ring, f"{ring}°", fontsize=7, ha="center", va="bottom")
    axes.plot(*degrees.T, ".", color=BLUE, markersize=3)
    axes.set_aspect("equal")
    axes.set(xlim=(-12, 12), ylim=(-12, 12), xticks=[], yticks=[])
    axes.spines[:].set_visible(False)
    axes.grid(visible=False)


FIGURES: Final[dict[str, Callable[[], Figure]]] = {
    "depth-scale.png": depth_scale,
    "quaternion-order.png": gravity,
}


def main(folder: Path = FOLDER) -> None:
    """Draw all figures into a folder."""
    for name, draw in FIGURES.items():
        with style():
            figure = draw()
        save(figure, folder / name, force=True)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
