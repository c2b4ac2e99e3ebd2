# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The digest is what docs/reference/digest.md says, computed here from the page alone."""

from __future__ import annotations

import hashlib
import struct

import numpy as np
import pytest

from tests.memory import START, Memory, accelerometer, full, groundtruth
from tumtools.digest import canonical_pixels, digest, pixel_digest
from tumtools.images.codec import image_of_pixels, pixels_of


def test_the_digest_is_as_documented() -> None:
    sequence = full()
    lines = []
    for stream in ("accelerometer", "depth", "groundtruth", "ir", "rgb"):
        sha = hashlib.sha256()
        if stream in {"accelerometer", "groundtruth"}:
            signal = sequence.accelerometer if stream == "accelerometer" else sequence.groundtruth
            assert signal is not None
            for stamp, values in zip(signal.stamps.tolist(), signal.values.tolist(), strict=True):
                sha.update(struct.pack(f"<q{len(values)}d", stamp, *values))
            count = len(signal)
        else:
            kind = {"rgb": "rgb8", "ir": "mono8", "depth": "depth-counts"}[stream]
            rows = sorted(sequence.images([stream]), key=lambda frame: frame.row)
            for frame in rows:
                image = frame.load()
                data = pixels_of(image)
                head = f"{kind} {image.width} {image.height}\n".encode()
                sha.update(struct.pack("<q", frame.stamp) + hashlib.sha256(head + data.tobytes()).digest())
            count = len(rows)
        lines.append(f"{stream} {count} {sha.hexdigest()}\n")
    whole = hashlib.sha256(("tumtools-digest 2\n" + "".join(lines)).encode()).hexdigest()
    assert digest(sequence).value == whole


@pytest.mark.parametrize("jobs", [1, 2, 8])
def test_the_number_of_jobs_is_no_matter(jobs: int) -> None:
    assert digest(full(), jobs=jobs, deep=True) == digest(full(), jobs=3, deep=True)


def test_depth_is_the_same_in_counts_millimetres_and_metres() -> None:
    counts = np.array([[0, 5000, 10_000, 65_535 // 5 * 5]], np.uint16)
    metres = np.where(counts == 0, np.nan, counts / 5000).astype(np.float32)
    images = (
        image_of_pixels(counts, "16UC1", 5000.0),
        image_of_pixels(counts // 5, "16UC1", 1000.0),
        image_of_pixels(metres, "32FC1", 1.0),
    )
    assert len({pixel_digest(image) for image in images}) == 1


def test_depth_that_is_no_whole_number_of_counts_is_hashed_in_metres() -> None:
    values = np.array([[1.0, np.nan, 1.00001]], np.float32)
    head = b"depth-metres 3 1\n"
    wanted = hashlib.sha256(head + np.array([1.0, 0.0, 1.00001], "<f4").tobytes()).digest()
    assert pixel_digest(image_of_pixels(values, "32FC1", 1.0)) == wanted
    millimetres = np.array([[1, 65_535]], np.uint16)
    wanted = hashlib.sha256(b"depth-metres 2 1\n" + np.array([0.001, 65.535], "<f4").tobytes()).digest()
    assert pixel_digest(image_of_pixels(millimetres, "16UC1", 1000.0)) == wanted


def test_every_float_that_is_no_reading_is_zero_and_all_others_are_kept() -> None:
    values = np.array([[np.nan, -0.0, 0.0, 1.0, -1.0, np.inf, -np.inf, 1e-45, 3e38]], np.float32)
    values.view(np.uint32)[0, 0] = 0xFF80FFFF  # another NaN
    kind, found = canonical_pixels(image_of_pixels(values, "32FC1", 1.0))
    wanted = np.array([[0.0, 0.0, 0.0, 1.0, -1.0, np.inf, -np.inf, 1e-45, 3e38]], np.float32)
    assert (kind, found.tobytes()) == ("depth-metres", wanted.tobytes())
    kind, found = canonical_pixels(image_of_pixels(values[:, :4], "32FC1", 1.0))
    assert (kind, found.tolist()) == ("depth-counts", [[0, 0, 0, 5000]])


def test_the_order_of_channels_is_no_matter() -> None:
    pixels = np.arange(24, dtype=np.uint8).reshape(2, 4, 3)
    swapped = np.ascontiguousarray(pixels[:, :, ::-1])
    assert pixel_digest(image_of_pixels(pixels, "rgb8")) == pixel_digest(image_of_pixels(swapped, "bgr8"))


def test_rows_of_nan_are_equal_and_anything_else_is_not() -> None:
    other = Memory({}, groundtruth=groundtruth(START, START + 1))
    assert digest(other).value == digest(Memory({}, groundtruth=groundtruth(START, START + 1))).value
    assert other.groundtruth is not None
    before = digest(other).value
    other.groundtruth.positions[0, 0] = np.nan
    first = digest(other).value
    other.groundtruth.positions[0, 0] = -np.float64("nan")
    assert digest(other).value == first != before


def test_a_stream_without_rows_is_not_a_stream_that_is_not_there() -> None:
    empty = Memory({"rgb": []}, accelerometer=accelerometer())
    assert digest(empty).value != digest(Memory({"rgb": []})).value != digest(Memory({})).value
    assert digest(empty).streams["rgb"].value == hashlib.sha256().hexdigest()
