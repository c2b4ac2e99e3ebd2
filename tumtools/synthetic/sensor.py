# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What a first-generation Kinect makes of a view: its colour, its infrared image, and above all its depth.

The depth camera triangulates a projected pattern: disparity f b / Z comes in steps of 1/8 pixel, hence
depths on a grid that is uniform in 1/Z. See `docs` on the physical checks, which find this grid again.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.synthetic.textures import sample

if TYPE_CHECKING:
    import numpy.typing as npt

    from tumtools.synthetic.bake import Scene
    from tumtools.synthetic.render import View

    Plane = npt.NDArray[np.float32]

FOCAL_BASELINE: Final = 580.0 * 0.075
"""Focal length (pixels) times the distance of projector and camera (metres)."""
STEPS_PER_PIXEL: Final = 8
UNITS_PER_METRE: Final = 5000

_NEAREST: Final = 0.5
_FARTHEST: Final = 9.0
_COUNTABLE: Final = 13.0
_WORKING_DISTANCE: Final = 4.5
"""Metres at which a matt surface seen at right angles begins to be too dim for the depth camera."""
_REGISTRATION_BORDER: Final = (38 / 480, 2 / 480, 14 / 640, 41 / 640)
"""Share of the image (top, bottom, left, right) that has no depth once it is registered to colour."""
_EDGE_JUMP: Final = 0.06
"""Relative jump of depth that makes an edge."""
_READ_NOISE: Final = 1.6
_SHOT_NOISE: Final = 0.21
"""Noise of a colour channel of value c has the deviation read + shot * sqrt(c), out of 255."""


def _smooth_noise(random: np.random.Generator, shape: tuple[int, int], grain: float) -> Plane:
    """Return noise that is smooth over `grain` pixels; normal at the lattice points."""
    rows, columns = int(shape[0] / grain) + 3, int(shape[1] / grain) + 3
    lattice = random.standard_normal((rows, columns), np.float32)
    y = np.arange(shape[0], dtype=np.float32)[:, None] / np.float32(grain)
    x = np.arange(shape[1], dtype=np.float32)[None, :] / np.float32(grain)
    return sample(lattice, y, x)


def depth_image(scene: Scene, view: View, random: np.random.Generator) -> npt.NDArray[np.uint16]:
    """Return depth as the benchmark stores it: 5000 counts a metre, truncated, 0 for no reading.

    Args:
        scene: The room.
        view: What each pixel sees.
        random: Noise.

    """
    shape = view.depth.shape
    pixel = 640 / shape[1]
    depth = _ragged(view.depth, random, pixel)
    disparity = np.float32(FOCAL_BASELINE) / depth
    steps = np.rint(disparity * STEPS_PER_PIXEL + np.float32(0.3) * _smooth_noise(random, shape, 4 / pixel))
    metres = FOCAL_BASELINE * STEPS_PER_PIXEL / steps.astype(np.float64)
    counts: npt.NDArray[np.uint16] = np.floor(UNITS_PER_METRE * np.minimum(metres, _COUNTABLE)).astype(
        np.uint16
    )
    counts[_no_reading(scene, view, depth, disparity / np.float32(pixel), random)] = 0
    return counts


def _ragged(depth: Plane, random: np.random.Generator, pixel: float) -> Plane:
    """Fray the outlines: near an edge, each pixel takes the depth of a neighbour two or so pixels off."""
    rows, columns = depth.shape
    reach = max(1, round(3 / pixel))
    edge = np.zeros(depth.shape, bool)
    for axis in (0, 1):
        ahead = np.roll(depth, -reach, axis)
        behind = np.roll(depth, reach, axis)
        edge |= np.abs(ahead - behind) > np.float32(_EDGE_JUMP) * depth
    y, x = np.nonzero(edge)
    shift = [
        np.rint(1.5 / pixel * _smooth_noise(random, depth.shape, 3))[y, x].astype(np.intp) for _ in range(2)
    ]
    frayed = depth.copy()
    frayed[y, x] = depth[np.clip(y + shift[0], 0, rows - 1), np.clip(x + shift[1], 0, columns - 1)]
    return frayed


