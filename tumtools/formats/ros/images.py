# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Image messages to images. Payloads are looked at only as far as needed to know what they are.

Source: sensor_msgs/Image, sensor_msgs/CompressedImage, `image_encodings.hpp`;
compressed_depth_image_transport; REP 118 (16UC1 is millimetres).
"""

from __future__ import annotations

import math
import struct
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from tumtools.errors import InputError, UnsupportedInputError
from tumtools.formats.ros.messages import COMPRESSED_IMAGE
from tumtools.images import png
from tumtools.images.codec import image_of_jpeg, image_of_pixels, image_of_png, pixels_of
from tumtools.images.limits import check_size
from tumtools.model.image import ENCODINGS, Image

if TYPE_CHECKING:
    import numpy.typing as npt

    from tumtools.formats.ros.codec import Message

MILLIMETRES: Final = 1000.0
"""Units per metre of 16UC1 depth (REP 118)."""
_SAME: Final = {"8UC1": "mono8", "8UC3": "bgr8", "8UC4": "bgra8", "16UC1": "mono16"}
"""Encodings without a meaning of their own, where they are not depth."""
_DEPTH: Final = {"16UC1": MILLIMETRES, "mono16": MILLIMETRES, "32FC1": 1.0}
_JPEG_MAGIC: Final = b"\xff\xd8\xff"
_DEPTH_HEADER: Final = struct.Struct("<iff")
"""compressedDepth: format (0 or 1, not to be relied on), and two parameters of inverse depth."""


def image_of_message(kind: str, message: Message, stream: str, png_units_per_metre: float | None) -> Image:
    """Return the image of a message.

    Args:
        kind: Type of the message.
        message: Decoded; its data is a view.
        stream: `depth` makes it depth.
        png_units_per_metre: Unit of depth in PNG files, where the recording says so; else millimetres.

    Raises:
        InputError: The message contradicts itself.
        UnsupportedInputError: An encoding that is not known.

    """
    data = message.get("data")
    if not isinstance(data, np.ndarray) or data.dtype.itemsize != 1:
        raise InputError("an image message whose definition has no bytes named data")
    if kind == COMPRESSED_IMAGE:
        return _compressed(data.data, str(message.get("format", "")), stream, png_units_per_metre)
    return _raw(message, data, stream)


def _compressed(data: memoryview, text: str, stream: str, png_units_per_metre: float | None) -> Image:
    head = bytes(data[: _DEPTH_HEADER.size + len(png.SIGNATURE)])
    if head.startswith(png.SIGNATURE):
        return image_of_png(data, (png_units_per_metre or MILLIMETRES) if stream == "depth" else None)
    if head.endswith(png.SIGNATURE) or "compresseddepth" in text.lower():
        return _compressed_depth(data, text)
    if head.startswith(_JPEG_MAGIC):
        if stream == "depth":
            raise UnsupportedInputError("depth as JPEG")
        return image_of_jpeg(data)
    raise UnsupportedInputError(f"a compressed image of format {text!r} that is neither PNG nor JPEG")


def _compressed_depth(data: memoryview, text: str) -> Image:
    """Read what compressed_depth_image_transport writes: a header, then a PNG file.

    The text says what the pixels were, since many writers fill the header with anything: counts of
    millimetres, or metres as inverse depth, for which the header has two parameters.
    """
    if len(data) < _DEPTH_HEADER.size or bytes(data[_DEPTH_HEADER.size :][:8]) != png.SIGNATURE:
        raise UnsupportedInputError(f"compressed depth of format {text!r} that is no PNG (RVL is not read)")
    inner = image_of_png(data[_DEPTH_HEADER.size :], MILLIMETRES)
    if not text.strip().startswith("32FC1"):
        return inner
    _, quantum, offset = _DEPTH_HEADER.unpack_from(data)
    if not (math.isfinite(quantum) and math.isfinite(offset) and quantum > 0):
        raise InputError(f"compressed depth whose header has the parameters {quantum:g} and {offset:g}")
    levels = np.arange(2**16, dtype=np.float32)
    with np.errstate(divide="ignore"):
        metres = (np.float32(quantum) / (levels - np.float32(offset))).astype(np.float32)
    metres[(levels == 0) | ~np.isfinite(metres)] = np.nan
    return image_of_pixels(metres[pixels_of(inner)], "32FC1", 1.0)


def _raw(message: Message, data: npt.NDArray[np.generic], stream: str) -> Image:
    height, width, step = (_integer(message, name) for name in ("height", "width", "step"))
    name = str(message.get("encoding", ""))
    units = None
    if stream == "depth":
        if name not in _DEPTH:
            raise UnsupportedInputError(f"depth in the encoding {name!r}; known are {', '.join(_DEPTH)}")
        units = _DEPTH[name]
        name = "32FC1" if name == "32FC1" else "16UC1"
    else:
        name = _SAME.get(name, name)
    encoding = ENCODINGS.get(name)
    if encoding is None:
        raise UnsupportedInputError(f"images in the encoding {name!r}; known are {', '.join(ENCODINGS)}")
    row = width * encoding.bytes_per_pixel
    if not width or not height or step < row or data.nbytes < step * (height - 1) + row:
        raise InputError(
            f"an image of {width}x{height} {name} with {step} bytes a row cannot have {data.nbytes} bytes"
        )
    check_size(width, height)
    if data.nbytes < step * height:
        # The last row may lack its padding.
        data = np.concatenate([data, np.zeros(step * height - data.nbytes, np.uint8)])
    rows = data[: step * height].reshape(height, step)[:, :row]
    order: Literal["<", ">"] = ">" if _integer(message, "is_bigendian") else "<"
    pixels = np.ascontiguousarray(rows).view(encoding.dtype.newbyteorder(order))
    if order == ">":
        pixels = pixels.astype(encoding.dtype)
    shape = (height, width) if encoding.channels == 1 else (height, width, encoding.channels)
    return image_of_pixels(pixels.reshape(shape), name, units)


def _integer(message: Message, name: str) -> int:
    value = message.get(name)
    if not isinstance(value, int):
        raise InputError(f"an image message whose definition has no number named {name}")
    return value
