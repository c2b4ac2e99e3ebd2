# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Images of every encoding come out of messages as they went in."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image as PillowImage

from tumtools.errors import InputError, UnsupportedInputError
from tumtools.formats.ros.images import image_of_message
from tumtools.formats.ros.messages import COMPRESSED_IMAGE, IMAGE
from tumtools.images import png
from tumtools.images.codec import canonical, pixels_of

WIDTH, HEIGHT = 5, 4
LAYOUTS = {
    "rgb8": ("u1", 3, "rgb8"),
    "bgr8": ("u1", 3, "bgr8"),
    "rgba8": ("u1", 4, "rgba8"),
    "bgra8": ("u1", 4, "bgra8"),
    "mono8": ("u1", 1, "mono8"),
    "mono16": ("u2", 1, "mono16"),
    "8UC1": ("u1", 1, "mono8"),
    "8UC3": ("u1", 3, "bgr8"),
    "8UC4": ("u1", 4, "bgra8"),
    "16UC1": ("u2", 1, "mono16"),
    "bayer_rggb8": ("u1", 1, "bayer_rggb8"),
    "bayer_grbg8": ("u1", 1, "bayer_grbg8"),
}
"""Encoding in the message -> type of a sample, channels, encoding of the image."""


def _pixels(kind: str, channels: int) -> np.ndarray:
    random = np.random.default_rng(3)
    shape = (HEIGHT, WIDTH) if channels == 1 else (HEIGHT, WIDTH, channels)
    if kind == "f4":
        return random.normal(size=shape).astype("f4")
    return random.integers(0, np.iinfo(kind).max, shape, kind, endpoint=True)


def _message(pixels: np.ndarray, encoding: str, *, padding: int = 0, big: bool = False, cut: int = 0) -> dict:
    rows = pixels.astype(pixels.dtype.newbyteorder(">" if big else "<")).view(np.uint8).reshape(HEIGHT, -1)
    padded = np.concatenate([rows, np.full((HEIGHT, padding), 0xAA, np.uint8)], axis=1)
    data = padded.reshape(-1)
    return {
        "header": {},
        "height": HEIGHT,
        "width": WIDTH,
        "encoding": encoding,
        "is_bigendian": int(big),
        "step": padded.shape[1],
        "data": data[: len(data) - cut],
    }


@pytest.mark.parametrize("big", [False, True])
@pytest.mark.parametrize(("padding", "cut"), [(0, 0), (3, 0), (3, 3), (64, 10)])
@pytest.mark.parametrize("encoding", LAYOUTS)
def test_raw_images(encoding: str, padding: int, cut: int, big: bool) -> None:
    kind, channels, name = LAYOUTS[encoding]
    pixels = _pixels(kind, channels)
    image = image_of_message(
        IMAGE, _message(pixels, encoding, padding=padding, big=big, cut=cut), "rgb", None
    )
    assert (image.encoding, image.width, image.height) == (name, WIDTH, HEIGHT)
    assert image.depth_units_per_metre is None
    found = pixels_of(image)
    assert found.dtype.byteorder in "=|<"
    np.testing.assert_array_equal(found, pixels)


@pytest.mark.parametrize("big", [False, True])
@pytest.mark.parametrize(
    ("encoding", "kind", "name", "units"),
    [("16UC1", "u2", "16UC1", 1000), ("mono16", "u2", "16UC1", 1000), ("32FC1", "f4", "32FC1", 1)],
)
def test_raw_depth_is_millimetres_or_metres(
    encoding: str, kind: str, name: str, units: float, big: bool
) -> None:
    pixels = _pixels(kind, 1)
    # The unit of PNG files has no say in raw images.
    image = image_of_message(IMAGE, _message(pixels, encoding, padding=2, big=big), "depth", 5000.0)
    assert (image.encoding, image.depth_units_per_metre) == (name, units)
    np.testing.assert_array_equal(pixels_of(image), pixels)


