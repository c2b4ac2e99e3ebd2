# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The two forms of an image: give me pixels, give me a PNG file."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tumtools.errors import InputError, UnsupportedInputError
from tumtools.images import png
from tumtools.images.depth import to_metres
from tumtools.images.parallel import take_room
from tumtools.model.image import ENCODINGS, Image

if TYPE_CHECKING:
    import numpy.typing as npt

_SWAPPED = {"bgr8": "rgb8", "bgra8": "rgba8"}


def image_of_png(
    data: bytes | memoryview, depth_units_per_metre: float | None = None, origin: str | None = None
) -> Image:
    """Wrap a PNG file. Only its header is read; what is damaged behind it is found when it is used.

    Args:
        data: The file.
        depth_units_per_metre: Given for depth.
        origin: Where it comes from, for messages.

    Raises:
        InputError: This is no PNG file, or no depth where depth was expected.

    """
    with _Named(origin):
        found = png.peek(data)
        if depth_units_per_metre is not None and not found.is_grey16:
            raise InputError(
                f"a depth image is a PNG of 16-bit grey; this one has {found.bit_depth} bits, "
                f"colour type {found.colour_type}",
                location="offset 24",
            )
    encoding = found.encoding
    if depth_units_per_metre is None and encoding == "16UC1":
        encoding = "mono16"
    return Image(
        width=found.width,
        height=found.height,
        encoding=encoding,
        depth_units_per_metre=depth_units_per_metre,
        compressed=data,
        compression="png",
        origin=origin,
    )


class _Named:
    """Puts the origin of an image into errors that have no place of their own."""

    __slots__ = ("_origin",)

    def __init__(self, origin: str | None) -> None:
        self._origin = origin

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: object) -> None:
        if isinstance(error, InputError) and not error.path and self._origin is not None:
            location, hint = error.location, error.hint
            raise type(error)(error.message, path=self._origin, location=location, hint=hint) from error


def image_of_pixels(
    pixels: npt.NDArray[np.generic], encoding: str, depth_units_per_metre: float | None = None
) -> Image:
    """Wrap decoded pixels of an encoding."""
    return Image(
        width=pixels.shape[1],
        height=pixels.shape[0],
        encoding=encoding,
        depth_units_per_metre=depth_units_per_metre,
        pixels=pixels,
    )


def pixels_of(image: Image) -> npt.NDArray[np.generic]:
    """Return the pixels, decoding if need be.

    Raises:
        InputError: The compressed image is damaged.

    """
    if image.pixels is not None:
        return image.pixels
    with _Named(image.origin):
        if image.compressed is None:
            raise InputError("an image with neither pixels nor a file")
        take_room(image.width * image.height * ENCODINGS[image.encoding].bytes_per_pixel)
        if image.compression == "png":
            return png.decode(image.compressed)
        return _decode_jpeg(image)


def _decode_jpeg(image: Image) -> npt.NDArray[np.generic]:
    from tumtools.images.pillow import opened  # noqa: PLC0415 - brings Pillow

    with opened(image.compressed or b"", "the JPEG image cannot be decoded", "JPEG") as picture:
        return np.asarray(picture.convert("L" if image.encoding == "mono8" else "RGB"))


def image_of_jpeg(data: bytes | memoryview) -> Image:
    """Wrap a JPEG file, its header read and nothing decoded.

    Raises:
        InputError: Not a JPEG file.
        UnsupportedInputError: It is CMYK, which has no encoding.

    """
    from tumtools.images.pillow import opened  # noqa: PLC0415 - brings Pillow

    with opened(data, "not a JPEG image", "JPEG") as picture:
        width, height = picture.size
        if picture.mode not in {"L", "RGB"}:
            # There is no one colour that an amount of ink is.
            raise UnsupportedInputError(f"JPEG images of mode {picture.mode} are not read, only grey and RGB")
        encoding = "mono8" if picture.mode == "L" else "rgb8"
    return Image(width, height, encoding, compressed=data, compression="jpeg")


def canonical(pixels: npt.NDArray[np.generic], encoding: str) -> tuple[npt.NDArray[np.generic], str]:
    """Put channels in the order R G B (A); return the pixels and their encoding."""
    if encoding in _SWAPPED:
        swapped = pixels.copy(order="C")  # six times as fast as an index of all channels
        swapped[:, :, 0], swapped[:, :, 2] = pixels[:, :, 2], pixels[:, :, 0]
        return swapped, _SWAPPED[encoding]
    return pixels, encoding


def in_metres(image: Image) -> Image:
    """Return counts of depth as an image in metres, `32FC1`, NaN for no reading; metres as they are.

    Raises:
        InputError: The compressed image is damaged.

    """
    units = image.depth_units_per_metre
    if units is None or image.encoding == "32FC1":
        return image
    metres = to_metres(pixels_of(image).astype(np.uint16, copy=False), units)
    return replace(
        image, encoding="32FC1", depth_units_per_metre=1.0, pixels=metres, compressed=None, compression=None
    )


def png_of(image: Image) -> bytes | memoryview:
    """Return the image as a PNG file: the one it came with, its chunks checked, or its pixels encoded.

    Raises:
        InputError: The compressed image is damaged.
        ValueError: The encoding does not fit into a PNG (`32FC1`).

    """
    if image.png is not None:
        with _Named(image.origin):
            png.check(image.png)
        return image.png
    pixels, encoding = canonical(pixels_of(image), image.encoding)
    if ENCODINGS[encoding].dtype.kind == "f":
        raise ValueError("float depth does not fit into a PNG; rescale it to counts first")
    return png.encode(pixels)
