# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Equal digests mean equal contents, whatever holds them."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.made import made
from tumtools.convert import convert
from tumtools.digest import canonical_pixels, digest, digest_of_rows, pixel_digest
from tumtools.errors import InputError
from tumtools.images import png
from tumtools.images.codec import image_of_pixels, image_of_png
from tumtools.model.signals import Trajectory
from tumtools.sources import open_source

FULL = Path(__file__).parents[1] / "fixtures" / "full"
COLOUR = np.arange(36, dtype=np.uint8).reshape(3, 4, 3)


def test_the_pixels_of_an_image_are_hashed_with_their_kind_and_size() -> None:
    expected = hashlib.sha256(b"rgb8 4 3\n" + COLOUR.tobytes()).digest()
    assert pixel_digest(image_of_png(png.encode(COLOUR))) == expected
    assert pixel_digest(image_of_pixels(COLOUR[:, :, ::-1], "bgr8")) == expected


def test_depth_is_the_same_in_counts_of_any_unit_and_in_metres() -> None:
    counts = np.array([[0, 5000, 5, 65_535]], np.uint16)
    metres = (counts / 5000).astype(np.float32)
    metres[0, 0] = np.nan
    in_counts = pixel_digest(image_of_pixels(counts, "16UC1", 5000.0))
    assert in_counts == pixel_digest(image_of_png(png.encode(counts), 5000.0))
    assert in_counts == pixel_digest(image_of_pixels(metres, "32FC1", 1.0))
    for zero in (0.0, -0.0):
        metres[0, 0] = zero
        assert in_counts == pixel_digest(image_of_pixels(metres, "32FC1", 1.0))
    millimetres = image_of_pixels(np.array([[0, 1000, 1, 13_107]], np.uint16), "16UC1", 1000.0)
    assert in_counts == pixel_digest(millimetres)


def test_all_counts_are_the_same_in_metres() -> None:
    counts = np.arange(65_536, dtype=np.uint16).reshape(256, 256)
    _, pixels = canonical_pixels(image_of_pixels(counts, "16UC1", 5000.0))
    assert np.array_equal(pixels, (counts / 5000).astype(np.float32))


def test_one_count_one_nanosecond_one_bit_make_a_difference() -> None:
    counts = np.zeros((2, 2), np.uint16)
    other = counts.copy()
    other[1, 1] = 1
    assert pixel_digest(image_of_pixels(counts, "16UC1", 1.0)) != pixel_digest(
        image_of_pixels(other, "16UC1", 1.0)
    )
    stamps, values = np.array([1, 2], np.int64), np.array([[0.1], [0.2]])
    same = digest_of_rows(stamps, values)
    assert same == digest_of_rows(stamps.copy(), values.copy())
    assert same != digest_of_rows(stamps + np.array([0, 1]), values)
    assert same != digest_of_rows(stamps, np.nextafter(values, 1))
    assert digest_of_rows(stamps, values * 0) != digest_of_rows(stamps, values * -0.0)


def test_all_nan_are_the_same() -> None:
    strange = np.array([0x7FF8000000000001, 0xFFF8000000000000], np.uint64).view(np.float64).reshape(2, 1)
    stamps = np.zeros(2, np.int64)
    assert digest_of_rows(stamps, strange) == digest_of_rows(stamps, np.full((2, 1), np.nan))


def test_the_digest_does_not_depend_on_the_number_of_threads_or_the_container(tmp_path: Path) -> None:
    with open_source(FULL) as sequence:
        expected = digest(sequence, jobs=1)
        for target, to in (("x.tgz", "tum"), ("x.mcap", "mcap")):
            convert(sequence, tmp_path / target, to)
            with open_source(tmp_path / target) as again:
                assert digest(again, jobs=3).value == expected.value


def test_the_order_of_rows_is_part_of_the_content() -> None:
    assert digest(made(rgb=[1, 2], colours=[0, 0])) != digest(made(rgb=[2, 1], colours=[0, 0]))
    trajectory = Trajectory(np.array([1, 2], np.int64), np.zeros((2, 3)), np.zeros((2, 4)))
    one, two = made(), made()
    one.groundtruth, two.groundtruth = trajectory, trajectory.take(np.array([1, 0]))
    assert digest(one).value != digest(two).value


def test_an_empty_stream_is_not_a_missing_one() -> None:
    assert digest(made(depth=[])).value != digest(made()).value


def test_digests_of_the_images_are_kept_if_asked_for() -> None:
    sequence = made(rgb=[2, 1])
    frames = digest(sequence, deep=True).frames
    assert [(stream, stamp) for stream, stamp, _ in frames] == [("rgb", 1), ("rgb", 2)]
    assert frames[0][2] == pixel_digest(sequence.load_rgb(1)).hex()


def test_an_image_that_cannot_be_decoded_is_named() -> None:
    sequence = made()
    good = sequence.load_rgb

    def damaged(row: int) -> object:
        image = good(row)
        return replace(image, compressed=image.compressed[:40]) if row == 1 else image

    sequence.load_rgb = damaged
    with pytest.raises(InputError, match="cut off"):
        digest(sequence)
