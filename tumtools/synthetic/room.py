# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The room: an office of 5.2 x 4.6 x 2.6 m with desks, shelves, posters and clutter."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.synthetic.shapes import Finish, box, cylinder, quad, table

if TYPE_CHECKING:
    from tumtools.synthetic.shapes import Quad

HALF_X: Final = 2.6
HALF_Y: Final = 2.3
HEIGHT: Final = 2.6

_WALL = Finish("plaster", (0.78, 0.76, 0.70))
_BLUE_WALL = Finish("plaster", (0.42, 0.55, 0.66))
_CEILING = Finish("plaster", (0.85, 0.85, 0.83))
_FLOOR = Finish("wood", (0.46, 0.29, 0.15), 0.9)
_BEECH = Finish("veneer", (0.72, 0.58, 0.40))
_WHITE_BOARD = Finish("veneer", (0.83, 0.82, 0.79))
_STEEL = Finish("metal", (0.30, 0.31, 0.33), 0.55)
_BLACK = Finish("metal", (0.05, 0.05, 0.055), 0.3)
_SCREEN = Finish("screen", infrared=0.05, glow=True)
_CARTON = Finish("fabric", (0.58, 0.43, 0.27))
_SEAT = Finish("fabric", (0.10, 0.16, 0.33), 0.75)
_RUG = Finish("fabric", (0.50, 0.16, 0.13))
_BIN = Finish("metal", (0.10, 0.18, 0.45), 0.8)
_DARK_WOOD = Finish("veneer", (0.30, 0.18, 0.10))
_POSTER = Finish("poster")
_PAPER = Finish("paper")
_BOOKS = Finish("books", infrared=0.9)


def furnish(seed: int) -> list[Quad]:
    """Return all surfaces of the room; the seed decides the clutter and where pictures hang."""
    random = np.random.Generator(np.random.PCG64([seed, 1]))
    return [
        *_shell(),
        *_pictures(random),
        *_desk(random),
        *_side_desk(random),
        *_shelves(),
        *_floor_things(random),
    ]


def _shell() -> list[Quad]:
    x, y, z = HALF_X, HALF_Y, HEIGHT
    skirting = Finish("metal", (0.70, 0.68, 0.64))
    return [
        quad((-x, y, 0), (2 * x, 0, 0), (0, -2 * y, 0), _FLOOR),
        quad((-x, -y, z), (2 * x, 0, 0), (0, 2 * y, 0), _CEILING),
        quad((-x, y, z), (2 * x, 0, 0), (0, 0, -z), _WALL),
        quad((x, -y, z), (-2 * x, 0, 0), (0, 0, -z), _WALL),
        quad((x, y, z), (0, -2 * y, 0), (0, 0, -z), _BLUE_WALL),
        quad((-x, -y, z), (0, 2 * y, 0), (0, 0, -z), _WALL),
        quad((-x, y - 0.012, 0.09), (2 * x, 0, 0), (0, 0, -0.09), skirting),
        quad((x - 0.012, y, 0.09), (0, -2 * y, 0), (0, 0, -0.09), skirting),
        quad((-x + 0.012, -y, 0.09), (0, 2 * y, 0), (0, 0, -0.09), skirting),
        quad((-x + 0.02, -1.3, 2.15), (0, 1.5, 0), (0, 0, -1.2), Finish("window", infrared=0.0, glow=True)),
        quad((-0.5, 0.55, 0.005), (1.5, 0.15, 0), (0.09, -0.9, 0), _RUG),
    ]


def _pictures(random: np.random.Generator) -> list[Quad]:
    """Posters and notes on three walls, a hair's breadth in front of the plaster."""
    quads = []
    for left in (-2.45, -1.62, -0.78, 0.1, 0.95, 1.75):
        width, height = random.uniform(0.5, 0.72), random.uniform(0.45, 0.9)
        top = random.uniform(2.05, 2.35)
        corner = (left + random.uniform(0, 0.1), HALF_Y - 0.006, top)
        quads.append(quad(corner, (width, 0, 0), (0, 0, -height), _POSTER))
    for near in (1.9, 0.9, -0.2):
        top = random.uniform(1.95, 2.2)
        quads.append(quad((HALF_X - 0.006, near, top), (0, -0.7, 0), (0, 0, -0.55), _POSTER))
    for _ in range(9):
        left, top = random.uniform(-0.9, 1.3), random.uniform(1.15, 1.45)
        tilt = random.uniform(-0.02, 0.02)
        quads.append(quad((left, HALF_Y - 0.009, top), (0.15, 0, tilt), (tilt * 1.4, 0, -0.21), _PAPER))
    quads.append(quad((-2.594, 0.6, 2.1), (0, 0.9, 0), (0, 0, -0.7), Finish("checkerboard")))
    return quads


