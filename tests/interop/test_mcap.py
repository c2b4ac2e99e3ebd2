# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""MCAP files of ours, read by other people's readers, hold what the text files and the PNG files hold."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from PIL import Image as PillowImage

from tests.interop.programs import read_with_node
from tumtools.convert import convert
from tumtools.formats.options import WriteOptions
from tumtools.model.time import parse_stamp
from tumtools.sources import open_source

if TYPE_CHECKING:
    from collections.abc import Iterator

FIXTURE = Path(__file__).parents[2] / "fixtures" / "full"
COLOUR, DEPTH = "/camera/rgb/image_color/compressed", "/camera/depth/image"


@dataclass(frozen=True)
class Source:
    """A sequence as its files say, parsed without tumtools."""

    folder: Path

    def rows(self, name: str) -> list[list[str]]:
        lines = (self.folder / f"{name}.txt").read_text().splitlines()
        return [line.split() for line in lines if line and not line.startswith("#")]

    def stamps(self, name: str) -> list[int]:
        return [parse_stamp(row[0]) for row in self.rows(name)]

    def files(self, name: str) -> list[bytes]:
        return [(self.folder / row[1]).read_bytes() for row in self.rows(name)]

    def depth(self) -> Iterator[np.ndarray]:
        for row in self.rows("depth"):
            with PillowImage.open(self.folder / row[1]) as picture:
                yield np.asarray(picture).astype(np.uint16)

    @cache  # noqa: B019 - it lives as long as the test
    def numbers(self, name: str) -> list[list[float]]:
        return [[float(field) for field in row[1:]] for row in self.rows(name)]


@pytest.fixture(params=["fixture", pytest.param("real", marks=pytest.mark.real)])
def source(request: pytest.FixtureRequest) -> Source:
    return Source(FIXTURE if request.param == "fixture" else request.getfixturevalue("real_sequence"))


def _convert(source: Source, path: Path, options: WriteOptions | None = None) -> Path:
    with open_source(source.folder) as sequence:
        convert(sequence, path, "mcap", options)
    return path


def _stamp(message: Any) -> int:
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def test_the_python_library_decodes_every_message(source: Source, tmp_path: Path) -> None:
    path = _convert(source, tmp_path / "x.mcap")
    stamps: dict[str, list[int]] = {}
    depth, colours = source.depth(), iter(source.files("rgb"))
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for _, channel, raw, message in reader.iter_decoded_messages():
            kept = stamps.setdefault(channel.topic, [])
            if channel.topic == "/tf":
                (transform,) = message.transforms
                kept.append(_stamp(transform))
                assert (transform.header.frame_id, transform.child_frame_id) == ("world", "groundtruth")
                translation = transform.transform.translation
                assert translation.x == source.numbers("groundtruth")[len(kept) - 1][0]
                continue
            kept.append(_stamp(message))
            assert raw.log_time == raw.publish_time == kept[-1]
            row = len(kept) - 1
            if channel.topic == DEPTH:
                assert message.encoding == "32FC1"
                metres = np.frombuffer(message.data, "<f4").reshape(message.height, message.width)
                expected = next(depth)
                counts = np.rint(np.nan_to_num(metres.astype(np.float64)) * 5000)
                np.testing.assert_array_equal(counts, expected)
                np.testing.assert_array_equal(np.isnan(metres), expected == 0)
            elif channel.topic == COLOUR:
                assert bytes(message.data) == next(colours)
            elif channel.topic == "/imu":
                found = message.linear_acceleration
                assert [found.x, found.y, found.z] == source.numbers("accelerometer")[row]
            elif channel.topic == "/groundtruth/pose":
                p, q = message.pose.position, message.pose.orientation
                assert [p.x, p.y, p.z, q.x, q.y, q.z, q.w] == source.numbers("groundtruth")[row]
    rgb, depths, poses = (source.stamps(name) for name in ("rgb", "depth", "groundtruth"))
    assert stamps == {
        "/camera/rgb/camera_info": rgb,
        COLOUR: rgb,
        "/camera/depth/camera_info": depths,
        DEPTH: depths,
        "/imu": source.stamps("accelerometer"),
        "/tf": poses,
        "/groundtruth/pose": poses,
    }