def _no_reading(
    scene: Scene, view: View, depth: Plane, shift: Plane, random: np.random.Generator
) -> npt.NDArray[np.bool_]:
    """Tell where the depth camera gets nothing.

    Args:
        scene: The room.
        view: What each pixel sees.
        depth: Metres.
        shift: Disparity in pixels of this image.
        random: Noise.

    """
    rows, columns = depth.shape
    pixel = 640 / columns
    # The projector stands to the right. A ray of its light meets a row of pixels in the order of
    # column - disparity; a pixel that a later column overtakes lies in the shadow of what is there.
    ray = np.arange(columns, dtype=np.float32) - shift
    overtaken_by = np.minimum.accumulate(ray[:, ::-1], axis=1)[:, ::-1]
    missing = ray > overtaken_by + np.float32(1.5 / pixel)
    missing |= (depth < _NEAREST) | (depth > _FARTHEST)
    reflected = scene.infrared[np.maximum(view.surface, 0)] * view.slope
    strength = reflected * np.minimum((np.float32(_WORKING_DISTANCE) / depth) ** 2, 4)
    luck = (
        1 + 0.2 * _smooth_noise(random, depth.shape, 9 / pixel) + 0.1 * _smooth_noise(random, depth.shape, 3)
    )
    missing |= strength * luck < 0.26  # noqa: PLR2004 - least signal, of a matt surface at 4.5 m
    top, bottom, left, right = _REGISTRATION_BORDER
    missing[: round(top * rows)] = True
    missing[rows - round(bottom * rows) :] = True
    missing[:, : round(left * columns)] = True
    missing[:, columns - round(right * columns) :] = True
    return missing


def colour_image(shaded: Plane, random: np.random.Generator) -> npt.NDArray[np.uint8]:
    """Return what the colour camera delivers: a little soft, darker in the corners, noisy.

    Args:
        shaded: Noise-free colour, 0 .. 255, shape [height, width, 3].
        random: Noise.

    """
    image: Plane = _soften(shaded) * _vignette(shaded.shape[0], shaded.shape[1])[..., None]
    deviation = np.float32(_READ_NOISE) + np.float32(_SHOT_NOISE) * np.sqrt(image)
    image += deviation * random.standard_normal(image.shape, np.float32)
    pixels: npt.NDArray[np.uint8] = np.clip(np.rint(image), 0, 255).astype(np.uint8)
    return pixels


def infrared_image(view: View, shaded: Plane, random: np.random.Generator) -> npt.NDArray[np.uint8]:
    """Return what the infrared camera delivers with the projector covered: grey, 8 bit.

    Args:
        view: What each pixel sees.
        shaded: Noise-free colour, 0 .. 255, shape [height, width, 3].
        random: Noise.

    """
    red, green, blue = np.moveaxis(shaded, 2, 0)
    grey: Plane = (0.5 * red + 0.35 * green + 0.15 * blue) * np.clip(2.5 / view.depth, 0.3, 1.0)
    grey *= _vignette(*grey.shape)
    grey += 5 * random.standard_normal(grey.shape, np.float32)
    pixels: npt.NDArray[np.uint8] = np.clip(np.rint(grey), 0, 255).astype(np.uint8)
    return pixels


def _soften(image: Plane) -> Plane:
    """Blur with 1 2 1 both ways, as the interpolation between a Bayer sensor's pixels does."""
    padded = np.pad(image, ((1, 1), (1, 1), (0, 0)), mode="edge")
    rows = padded[:-2] + np.float32(2) * padded[1:-1] + padded[2:]
    both: Plane = rows[:, :-2] + np.float32(2) * rows[:, 1:-1] + rows[:, 2:]
    both *= np.float32(1 / 16)
    return both


def _vignette(rows: int, columns: int) -> Plane:
    y = np.linspace(-1, 1, rows, dtype=np.float32)[:, None]
    x = np.linspace(-1, 1, columns, dtype=np.float32)[None, :]
    fall: Plane = 1 - np.float32(0.09) * (x * x + y * y)
    return fall
