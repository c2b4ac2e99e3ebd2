# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""How much light of the ceiling lamps reaches each surface, with soft shadows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy.typing as npt

    from tumtools.synthetic.shapes import Quad

    Vectors = npt.NDArray[np.float64]

_LAMP_POINTS: Final = ((-1.3, 0.1, 2.5), (-0.7, 0.4, 2.5), (0.8, 0.3, 2.5), (1.4, 0.6, 2.5))
"""Two long lamps at the ceiling, each as two points; metres."""
_LAMP_POWER: Final = 1.9
_AMBIENT: Final = 0.28
_PATCH: Final = 0.07
"""Metres between the points where light is worked out."""
_LIFT: Final = 0.003
"""Metres that these points stand above their surface."""
_CASTS_SHADOW: Final = 0.012
"""Square metres; smaller things cast none."""


def light_grids(quads: Sequence[Quad]) -> list[npt.NDArray[np.float32]]:
    """Return for each surface the light on a coarse grid from edge to edge, shape [rows, columns]."""
    shapes = [tuple(int(length / _PATCH) + 2 for length in reversed(quad.size)) for quad in quads]
    grids = [_grid_points(quad, *shape) for quad, shape in zip(quads, shapes, strict=True)]
    points = np.concatenate(grids)
    normals = np.concatenate(
        [np.broadcast_to(quad.normal, grid.shape) for quad, grid in zip(quads, grids, strict=True)]
    )
    casters = [quad for quad in quads if quad.size[0] * quad.size[1] > _CASTS_SHADOW]
    light = np.full(len(points), _AMBIENT)
    for lamp in _LAMP_POINTS:
        way = np.array(lamp) - points
        squared = (way * way).sum(axis=1)
        # Lambert's law on both ends: the lamps shine downwards.
        gain = _LAMP_POWER * (way * normals).sum(axis=1) * np.maximum(way[:, 2], 0) / (squared * squared)
        lit = np.flatnonzero(gain > 1e-3)  # noqa: PLR2004 - less is dark
        light[lit] += gain[lit] * ~_blocked(points[lit], way[lit], casters)
    ends = np.cumsum([len(grid) for grid in grids])[:-1]
    parts = np.split(light.astype(np.float32), ends)
    return [part.reshape(shape) for part, shape in zip(parts, shapes, strict=True)]


def _grid_points(quad: Quad, rows: int, columns: int) -> Vectors:
    """Return points from edge to edge, just above the surface, row by row, shape [rows * columns, 3]."""
    inset = _LIFT / 2
    along = np.linspace(inset, quad.size[0] - inset, columns)
    across = np.linspace(inset, quad.size[1] - inset, rows)
    points = (
        quad.origin
        + along[None, :, None] * quad.right
        + across[:, None, None] * quad.down
        + _LIFT * quad.normal
    )
    return points.reshape(-1, 3)


def _blocked(points: Vectors, ways: Vectors, quads: Sequence[Quad]) -> npt.NDArray[np.bool_]:
    """Tell which points [n, 3] have a surface between themselves and their lamp at point + way."""
    blocked = np.zeros(len(points), bool)
    x, y, z = (np.ascontiguousarray(column) for column in points.T)
    way_x, way_y, way_z = (np.ascontiguousarray(column) for column in ways.T)
    for quad in quads:
        (a, b, c), origin = quad.normal, quad.origin
        height = a * (x - origin[0]) + b * (y - origin[1]) + c * (z - origin[2])
        fall = a * way_x + b * way_y + c * way_z
        at = np.flatnonzero((height * (height + fall) < 0) & ~blocked)
        hit = points[at] - ways[at] * (height[at] / fall[at])[:, None] - origin
        u, v = (hit * quad.right).sum(axis=1), (hit * quad.down).sum(axis=1)
        blocked[at] = (u > 0) & (u < quad.size[0]) & (v > 0) & (v < quad.size[1])
    return blocked
