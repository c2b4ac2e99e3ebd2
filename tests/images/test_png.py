# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Any PNG is decoded as Pillow decodes it, damage is found and named, and what we write reads back."""

from __future__ import annotations

import io
import struct
import zlib
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from PIL import Image as PillowImage

from tests.images.made import CHANNELS, KINDS, chunk, make, offsets
from tumtools.errors import InputError, UnsupportedInputError
from tumtools.images import png

if TYPE_CHECKING:
    from pathlib import Path

SHAPES = [(1, 1), (1, 9), (9, 1), (5, 7), (13, 17)]
PALETTE = bytes(range(48, 48 + 3 * 16)) * 16


def _samples(colour_type: int, bits: int, shape: tuple[int, int] = (13, 17)) -> np.ndarray:
    random = np.random.default_rng(colour_type * 100 + bits)
    return random.integers(0, 2**bits, (*shape, CHANNELS[colour_type]), np.uint16)


def _pillow(data: bytes, mode: str) -> np.ndarray:
    with PillowImage.open(io.BytesIO(data)) as picture:
        return np.asarray(picture.convert(mode))


def _expected(data: bytes, samples: np.ndarray, colour_type: int, bits: int) -> np.ndarray:
    if bits == 16:
        return samples[:, :, 0]
    return _pillow(data, {0: "L", 2: "RGB", 3: "RGB", 4: "RGBA", 6: "RGBA"}[colour_type])


@pytest.mark.parametrize("interlaced", [False, True], ids=["plain", "interlaced"])
@pytest.mark.parametrize(("colour_type", "bits"), KINDS)
def test_every_kind_of_png_is_decoded_or_refused_in_words(
    colour_type: int, bits: int, interlaced: bool
) -> None:
    samples = _samples(colour_type, bits)
    palette = PALETTE[: 3 * 2**bits] if colour_type == 3 else b""
    data = make(samples, colour_type, bits, filters=(0, 1, 2, 3, 4), interlaced=interlaced, palette=palette)
    if bits == 16 and colour_type != 0:
        with pytest.raises(UnsupportedInputError, match="16 bits a sample"):
            png.decode(data)
        return
    pixels = png.decode(data)
    assert np.array_equal(pixels, _expected(data, samples, colour_type, bits))
    assert pixels.dtype == (np.uint16 if bits == 16 else np.uint8)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("filters", [(0,), (1,), (2,), (3,), (4,), (1, 2), (2, 2, 0), (4, 3, 2, 1, 0)])
@pytest.mark.parametrize(("colour_type", "bits"), [(0, 8), (0, 16), (2, 8), (6, 8)])
def test_every_filter_is_undone(
    colour_type: int, bits: int, filters: tuple[int, ...], shape: tuple[int, int]
) -> None:
    samples = _samples(colour_type, bits, shape)
    data = make(samples, colour_type, bits, filters=filters, parts=3)
    assert np.array_equal(png.decode(data), samples.squeeze(2) if colour_type == 0 else samples)


@pytest.mark.parametrize("colour_type", [0, 2, 4, 6])
@pytest.mark.parametrize("shape", [(1, 1), (1, 2), (2, 3), (7, 1), (5, 64), (64, 65), (30, 127)])
def test_the_left_neighbour_is_added_whatever_the_size(colour_type: int, shape: tuple[int, int]) -> None:
    samples = _samples(colour_type, 8, shape)
    data = make(samples, colour_type, 8, filters=(1,))
    assert np.array_equal(png.decode(data), _expected(data, samples, colour_type, 8))


@pytest.mark.parametrize(
    ("colour_type", "bits", "transparency"),
    [(0, 8, b"\0\x07"), (0, 2, b"\0\x01"), (2, 8, b"\0\1\0\2\0\3"), (3, 4, b"\0\x80\xff"), (3, 8, b"\0")],
)
def test_transparent_colours_become_an_alpha_channel(
    colour_type: int, bits: int, transparency: bytes
) -> None:
    palette = PALETTE[: 3 * 2**bits] if colour_type == 3 else b""
    data = make(_samples(colour_type, bits), colour_type, bits, palette=palette, transparency=transparency)
    assert np.array_equal(png.decode(data), _pillow(data, "RGBA"))
    assert png.check(data).encoding == "rgba8"


@pytest.mark.parametrize(("colour_type", "bits"), KINDS)
@pytest.mark.parametrize("transparent", [False, True])
def test_the_encoding_is_known_without_decoding(colour_type: int, bits: int, transparent: bool) -> None:
    transparency = {0: b"\0\0", 2: bytes(6), 3: b"\0"}.get(colour_type, b"") if transparent else b""
    palette = PALETTE[: 3 * 2**bits] if colour_type == 3 else b""
    data = make(_samples(colour_type, bits), colour_type, bits, palette=palette, transparency=transparency)
    encoding = png.check(data).encoding
    if bits == 16:
        assert encoding == "16UC1"
    else:
        channels = {"mono8": 1, "rgb8": 3, "rgba8": 4}[encoding]
        assert png.decode(data).shape == ((13, 17) if channels == 1 else (13, 17, channels))