def _by_topic(path: Path) -> dict[str, list[dict[str, Any]]]:
    found: dict[str, list[dict[str, Any]]] = {}
    for one in read_with_node("mcap", path):
        stamped = one["message"]["transforms"][0] if one["topic"] == "/tf" else one["message"]
        assert one["time"] == one["publish_time"] == stamped["header"]["stamp"]
        found.setdefault(one["topic"], []).append(one)
    return found


def _sha(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


@pytest.mark.interop
def test_the_node_library_decodes_every_message(source: Source, tmp_path: Path) -> None:
    found = _by_topic(_convert(source, tmp_path / "x.mcap"))
    for topic, name in (
        ("/camera/rgb/camera_info", "rgb"),
        (COLOUR, "rgb"),
        ("/camera/depth/camera_info", "depth"),
        (DEPTH, "depth"),
        ("/imu", "accelerometer"),
        ("/tf", "groundtruth"),
        ("/groundtruth/pose", "groundtruth"),
    ):
        assert [int(one["time"]) for one in found[topic]] == source.stamps(name)
    assert [one["message"]["data"]["sha256"] for one in found[COLOUR]] == [
        _sha(data) for data in source.files("rgb")
    ]
    metres = [
        np.where(counts == 0, np.nan, counts / 5000).astype("<f4").tobytes() for counts in source.depth()
    ]
    assert [one["message"]["data"]["sha256"] for one in found[DEPTH]] == [_sha(data) for data in metres]
    poses = [one["message"]["pose"] for one in found["/groundtruth/pose"]]
    values = [[*(p["position"][a] for a in "xyz"), *(p["orientation"][a] for a in "xyzw")] for p in poses]
    assert values == source.numbers("groundtruth")
    info = found["/camera/rgb/camera_info"][0]
    assert info["type"] == "sensor_msgs/msg/CameraInfo"
    assert info["message"]["distortion_model"] == "plumb_bob"
    assert len(info["message"]["k"]) == 9


@pytest.mark.interop
def test_the_node_library_gets_the_png_files_of_an_archive(source: Source, tmp_path: Path) -> None:
    found = _by_topic(_convert(source, tmp_path / "x.mcap", WriteOptions(archive=True)))
    for topic, name in ((COLOUR, "rgb"), (f"{DEPTH}/compressed", "depth")):
        sums = [one["message"]["data"]["sha256"] for one in found[topic]]
        assert sums == [_sha(data) for data in source.files(name)]


@pytest.mark.interop
@pytest.mark.parametrize("compression", ["lz4", "zstd", "none"])
@pytest.mark.parametrize("colour", ["rgb8", "bgr8"])
def test_the_node_library_reads_raw_pixels(tmp_path: Path, compression: str, colour: str) -> None:
    source = Source(FIXTURE)
    options = WriteOptions(color_encoding=colour, depth_encoding="16UC1", compression=compression)
    found = _by_topic(_convert(source, tmp_path / "x.mcap", options))
    expected = []
    for row in source.rows("rgb"):
        with PillowImage.open(source.folder / row[1]) as picture:
            pixels = np.asarray(picture.convert("RGB"))
            expected.append(_sha((pixels if colour == "rgb8" else pixels[:, :, ::-1]).tobytes()))
    raw = [one["message"] for one in found["/camera/rgb/image_color"]]
    assert [one["data"]["sha256"] for one in raw] == expected
    assert {one["encoding"] for one in raw} == {colour}
    millimetres = [np.rint(counts / 5).astype("<u2").tobytes() for counts in source.depth()]
    assert [one["message"]["data"]["sha256"] for one in found[DEPTH]] == [_sha(data) for data in millimetres]
