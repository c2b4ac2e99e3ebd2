# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Procedural surfaces: reflectance between 0 and 1 in red, green and blue."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy.typing as npt

    Floats = npt.NDArray[np.float32]
    Painter = Callable[["Surface"], Floats]

Colour = tuple[float, float, float]


class Surface:
    """A rectangle to paint: its texels, and its own stream of random numbers.

    Attributes:
        u: Metres along the first edge, shape [1, columns].
        v: Metres along the second edge, shape [rows, 1].
        random: Decides everything that is random about this surface.
        colour: Its main colour.

    """

    def __init__(self, size: tuple[float, float], texel: float, key: tuple[int, ...], colour: Colour) -> None:
        columns, rows = (max(4, round(length / texel)) for length in size)
        self.size = size
        self.u = ((np.arange(columns, dtype=np.float32) + 0.5) * np.float32(size[0] / columns))[None, :]
        self.v = ((np.arange(rows, dtype=np.float32) + 0.5) * np.float32(size[1] / rows))[:, None]
        self.random = np.random.Generator(np.random.PCG64(list(key)))
        self.colour = np.array(colour, np.float32)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of texels."""
        return self.v.shape[0], self.u.shape[1]

    def noise(self, grain_u: float, grain_v: float | None = None) -> Floats:
        """Return smooth noise in -1 .. 1, shape [rows, columns], with grains of so many metres."""
        grain_v = grain_u if grain_v is None else grain_v
        columns = int(self.size[0] / grain_u) + 3
        rows = int(self.size[1] / grain_v) + 3
        lattice = self.random.uniform(-1, 1, (rows, columns)).astype(np.float32)
        return sample(lattice, self.v / np.float32(grain_v), self.u / np.float32(grain_u))

    def stretch(self, grid: Floats) -> Floats:
        """Interpolate a grid that reaches from edge to edge; shape [rows, columns]."""
        rows, columns = grid.shape
        down = self.v * np.float32((rows - 1) / self.size[1])
        return sample(grid, down, self.u * np.float32((columns - 1) / self.size[0]))

    def fill(self, brightness: Floats | float) -> Floats:
        """Return the main colour times a brightness, shape [rows, columns, 3]."""
        field = np.broadcast_to(np.asarray(brightness, np.float32), self.shape)
        return field[..., None] * self.colour


def sample(lattice: Floats, rows: Floats, columns: Floats) -> Floats:
    """Interpolate a lattice bilinearly at rows [n, 1] and columns [1, m]."""
    top = np.minimum(rows[:, 0].astype(np.intp), lattice.shape[0] - 2)
    left = np.minimum(columns[0].astype(np.intp), lattice.shape[1] - 2)
    down, right = rows - top[:, None], columns - left
    # First along the columns of the lattice, which are few, then across.
    lines = lattice[top] * (1 - down).astype(np.float32) + lattice[top + 1] * down.astype(np.float32)
    mixed: Floats = lines[:, left]
    mixed += right.astype(np.float32) * (lines[:, left + 1] - mixed)
    return mixed


def plaster(surface: Surface) -> Floats:
    """Paint a wall: faint stains and grain."""
    return surface.fill(
        1 + 0.05 * surface.noise(0.7) + 0.03 * surface.noise(0.06) + 0.03 * surface.noise(0.012)
    )


def wood(surface: Surface) -> Floats:
    """Paint boards with long grain along the first edge."""
    board = 0.14
    which = (surface.v / board).astype(np.intp)
    tone = surface.random.uniform(0.8, 1.15, int(surface.size[1] / board) + 2).astype(np.float32)[which]
    grain = 0.16 * surface.noise(0.5, 0.008) + 0.1 * surface.noise(0.25, 0.03) + 0.05 * surface.noise(0.02)
    seam = np.where(surface.v % board < 0.005, np.float32(0.45), np.float32(1))  # noqa: PLR2004 - 5 mm
    return surface.fill(tone * (1 + grain) * seam)


def veneer(surface: Surface) -> Floats:
    """Paint a table top: one sheet of fine grain."""
    return surface.fill(
        1 + 0.07 * surface.noise(0.4, 0.01) + 0.05 * surface.noise(0.15) + 0.02 * surface.noise(0.01)
    )


def fabric(surface: Surface) -> Floats:
    """Paint woven cloth or carpet."""
    return surface.fill(1 + 0.12 * surface.noise(0.2) + 0.25 * surface.noise(0.012))


def metal(surface: Surface) -> Floats:
    """Paint plain lacquer with scratches."""
    return surface.fill(1 + 0.06 * surface.noise(0.3) + 0.08 * surface.noise(0.05, 0.004))


def poster(surface: Surface) -> Floats:
    """Paint a printed sheet: white margin, blocks of colour, a picture, lines of text."""
    random = surface.random
    width, height = surface.size
    sheet = np.full((*surface.shape, 3), 0.86, np.float32)
    u, v = surface.u / np.float32(width), surface.v / np.float32(height)
    for _ in range(random.integers(3, 6)):
        left, top = random.uniform(0.06, 0.6, 2)
        right, bottom = left + random.uniform(0.15, 0.5), top + random.uniform(0.1, 0.4)
        inside = (u > left) & (u < min(right, 0.94)) & (v > top) & (v < min(bottom, 0.94))
        sheet[inside] = random.uniform(0.08, 0.85, 3).astype(np.float32)
    picture = (u > 0.1) & (u < 0.9) & (v > 0.18) & (v < 0.5)  # noqa: PLR2004 - fractions of the sheet
    tint = [surface.noise(max(width, 0.05) / n) for n in (3.1, 5.3, 9.7)]
    image = 0.45 + 0.4 * np.stack(
        [tint[0] + tint[2] * 0.5, tint[1], tint[0] * tint[1] + tint[2] * 0.4], axis=-1
    )
    sheet[picture] = image[picture]
    return np.clip(_with_text(surface, sheet, 0.55, 0.92), 0.03, 0.95)


def paper(surface: Surface) -> Floats:
    """Paint a page of print."""
    sheet = np.full((*surface.shape, 3), 0.84, np.float32)
    return _with_text(surface, sheet, 0.08, 0.9)


def _with_text(surface: Surface, sheet: Floats, top: float, bottom: float) -> Floats:
    """Print words into a band of the sheet."""
    width, height = surface.size
    line = max(height / 32, 0.009)
    rows = (surface.v / np.float32(line)).astype(np.intp)
    letters = surface.random.uniform(0, 1, (int(height / line) + 2, int(width / line * 1.6) + 2))
    ink = letters[rows, (surface.u / np.float32(line / 1.6)).astype(np.intp)] > 0.3  # noqa: PLR2004 - share of ink
    fraction = surface.v / np.float32(height)
    ink &= (surface.v % line < 0.55 * line) & (fraction > top) & (fraction < bottom)
    ink &= (surface.u > 0.09 * width) & (surface.u < 0.91 * width)
    sheet[ink] = 0.16
    return sheet


def books(surface: Surface) -> Floats:
    """Paint a row of spines of different widths and colours, with titles."""
    random = surface.random
    width, height = surface.size
    count = int(width / 0.022) + 2
    edges = np.cumsum(random.uniform(0.014, 0.05, count)).astype(np.float32)
    which = np.searchsorted(edges, surface.u[0])
    hues = random.uniform(0.05, 0.75, (count + 1, 3)).astype(np.float32)
    top = random.uniform(0.0, 0.22, count + 1).astype(np.float32)[which]
    spine = np.broadcast_to(hues[which][None], (*surface.shape, 3)).copy()
    start = np.concatenate([[0], edges])[which]
    middle = np.abs(surface.u - (start + edges[which]) / 2) < 0.2 * (edges[which] - start)
    letters = random.uniform(0, 1, (int(height / 0.007) + 2, count + 1))
    title = letters[(surface.v / np.float32(0.007)).astype(np.intp), which] > 0.45  # noqa: PLR2004 - share
    fraction = surface.v / np.float32(height)
    title &= middle & (fraction > top + 0.12) & (fraction < 0.8)  # noqa: PLR2004 - fractions of the spine
    spine[title] = 0.85
    spine[np.broadcast_to(fraction < top, surface.shape)] = 0.06
    spine[np.broadcast_to((surface.u - start < 0.0025)[0], surface.shape)] *= np.float32(0.4)  # noqa: PLR2004 - metres, of this one thing
    worn: Floats = spine * (1 + 0.06 * surface.noise(0.02))[..., None]
    return worn


def screen(surface: Surface) -> Floats:
    """Paint a monitor that is on: windows with text on a dark desktop, in a black frame."""
    width, height = surface.size
    u, v = surface.u / np.float32(width), surface.v / np.float32(height)
    lit = np.empty((*surface.shape, 3), np.float32)
    lit[...] = np.stack([0.1 + 0.1 * v + 0 * u, 0.2 + 0.15 * u + 0 * v, 0.42 - 0.15 * v + 0 * u], axis=-1)
    panes = (((0.08, 0.62), (0.1, 0.8)), ((0.5, 0.95), (0.3, 0.9)))
    for (left, right), (top, bottom) in panes:
        pane = (u > left) & (u < right) & (v > top) & (v < bottom)
        lit[pane] = _with_text(surface, np.full_like(lit, 0.9), top + 0.06, bottom - 0.04)[pane]
        lit[pane & (v < top + 0.05)] = (0.25, 0.32, 0.5)
    rim = np.float32(0.018)
    frame = (surface.u < rim) | (surface.u > width - rim) | (surface.v < rim) | (surface.v > height - rim)
    lit[frame] = 0.04
    return lit


def keyboard(surface: Surface) -> Floats:
    """Paint dark keys with bright letters."""
    pitch = np.float32(0.019)
    gap = (surface.u % pitch < 0.003) | (surface.v % pitch < 0.003)  # noqa: PLR2004 - metres
    letter = (np.abs(surface.u % pitch - 0.009) < 0.002) & (np.abs(surface.v % pitch - 0.008) < 0.003)  # noqa: PLR2004 - metres, of this one thing
    return surface.fill(np.where(gap, 0.35, np.where(letter, 6.0, 1.0)).astype(np.float32))


def checkerboard(surface: Surface) -> Floats:
    """Paint the benchmark's kind of calibration target, with a white margin."""
    side = np.float32(min(surface.size) / 9)
    column, row = (surface.u / side).astype(np.intp), (surface.v / side).astype(np.intp)
    margin = (
        (surface.u < side)
        | (surface.v < side)
        | (surface.u > surface.size[0] - side)
        | (surface.v > surface.size[1] - side)
    )
    return surface.fill(np.where(margin | ((column + row) % 2 == 0), 0.88, 0.05).astype(np.float32))


def window(surface: Surface) -> Floats:
    """Paint a bright window: frame, panes, a hint of trees."""
    width, height = surface.size
    u, v = surface.u / np.float32(width), surface.v / np.float32(height)
    view = np.stack([0.8 - 0.1 * v + 0 * u, 0.9 - 0.1 * v + 0 * u, 1.0 - 0.15 * v + 0 * u], axis=-1)
    trees = (surface.noise(0.25) * 0.2 + v) > 0.62  # noqa: PLR2004 - horizon
    view[trees] = (np.array([0.3, 0.45, 0.2], np.float32) * (1 + 0.4 * surface.noise(0.04))[..., None])[trees]
    bars = (np.abs(u - 0.5) < 0.02) | (u < 0.03) | (u > 0.97) | (v < 0.04) | (v > 0.96)  # noqa: PLR2004 - fractions
    view[bars] = 0.78
    return view.astype(np.float32)


PAINTERS: Final[dict[str, Painter]] = {
    painter.__name__: painter
    for painter in (
        plaster,
        wood,
        veneer,
        fabric,
        metal,
        poster,
        paper,
        books,
        screen,
        keyboard,
        checkerboard,
        window,
    )
}
"""What a surface can be made of."""