IMAGES = st.one_of(
    hnp.arrays(np.uint8, st.tuples(st.integers(1, 12), st.integers(1, 12))),
    hnp.arrays(np.uint16, st.tuples(st.integers(1, 12), st.integers(1, 12))),
    hnp.arrays(np.uint8, st.tuples(st.integers(1, 12), st.integers(1, 12), st.sampled_from([3, 4]))),
)


@given(IMAGES)
def test_what_is_encoded_reads_back_here_and_in_pillow(pixels: np.ndarray) -> None:
    data = png.encode(pixels)
    png.check(data)
    assert np.array_equal(png.decode(data), pixels)
    with PillowImage.open(io.BytesIO(data)) as picture:
        assert np.array_equal(np.asarray(picture), pixels)
    assert png.encode(pixels[::-1, ::-1][::-1, ::-1]) == data


def test_big_endian_and_sliced_arrays_are_encoded_by_their_values() -> None:
    depth = np.arange(600, dtype=np.uint16).reshape(20, 30)
    assert png.encode(depth.astype(">u2")) == png.encode(depth)
    assert np.array_equal(png.decode(png.encode(depth[::2, ::3])), depth[::2, ::3])
    assert np.array_equal(png.decode(png.encode(depth[:, :, None])), depth)


@pytest.mark.parametrize(
    "pixels",
    [
        np.zeros((2, 2), np.float32),
        np.zeros((2, 2, 2), np.uint8),
        np.zeros((2, 2, 3), np.uint16),
        np.zeros((0, 2), np.uint8),
        np.zeros((2, 0, 3), np.uint8),
        np.zeros(4, np.uint8),
        np.zeros((1, 2, 2, 3), np.uint8),
        np.zeros((2, 2), np.int16),
    ],
)
def test_what_is_no_image_is_not_encoded(pixels: np.ndarray) -> None:
    with pytest.raises(ValueError, match="PNG"):
        png.encode(pixels)


def _example() -> bytes:
    return make(
        _samples(3, 8), 3, 8, filters=(4, 1), palette=PALETTE[: 3 * 256], transparency=b"\0\1", parts=3
    )


@pytest.mark.parametrize("number", range(7))
def test_a_wrong_crc_is_found_in_each_chunk(number: int) -> None:
    data = bytearray(_example())
    starts = offsets(bytes(data))
    assert len(starts) == 8  # IHDR PLTE tRNS IDAT IDAT IDAT IEND
    data[starts[number + 1] - 1] ^= 1
    with pytest.raises(InputError, match=r"CRC of the PNG chunk [A-Za-z]{4} is wrong") as caught:
        png.check(bytes(data))
    assert caught.value.location == f"offset {starts[number]}"
    assert caught.value.hint


@pytest.mark.parametrize(
    ("data", "said"),
    [(b"<html><body>", "begins with <html><b"), (b"\0\1" * 9, "00 01 00 01"), (b"", "begins with nothing")],
)
def test_what_is_there_instead_is_shown_in_words(data: bytes, said: str) -> None:
    with pytest.raises(InputError, match=said):
        png.header(data)


def test_each_flipped_byte_is_found() -> None:
    good = _example()
    for position in range(len(good)):
        data = bytearray(good)
        data[position] ^= 0x10
        with pytest.raises(InputError):
            png.check(bytes(data))


def test_each_truncation_is_found() -> None:
    good = _example()
    for length in range(len(good)):
        with pytest.raises(InputError) as caught:
            png.check(good[:length])
        assert "offset" in str(caught.value.location)


def test_bytes_after_the_end_are_no_concern_of_ours() -> None:
    assert png.check(_example() + b"more") == png.check(_example())


def _with_header(
    width: int, height: int, bits: int = 8, colour_type: int = 2, rest: bytes = b"\0\0\0"
) -> bytes:
    head = struct.pack(">IIBB", width, height, bits, colour_type) + rest
    good = make(_samples(2, 8), 2, 8)
    return good[:8] + chunk(b"IHDR", head) + good[33:]


@pytest.mark.parametrize(
    "data",
    [
        _with_header(0, 5),
        _with_header(5, 0),
        _with_header(5, 5, colour_type=1),
        _with_header(5, 5, colour_type=7),
        _with_header(5, 5, bits=3),
        _with_header(5, 5, bits=4, colour_type=2),
        _with_header(5, 5, bits=16, colour_type=3),
        _with_header(5, 5, rest=b"\1\0\0"),
        _with_header(5, 5, rest=b"\0\1\0"),
        _with_header(5, 5, rest=b"\0\0\2"),
    ],
)
def test_impossible_headers_are_refused(data: bytes) -> None:
    with pytest.raises(InputError, match="impossible values"):
        png.header(data[: png.HEADER_SIZE])


