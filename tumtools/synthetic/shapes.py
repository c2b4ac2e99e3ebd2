# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Rectangles in space, and bodies made of them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt

    from tumtools.synthetic.textures import Colour

    Vector = npt.NDArray[np.float64]

Point = tuple[float, float, float]
_FACETS: Final = 24


@dataclass(frozen=True, slots=True, eq=False)
class Finish:
    """What a face is made of.

    Attributes:
        material: A key of `textures.PAINTERS`.
        colour: Main colour.
        infrared: How well the depth camera sees it: 1 for matt and bright, 0 for not at all.
        glow: It shines by itself; no lamp is needed to see it.

    """

    material: str
    colour: Colour = (1.0, 1.0, 1.0)
    infrared: float = 1.0
    glow: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Quad:
    """A rectangle that is seen from one side.

    Attributes:
        origin: Its upper left corner as the viewer sees it, metres in the world, shape [3].
        right: Unit vector to the viewer's right.
        down: Unit vector downwards.
        size: Lengths of the two edges, metres.
        finish: What it is made of.

    """

    origin: Vector
    right: Vector
    down: Vector
    size: tuple[float, float]
    finish: Finish

    @property
    def normal(self) -> Vector:
        """Unit vector towards the viewer."""
        return np.cross(self.down, self.right)


def quad(corner: Point | Vector, right: Point | Vector, down: Point | Vector, finish: Finish) -> Quad:
    """Return a rectangle from its upper left corner and its two edges, whose lengths are its size."""
    edges = [np.asarray(edge, np.float64) for edge in (right, down)]
    lengths = [float(np.sqrt((edge * edge).sum())) for edge in edges]
    unit = [edge / length for edge, length in zip(edges, lengths, strict=True)]
    return Quad(np.asarray(corner, np.float64), unit[0], unit[1], (lengths[0], lengths[1]), finish)


def box(
    base: Point,
    size: Point,
    finish: Finish,
    *,
    yaw: float = 0.0,
    front: Finish | None = None,
    top: Finish | None = None,
) -> list[Quad]:
    """Return the six faces of a box.

    Args:
        base: Centre of the bottom face.
        size: Width (x), depth (y), height (z) before it is turned.
        finish: Of all faces.
        yaw: Turn about z, degrees.
        front: Of the face towards -y, if it differs.
        top: Of the face towards +z, if it differs; its text is read from -y.

    """
    x, y, z = _axes(size, yaw)
    low = np.array(base) - (x + y) / 2
    return [
        quad(low + z, x, -z, front or finish),
        quad(low + x + z, y, -z, finish),
        quad(low + x + y + z, -x, -z, finish),
        quad(low + y + z, -y, -z, finish),
        quad(low + y + z, x, -y, top or finish),
        quad(low, x, y, finish),
    ]


def _axes(size: Point, yaw: float) -> tuple[Vector, Vector, Vector]:
    c, s = math.cos(math.radians(yaw)), math.sin(math.radians(yaw))
    return size[0] * np.array([c, s, 0.0]), size[1] * np.array([-s, c, 0.0]), np.array([0.0, 0.0, size[2]])


def table(base: Point, size: Point, top: Finish, legs: Finish, *, yaw: float = 0.0) -> list[Quad]:
    """Return a table: a board of 3 cm on four legs.

    Args:
        base: Middle between the feet.
        size: Width, depth, and height of the upper side.
        top: Finish of the board.
        legs: Finish of the legs.
        yaw: Turn about z, degrees.

    """
    width, depth, height = size
    x, y, _ = _axes((1, 1, 1), yaw)
    thick = 0.03
    quads = box((base[0], base[1], base[2] + height - thick), (width, depth, thick), top, yaw=yaw)
    for sx in (-1, 1):
        for sy in (-1, 1):
            foot = np.array(base) + sx * (width / 2 - 0.06) * x + sy * (depth / 2 - 0.06) * y
            leg = (float(foot[0]), float(foot[1]), float(foot[2]))
            quads += box(leg, (0.05, 0.05, height - thick), legs, yaw=yaw)
    return quads


def cylinder(base: Point, radius: float, height: float, finish: Finish, *, top: Finish | None) -> list[Quad]:
    """Return a standing cylinder of flat facets, open above or with a square top."""
    angles = [2 * math.pi * n / _FACETS for n in range(_FACETS + 1)]
    rim = [
        np.array([base[0] + radius * math.cos(a), base[1] + radius * math.sin(a), base[2]]) for a in angles
    ]
    up = np.array([0.0, 0.0, height])
    quads = [quad(rim[n] + up, rim[n + 1] - rim[n], -up, finish) for n in range(_FACETS)]
    if top is None:
        return quads + [quad(rim[n + 1] + up, rim[n] - rim[n + 1], -up, finish) for n in range(_FACETS)]
    half = radius / math.sqrt(2)
    corner = np.array([base[0] - half, base[1] + half, base[2] + height])
    return [*quads, quad(corner, (2 * half, 0.0, 0.0), (0.0, -2 * half, 0.0), top)]
