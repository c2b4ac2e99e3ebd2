# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Paint the surfaces and shine the lamps on them, once; rendering then only looks texels up."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from threading import Lock
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.synthetic.light import light_grids
from tumtools.synthetic.room import furnish
from tumtools.synthetic.textures import PAINTERS, Surface

if TYPE_CHECKING:
    import numpy.typing as npt

_LEVELS: Final = 4
"""Textures are kept at so many sizes, each half of the one before."""
_GAMMA: Final = 1 / 2.2
_BAKING: Final = Lock()


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """The room, ready to be rendered.

    Attributes:
        frames: Origin, first and second edge (unit vectors) and normal of each surface, shape [quads, 4, 3].
        sizes: Lengths of their edges, metres, shape [quads, 2].
        texel: Metres per texel at level 0.
        texels: All textures in one table, gamma applied, uint8, shape [n, 3].
        first: Index in `texels` of a texture, by level and surface, shape [levels, quads].
        columns: Texels in a row, by level and surface.
        rows: Rows of texels, by level and surface.
        infrared: How well the depth camera sees each surface, float32, shape [quads].

    """

    frames: npt.NDArray[np.float64]
    sizes: npt.NDArray[np.float64]
    texel: float
    texels: npt.NDArray[np.uint8]
    first: npt.NDArray[np.intp]
    columns: npt.NDArray[np.intp]
    rows: npt.NDArray[np.intp]
    infrared: npt.NDArray[np.float32]


def bake(seed: int, texel: float) -> Scene:
    """Build the room of a seed with textures of so many metres per texel; the latest one is kept.

    It takes seconds, so threads that want the same one wait for the first of them.
    """
    with _BAKING:
        return _bake(seed, texel)


@lru_cache(maxsize=1)
def _bake(seed: int, texel: float) -> Scene:
    quads = tuple(furnish(seed))
    tables: list[list[npt.NDArray[np.uint8]]] = [[] for _ in range(_LEVELS)]
    for number, (quad, grid) in enumerate(zip(quads, light_grids(quads), strict=True)):
        surface = Surface(quad.size, texel, (seed, 2, number), quad.finish.colour)
        paint = PAINTERS[quad.finish.material](surface)
        light = np.full((2, 2), 0.8, np.float32) if quad.finish.glow else grid
        shown: npt.NDArray[np.float32] = 255 * np.clip(
            paint * surface.stretch(light)[..., None], 0, 1
        ) ** np.float32(_GAMMA)
        for level in range(_LEVELS):
            tables[level].append(np.rint(shown).astype(np.uint8))
            shown = _halve(shown)
    shapes = np.array([[texture.shape[:2] for texture in level] for level in tables], np.intp)
    sizes = shapes[..., 0] * shapes[..., 1]
    return Scene(
        frames=np.array([[quad.origin, quad.right, quad.down, quad.normal] for quad in quads]),
        sizes=np.array([quad.size for quad in quads]),
        texel=texel,
        texels=np.concatenate([texture.reshape(-1, 3) for level in tables for texture in level]),
        first=(np.cumsum(sizes.ravel()) - sizes.ravel()).reshape(sizes.shape),
        columns=shapes[..., 1],
        rows=shapes[..., 0],
        infrared=np.array([quad.finish.infrared for quad in quads], np.float32),
    )


def _halve(texture: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Average 2 x 2 texels, down to a side of 2."""
    rows, columns = (max(2, length // 2) for length in texture.shape[:2])
    if min(texture.shape[:2]) < 4:  # noqa: PLR2004 - too small to halve both sides
        return texture
    even = texture[: 2 * rows, : 2 * columns]
    halved = even[::2, ::2] + even[1::2, ::2] + even[::2, 1::2] + even[1::2, 1::2]
    halved *= np.float32(0.25)
    return halved
