# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Recordings of other people: streams are found by type, images come in many encodings."""

from __future__ import annotations

import io
import struct
from typing import TYPE_CHECKING

import numpy as np
import pytest
from PIL import Image

from tests.formats.ros.published import MS, START, T, header, write_messages
from tumtools.convert import convert
from tumtools.errors import InputError, UnsupportedInputError, UsageError
from tumtools.formats.options import ReadOptions
from tumtools.images.codec import canonical, pixels_of
from tumtools.sources import open_source

if TYPE_CHECKING:
    from pathlib import Path

H, W = 6, 8
IMAGE, COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"
RGB = np.arange(H * W * 3, dtype=np.uint8).reshape(H, W, 3)
GREY = RGB[:, :, 1].copy()
COUNTS = (np.arange(H * W, dtype=np.uint16) * 997).reshape(H, W)


def raw(encoding: str, pixels: np.ndarray, *, padding: int = 0, big_endian: bool = False) -> object:
    rows = pixels.reshape(H, -1).view(np.uint8)
    rows = np.pad(rows, ((0, 0), (0, padding)))
    return T[IMAGE](header(START, "cam"), H, W, encoding, int(big_endian), rows.shape[1], rows.ravel())


def compressed(text: str, data: bytes) -> object:
    return T[COMPRESSED](header(START, "cam"), text, np.frombuffer(data, np.uint8))


def encoded(pixels: np.ndarray, kind: str = "PNG") -> bytes:
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, kind)
    return file.getvalue()


def first_image(path: Path, topic: str, kind: str, message: object) -> tuple[np.ndarray, str, float | None]:
    """Write a bag with one message; return the pixels that are read, their encoding and unit."""
    write_messages(path, [(START, topic, kind, message)])
    with open_source(path) as sequence:
        (frame,) = sequence.images()
        image = frame.load()
    pixels, encoding = canonical(pixels_of(image), image.encoding)
    return pixels, encoding, image.depth_units_per_metre


@pytest.mark.parametrize(
    ("message", "encoding", "expected"),
    [
        (raw("rgb8", RGB), "rgb8", RGB),
        (raw("rgb8", RGB, padding=5), "rgb8", RGB),
        (raw("bgr8", np.ascontiguousarray(RGB[:, :, ::-1])), "rgb8", RGB),
        (raw("8UC3", np.ascontiguousarray(RGB[:, :, ::-1])), "rgb8", RGB),
        (raw("mono8", GREY), "mono8", GREY),
        (raw("8UC1", GREY), "mono8", GREY),
        (raw("mono16", COUNTS), "mono16", COUNTS),
    ],
)
def test_raw_colour(tmp_path: Path, message: object, encoding: str, expected: np.ndarray) -> None:
    pixels, found, unit = first_image(tmp_path / "a.bag", "/usb_cam/image_raw", IMAGE, message)
    assert (found, unit) == (encoding, None)
    assert np.array_equal(pixels, expected)


METRES = np.linspace(-1, 20, H * W, dtype=np.float32).reshape(H, W)


@pytest.mark.parametrize(
    ("message", "encoding", "unit", "expected"),
    [
        (raw("16UC1", COUNTS), "16UC1", 1000, COUNTS),
        (raw("mono16", COUNTS), "16UC1", 1000, COUNTS),
        (raw("16UC1", COUNTS.astype(">u2"), big_endian=True), "16UC1", 1000, COUNTS),
        (raw("32FC1", METRES), "32FC1", 1, METRES),
        (raw("32FC1", METRES, padding=8), "32FC1", 1, METRES),
    ],
)
def test_raw_depth(tmp_path: Path, message: object, encoding: str, unit: float, expected: np.ndarray) -> None:
    found = first_image(tmp_path / "a.bag", "/camera/depth/image_raw", IMAGE, message)
    assert found[1:] == (encoding, unit)
    assert np.array_equal(found[0], expected)


def test_compressed_colour_is_kept_as_it_came(tmp_path: Path) -> None:
    for kind, text in (("PNG", "rgb8; png compressed bgr8"), ("JPEG", "jpeg")):
        data = encoded(RGB, kind)
        path = tmp_path / f"{kind}.bag"
        write_messages(path, [(START, "/cam/image_raw/compressed", COMPRESSED, compressed(text, data))])
        with open_source(path) as sequence:
            (frame,) = sequence.images()
            assert bytes(frame.load().compressed or b"") == data


