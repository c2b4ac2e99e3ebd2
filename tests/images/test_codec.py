# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""An image has the form it came with; the other is made on demand."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image as PillowImage

from tumtools.errors import InputError
from tumtools.images import png
from tumtools.images.codec import canonical, image_of_jpeg, image_of_pixels, image_of_png, pixels_of, png_of
from tumtools.model.image import Image

COLOUR = np.arange(60, dtype=np.uint8).reshape(4, 5, 3)
DEPTH = np.arange(20, dtype=np.uint16).reshape(4, 5)


def test_a_png_is_passed_on_as_it_came() -> None:
    data = png.encode(COLOUR)
    image = image_of_png(data)
    assert (image.width, image.height, image.encoding, image.depth_units_per_metre) == (5, 4, "rgb8", None)
    assert png_of(image) is data
    assert np.array_equal(pixels_of(image), COLOUR)


def test_sixteen_bit_grey_is_depth_only_where_depth_is_expected() -> None:
    assert image_of_png(png.encode(DEPTH)).encoding == "mono16"
    image = image_of_png(png.encode(DEPTH), 5000.0)
    assert (image.encoding, image.depth_units_per_metre) == ("16UC1", 5000.0)


@pytest.mark.parametrize("pixels", [COLOUR, COLOUR[:, :, 0]])
def test_depth_must_be_sixteen_bit_grey(pixels: np.ndarray) -> None:
    with pytest.raises(InputError, match="a depth image is a PNG of 16-bit grey; this one has 8 bits"):
        image_of_png(png.encode(pixels), 5000.0)


def test_swapped_channels_are_put_in_order() -> None:
    image = image_of_pixels(COLOUR[:, :, ::-1], "bgr8")
    assert np.array_equal(png.decode(png_of(image)), COLOUR)
    alpha = np.arange(80, dtype=np.uint8).reshape(4, 5, 4)
    pixels, encoding = canonical(alpha, "bgra8")
    assert encoding == "rgba8"
    assert np.array_equal(pixels, alpha[:, :, [2, 1, 0, 3]])


def test_float_depth_does_not_fit_into_a_png() -> None:
    with pytest.raises(ValueError, match="rescale"):
        png_of(image_of_pixels(np.ones((2, 2), np.float32), "32FC1", 1.0))


@pytest.mark.parametrize(("mode", "encoding"), [("RGB", "rgb8"), ("L", "mono8")])
def test_a_jpeg_is_wrapped_by_its_header_and_decoded_on_demand(mode: str, encoding: str) -> None:
    file = io.BytesIO()
    PillowImage.fromarray(COLOUR).convert(mode).save(file, "JPEG")
    image = image_of_jpeg(file.getvalue())
    assert (image.width, image.height, image.encoding, image.png) == (5, 4, encoding, None)
    assert pixels_of(image).shape == ((4, 5) if mode == "L" else (4, 5, 3))
    assert np.array_equal(png.decode(png_of(image)), pixels_of(image))


def test_damaged_images_are_refused() -> None:
    with pytest.raises(InputError, match="JPEG"):
        image_of_jpeg(b"\xff\xd8 no")
    with pytest.raises(InputError, match="JPEG"):
        pixels_of(Image(4, 4, "rgb8", compressed=b"no", compression="jpeg"))
    with pytest.raises(InputError, match="neither pixels nor a file"):
        pixels_of(Image(4, 4, "rgb8"))


def test_the_size_is_that_of_the_form_that_is_there() -> None:
    assert Image(5, 4, "rgb8", pixels=COLOUR).nbytes == 60
    assert Image(5, 4, "rgb8", compressed=b"1234", compression="png", pixels=COLOUR).nbytes == 4
    assert Image(5, 4, "rgb8").nbytes == 0