@pytest.mark.parametrize(("width", "height"), [(4096, 3072), (3 * 2**22, 1)])
def test_a_header_that_promises_too_much_costs_no_memory(width: int, height: int) -> None:
    with pytest.raises(InputError, match=f"promises {width}x{height} pixels"):
        png.decode(_with_header(width, height))


@pytest.mark.parametrize(("width", "height"), [(2**32 - 1, 2**32 - 1), (4096, 3073), (2**31, 1)])
def test_no_image_of_more_than_12_megapixels_is_read(width: int, height: int) -> None:
    with pytest.raises(
        UnsupportedInputError, match=f"{width}x{height} pixels; images of more than 12 megapixels"
    ):
        png.header(_with_header(width, height))


def test_a_header_that_promises_a_little_too_much_is_refused() -> None:
    with pytest.raises(InputError, match=r"inflates to|truncated|decoded"):
        png.decode(_with_header(17, 14))


def test_a_bomb_is_not_inflated() -> None:
    rows = 1 << 15
    body = zlib.compress(bytes((3 * rows + 1) * 100), 9) + bytes(3 * rows * rows // 1040)
    head = struct.pack(">IIBBBBB", rows, rows, 8, 2, 0, 0, 0)
    data = png.SIGNATURE + chunk(b"IHDR", head) + chunk(b"IDAT", body) + chunk(b"IEND", b"")
    with pytest.raises(UnsupportedInputError, match="more than 12 megapixels"):
        png.decode(data)


def _with_body(body: bytes, colour_type: int = 2) -> bytes:
    good = make(_samples(2, 8), 2, 8)
    head = struct.pack(">IIBBBBB", 17, 13, 8, colour_type, 0, 0, 0)
    return good[:8] + chunk(b"IHDR", head) + chunk(b"IDAT", body) + chunk(b"IEND", b"")


RAW = bytes([1, *range(51)]) * 13


@pytest.mark.parametrize(
    "body",
    [
        b"",
        b"nonsense, but long enough to be taken for data",
        zlib.compress(RAW)[:-20],
        zlib.compress(RAW[:-1]),
        zlib.compress(RAW + b"x"),
        zlib.compress(bytes([7]) + RAW[1:]),
        zlib.compress(RAW[:52] + bytes([9]) + RAW[53:]),
        zlib.compress(RAW)[:-1] + b"?",
    ],
)
def test_image_data_that_is_damaged_under_a_right_crc_is_refused(body: bytes) -> None:
    with pytest.raises(InputError):
        png.decode(_with_body(body))


def test_a_palette_image_without_its_palette_is_refused() -> None:
    with pytest.raises(InputError, match="PLTE"):
        png.check(make(_samples(3, 8), 3, 8))


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (chunk(b"tEXt", b"Comment\0x"), "between those of its image data"),
        (_with_header(17, 13)[8:33], "two headers"),
        (chunk(b"te t", b""), "no four letters"),
    ],
)
def test_chunks_that_cannot_be_there_are_refused(more: bytes, said: str) -> None:
    """Pillow and libpng refuse them, too."""
    data = make(_samples(2, 8), 2, 8, parts=2)
    second = offsets(data)[2]
    with pytest.raises(InputError, match=said):
        png.check(data[:second] + more + data[second:])


def test_what_others_write_around_the_image_data_is_no_concern_of_ours() -> None:
    data = make(_samples(2, 8), 2, 8, parts=2)
    text = chunk(b"tEXt", b"Comment\0x")
    begin, end = offsets(data)[1], offsets(data)[3]
    assert np.array_equal(
        png.decode(data[:begin] + text + data[begin:end] + text + data[end:]), png.decode(data)
    )


@pytest.mark.parametrize("data", [b"", b"\x89PNG", b"GIF89a" + bytes(40), png.SIGNATURE + bytes(25)])
def test_what_is_no_png_says_what_it_begins_with(data: bytes) -> None:
    with pytest.raises(InputError, match=r"not a PNG|header chunk is missing"):
        png.header(data)


@pytest.mark.real
def test_published_images_are_decoded_as_pillow_does(real_sequence: Path) -> None:
    for stream, mode in (("rgb", "RGB"), ("depth", "I;16")):
        path = min((real_sequence / stream).glob("*.png"))
        pixels = png.decode(path.read_bytes())
        with PillowImage.open(path) as picture:
            assert picture.mode in (mode, "I")
            assert np.array_equal(pixels, np.asarray(picture))
        assert np.array_equal(png.decode(png.encode(pixels)), pixels)


@pytest.mark.real
def test_a_published_image_cut_at_every_97th_byte_is_refused(real_sequence: Path) -> None:
    data = min((real_sequence / "depth").glob("*.png")).read_bytes()
    for length in range(0, len(data), 97):
        with pytest.raises(InputError):
            png.check(data[:length])