@pytest.mark.parametrize("header_format", [0, 1, -1])
def test_compressed_depth_of_counts(tmp_path: Path, header_format: int) -> None:
    """Many writers fill the header with anything; the PNG behind it is what counts."""
    data = struct.pack("<iff", header_format, 0.0, 0.0) + encoded(COUNTS)
    message = compressed("16UC1; compressedDepth png", data)
    pixels, encoding, unit = first_image(tmp_path / "a.bag", "/depth/compressedDepth", COMPRESSED, message)
    assert (encoding, unit) == ("16UC1", 1000)
    assert np.array_equal(pixels, COUNTS)


def test_compressed_depth_of_metres_is_inverse_depth(tmp_path: Path) -> None:
    a, b = 100.0 * (100.0 + 1.0), -1.0 * (100.0 + 1.0) / 10.0 + 1.0  # as the transport computes them
    inverse = np.where(COUNTS % 3 == 0, 0, COUNTS % 5000 + 500).astype(np.uint16)
    data = struct.pack("<iff", 1, a, b) + encoded(inverse)
    message = compressed("32FC1; compressedDepth", data)
    pixels, encoding, unit = first_image(tmp_path / "a.bag", "/depth/compressedDepth", COMPRESSED, message)
    assert (encoding, unit) == ("32FC1", 1)
    expected = np.where(inverse == 0, np.nan, a / (inverse.astype(float) - b))
    assert np.allclose(pixels, expected, rtol=1e-6, equal_nan=True)


def test_compressed_depth_without_parameters_is_damaged(tmp_path: Path) -> None:
    message = compressed("32FC1; compressedDepth", struct.pack("<iff", 0, 0, 0) + encoded(COUNTS))
    with pytest.raises(InputError, match="parameters 0 and 0"):
        first_image(tmp_path / "a.bag", "/depth/compressedDepth", COMPRESSED, message)


@pytest.mark.parametrize(
    ("topic", "kind", "message"),
    [
        ("/cam/image", IMAGE, raw("yuv422", np.zeros((H, W, 2), np.uint8))),
        ("/cam/depth", IMAGE, raw("rgb8", RGB)),
        ("/cam/image/compressed", COMPRESSED, compressed("theora", bytes(100))),
        ("/depth/compressedDepth", COMPRESSED, compressed("16UC1; compressedDepth rvl", bytes(100))),
    ],
)
def test_unknown_encodings_are_named(tmp_path: Path, topic: str, kind: str, message: object) -> None:
    with pytest.raises(UnsupportedInputError, match=topic):
        first_image(tmp_path / "a.bag", topic, kind, message)


def test_image_that_contradicts_itself_is_refused(tmp_path: Path) -> None:
    short = T[IMAGE](header(START, "cam"), H, W, "rgb8", 0, 3 * W, RGB.ravel()[:-1])
    with pytest.raises(InputError, match="cannot have 143 bytes"):
        first_image(tmp_path / "a.bag", "/cam/image", IMAGE, short)


def test_metres_that_are_no_counts_are_rounded_and_reported(tmp_path: Path) -> None:
    metres = np.zeros((H, W), np.float32)
    metres[0, :7] = [1.0, 1.00005, -0.5, 13.107, 13.2, np.nan, np.inf]
    write_messages(tmp_path / "a.bag", [(START, "/depth", IMAGE, raw("32FC1", metres))])
    with open_source(tmp_path / "a.bag") as sequence:
        report = convert(sequence, tmp_path / "out", "tum")

    (name,) = (tmp_path / "out" / "depth").iterdir()
    with Image.open(name) as picture:
        assert np.asarray(picture)[0].tolist() == [5000, 5000, 0, 65535, 0, 0, 0, 0]
    losses = {loss.what: loss for loss in report.losses if loss.stream == "depth"}
    assert losses["pixels rounded"].count == 1
    assert losses["pixels rounded"].largest_error == pytest.approx(0.00005, rel=1e-2)
    assert losses["pixels out of range, now without a reading"].count == 3