def _desk(random: np.random.Generator) -> list[Quad]:
    """Set up the long desk below the posters, with two monitors, a keyboard, books, mugs and paper."""
    top = 0.74
    quads = table((0.15, 1.78, 0.0), (2.2, 0.85, top), _BEECH, _STEEL)
    for x, yaw in ((-0.28, 9.0), (0.36, -12.0)):
        quads += box((x, 1.88, top), (0.26, 0.20, 0.015), _BLACK, yaw=yaw)
        quads += box((x, 1.93, top), (0.05, 0.04, 0.12), _BLACK, yaw=yaw)
        quads += box((x, 1.89, top + 0.11), (0.54, 0.045, 0.34), _BLACK, yaw=yaw, front=_SCREEN)
    keys = Finish("keyboard", (0.075, 0.075, 0.08), 0.7)
    quads += box((0.0, 1.53, top), (0.44, 0.15, 0.025), _BLACK, yaw=4.0, top=keys)
    quads += box((0.36, 1.51, top), (0.065, 0.11, 0.03), _BLACK, yaw=15.0)
    height = top
    for n in range(5):
        size = (random.uniform(0.17, 0.24), random.uniform(0.22, 0.30), random.uniform(0.02, 0.05))
        hue = (random.uniform(0.1, 0.7), random.uniform(0.1, 0.5), random.uniform(0.1, 0.6))
        cover = _POSTER if n == 4 else None  # noqa: PLR2004 - the uppermost book
        quads += box(
            (-0.72, 1.72, height), size, Finish("metal", hue), yaw=random.uniform(-25, 25), top=cover
        )
        height += size[2]
    for x, y, hue in ((0.62, 1.50, (0.75, 0.12, 0.10)), (-0.42, 1.55, (0.80, 0.80, 0.76))):
        quads += cylinder((x, y, top), 0.042, 0.10, Finish("metal", hue), top=None)
    for _ in range(7):
        x, y, turn = random.uniform(-0.85, 1.1), random.uniform(1.42, 1.7), random.uniform(-30, 30)
        quads += box(
            (x, y, top + random.uniform(0.001, 0.004)), (0.21, 0.297, 0.001), _PAPER, yaw=turn, top=_PAPER
        )
    quads += box((0.98, 1.95, top), (0.34, 0.26, 0.30), _CARTON, yaw=20.0, front=_PAPER)
    return quads


def _side_desk(random: np.random.Generator) -> list[Quad]:
    """Set up a white table along the right wall with cartons, a row of books and a lamp."""
    top = 0.72
    quads = table((2.15, 0.35, 0.0), (0.8, 1.7, top), _WHITE_BOARD, _STEEL)
    quads += box((2.25, 0.85, top), (0.36, 0.42, 0.26), _CARTON, yaw=-64.0, front=_POSTER)
    quads += box((2.28, 0.30, top), (0.55, 0.19, 0.25), _BOOKS, yaw=-90.0)
    quads += cylinder((2.0, -0.15, top), 0.09, 0.02, _STEEL, top=_STEEL)
    quads += cylinder((2.0, -0.15, top), 0.012, 0.42, _STEEL, top=None)
    quads += cylinder((2.0, -0.15, top + 0.38), 0.11, 0.16, Finish("fabric", (0.75, 0.66, 0.42)), top=None)
    for _ in range(3):
        x, y = random.uniform(1.9, 2.1), random.uniform(0.1, 0.8)
        quads += box(
            (x, y, top + random.uniform(0.001, 0.004)),
            (0.21, 0.297, 0.001),
            _PAPER,
            yaw=random.uniform(-90, 90),
        )
    return quads


def _shelves() -> list[Quad]:
    """Set up a book case in the far left corner."""
    x, y, width, depth, height = -1.75, 2.08, 0.95, 0.36, 1.25
    side = width / 2
    quads = box((x - side, y, 0), (0.025, depth, height), _DARK_WOOD)
    quads += box((x + side, y, 0), (0.025, depth, height), _DARK_WOOD)
    quads += box((x, y + depth / 2, 0), (width, 0.012, height), _DARK_WOOD)
    for level in (0.06, 0.45, 0.84, 1.225):
        quads += box((x, y, level), (width, depth, 0.025), _DARK_WOOD)
    for level, tall, share in ((0.085, 0.30, 0.9), (0.475, 0.28, 0.62), (0.865, 0.26, 0.78)):
        left = x - side + 0.02 + share * width / 2
        quads += box((left, y + 0.05, level), (share * width - 0.05, 0.2, tall), _DARK_WOOD, front=_BOOKS)
    quads += box((x - 0.2, y, height), (0.3, 0.26, 0.22), _CARTON, yaw=-12.0, front=_POSTER)
    return quads + cylinder(
        (x + 0.22, y - 0.02, height), 0.08, 0.24, Finish("metal", (0.15, 0.42, 0.30)), top=None
    )


def _floor_things(random: np.random.Generator) -> list[Quad]:
    """Scatter a chair, a bin, a case, a carton."""
    x, y, yaw = 0.05, 0.86, random.uniform(-35, 35)
    quads = box((x, y, 0.44), (0.46, 0.44, 0.07), _SEAT, yaw=yaw)
    quads += cylinder((x, y, 0.06), 0.03, 0.38, _STEEL, top=None)
    quads += box((x, y, 0.03), (0.6, 0.05, 0.04), _BLACK, yaw=yaw + 20)
    quads += box((x, y, 0.03), (0.05, 0.6, 0.04), _BLACK, yaw=yaw + 20)
    back = np.radians(yaw)
    quads += box(
        (x + 0.23 * float(np.sin(back)), y - 0.23 * float(np.cos(back)), 0.5),
        (0.42, 0.05, 0.42),
        _SEAT,
        yaw=yaw,
    )
    quads += cylinder((-1.0, 1.55, 0.0), 0.16, 0.34, _BIN, top=None)
    quads += box((0.75, 1.80, 0.0), (0.2, 0.5, 0.45), _BLACK)
    quads += box((1.45, 0.95, 0.0), (0.5, 0.36, 0.34), _CARTON, yaw=random.uniform(10, 40), front=_POSTER)
    return quads + box((-1.55, 0.9, 0.0), (0.55, 0.4, 0.42), _CARTON, yaw=random.uniform(-50, -20))