def test_raw_images_are_no_larger_than_those_of_files() -> None:
    """Else they could be written as PNG files that nobody could read again."""
    width, height = 4096, 3073
    message = _message(_pixels("u1", 1), "mono8") | {"height": height, "width": width, "step": width}
    message["data"] = np.zeros(width * height, np.uint8)
    with pytest.raises(UnsupportedInputError, match="4096x3073 pixels; images of more than 12 megapixels"):
        image_of_message(IMAGE, message, "rgb", None)
    fitting = message | {"height": height - 1}
    assert image_of_message(IMAGE, fitting, "rgb", None).height == 3072


def test_bgr_is_not_taken_for_rgb() -> None:
    pixels = _pixels("u1", 3)
    image = image_of_message(IMAGE, _message(pixels, "bgr8"), "rgb", None)
    ordered, name = canonical(pixels_of(image), image.encoding)
    assert name == "rgb8"
    np.testing.assert_array_equal(ordered, pixels[:, :, ::-1])


@pytest.mark.parametrize(
    ("stream", "units", "expected"),
    [("depth", 5000.0, 5000.0), ("depth", None, 1000.0), ("rgb", 5000.0, None)],
)
def test_png_depth_is_millimetres_unless_the_recording_says_otherwise(
    stream: str, units: float | None, expected: float | None
) -> None:
    data = png.encode(_pixels("u2", 1))
    message = {"header": {}, "format": "16UC1; png compressed", "data": np.frombuffer(data, np.uint8)}
    image = image_of_message(COMPRESSED_IMAGE, message, stream, units)
    assert image.depth_units_per_metre == expected
    assert image.png is not None
    assert bytes(image.png) == data


@pytest.mark.parametrize(("mode", "encoding"), [("RGB", "rgb8"), ("L", "mono8")])
def test_jpeg(mode: str, encoding: str) -> None:
    file = io.BytesIO()
    PillowImage.new(mode, (16, 8), 100 if mode == "L" else (10, 200, 30)).save(file, "JPEG")
    message = {"header": {}, "format": "jpeg", "data": np.frombuffer(file.getvalue(), np.uint8)}
    image = image_of_message(COMPRESSED_IMAGE, message, "rgb", None)
    assert (image.encoding, image.width, image.height, image.compression) == (encoding, 16, 8, "jpeg")
    assert pixels_of(image).shape[:2] == (8, 16)
    with pytest.raises(UnsupportedInputError, match="JPEG"):
        image_of_message(COMPRESSED_IMAGE, message, "depth", None)


@pytest.mark.parametrize("stream", ["rgb", "depth"])
@pytest.mark.parametrize("encoding", ["yuv422", "64FC1", "", "rgb8\0", "32SC1"])
def test_other_encodings_are_named(stream: str, encoding: str) -> None:
    with pytest.raises(UnsupportedInputError, match="known are"):
        image_of_message(IMAGE, _message(_pixels("u1", 1), encoding), stream, None)


@pytest.mark.parametrize(
    "change",
    [
        {"height": 0},
        {"width": 0},
        {"step": 1},
        {"height": HEIGHT + 1},
        {"width": WIDTH + 1},
        {"height": 2**32 - 1, "width": 2**32 - 1},
        {"step": 2**32 - 1},
        {"data": np.empty(0, np.uint8)},
        {"data": np.zeros(100, np.float64)},
        {"data": "text"},
        {"width": "5"},
    ],
)
def test_messages_that_contradict_themselves_are_refused(change: dict) -> None:
    with pytest.raises(InputError):
        image_of_message(IMAGE, _message(_pixels("u1", 3), "rgb8") | change, "rgb", None)


@pytest.mark.parametrize("missing", ["height", "width", "step", "encoding", "is_bigendian", "data"])
def test_definitions_without_a_field_are_refused(missing: str) -> None:
    message = _message(_pixels("u1", 3), "rgb8")
    del message[missing]
    with pytest.raises(InputError):
        image_of_message(IMAGE, message, "rgb", None)