@pytest.mark.parametrize("encoding", ["bayer_rggb8", "bayer_bggr8", "bayer_gbrg8", "bayer_grbg8"])
def test_mosaics_become_colour_and_say_so(tmp_path: Path, encoding: str) -> None:
    red, blue = encoding[6:10].index("r"), encoding[6:10].index("b")
    mosaic = np.full((H, W), 120, np.uint8)
    mosaic[red // 2 :: 2, red % 2 :: 2] = 200
    mosaic[blue // 2 :: 2, blue % 2 :: 2] = 40
    write_messages(tmp_path / "a.bag", [(START, "/cam/image_raw", IMAGE, raw(encoding, mosaic))])
    with open_source(tmp_path / "a.bag") as sequence:
        report = convert(sequence, tmp_path / "out", "tum")

    (name,) = (tmp_path / "out" / "rgb").iterdir()
    with Image.open(name) as picture:
        assert np.unique(np.asarray(picture).reshape(-1, 3), axis=0).tolist() == [[200, 120, 40]]
    assert [loss.count for loss in report.losses if loss.what == "mosaics made to colour images"] == [1]


def pose(stamp: int, x: float) -> tuple[object, object]:
    place = T["geometry_msgs/msg/Point"](x, 2.0, 3.0), T["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.6, 0.8)
    return header(stamp, "map"), T["geometry_msgs/msg/Pose"](*place)


def message_with_pose(kind: str, stamp: int, x: float) -> object:
    head, place = pose(stamp, x)
    covariance = np.zeros(36)
    with_covariance = T["geometry_msgs/msg/PoseWithCovariance"](place, covariance)
    if kind == "geometry_msgs/msg/PoseStamped":
        return T[kind](head, place)
    if kind == "geometry_msgs/msg/PoseWithCovarianceStamped":
        return T[kind](head, with_covariance)
    vector = T["geometry_msgs/msg/Vector3"]
    if kind == "nav_msgs/msg/Odometry":
        still = T["geometry_msgs/msg/Twist"](vector(0.0, 0.0, 0.0), vector(0.0, 0.0, 0.0))
        twist = T["geometry_msgs/msg/TwistWithCovariance"](still, covariance)
        return T[kind](head, "base", with_covariance, twist)
    position, q = place.position, place.orientation
    return T[kind](
        head, "base", T["geometry_msgs/msg/Transform"](vector(position.x, position.y, position.z), q)
    )


@pytest.mark.parametrize(
    "kind",
    [
        "geometry_msgs/msg/PoseStamped",
        "geometry_msgs/msg/PoseWithCovarianceStamped",
        "geometry_msgs/msg/TransformStamped",
        "nav_msgs/msg/Odometry",
    ],
)
def test_ground_truth_from_any_message_with_a_pose(tmp_path: Path, kind: str) -> None:
    stamps = [START + i * 10 * MS for i in range(5)]
    messages = [(t, "/pose", kind, message_with_pose(kind, t, float(i))) for i, t in enumerate(stamps)]
    write_messages(tmp_path / "a.bag", messages)
    with open_source(tmp_path / "a.bag") as sequence:
        assert sequence.groundtruth is not None
        assert sequence.groundtruth.stamps.tolist() == stamps
        assert sequence.groundtruth.values.tolist() == [[float(i), 2, 3, 0, 0, 0.6, 0.8] for i in range(5)]
        assert sequence.info.frame_ids == {"groundtruth": "map"}


def test_several_candidates_are_an_error_that_lists_them(tmp_path: Path) -> None:
    image = raw("rgb8", RGB)
    path = tmp_path / "a.bag"
    write_messages(path, [(START, "/left/image", IMAGE, image), (START, "/right/image", IMAGE, image)])
    with pytest.raises(UsageError, match="/left/image") as error:
        open_source(path)
    assert "/right/image" in str(error.value)
    assert "--topic rgb=" in str(error.value)
    with open_source(path, ReadOptions(topics={"rgb": "/right/image"})) as sequence:
        assert sequence.info.images["rgb"].source == "/right/image"
        assert [loss.stream for loss in sequence.info.not_carried] == ["/left/image"]


def test_images_recorded_late_are_in_order_of_their_own_stamps(tmp_path: Path) -> None:
    """The time of recording and the header's stamp differ in most recordings; the header counts."""
    messages = []
    for log, stamp in ((0, 30), (1, 10), (2, 20), (3, 40)):
        image = raw("mono8", np.full((H, W), stamp, np.uint8))
        image.header = header(START + stamp * MS, "cam")
        messages.append((START + log * MS, "/cam/image", IMAGE, image))
    write_messages(tmp_path / "a.bag", messages)
    with open_source(tmp_path / "a.bag") as sequence:
        assert [int(pixels_of(frame.load())[0, 0]) for frame in sequence.images()] == [10, 20, 30, 40]
        assert sequence.image_stamps("rgb").tolist() == [START + i * MS for i in (10, 20, 30, 40)]
