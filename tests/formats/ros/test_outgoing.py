# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Topics, frames and calibrations of what we write, as they were asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from tests.memory import START, Memory, accelerometer, full, groundtruth
from tumtools.convert import convert
from tumtools.errors import UsageError
from tumtools.formats.options import ReadOptions, WriteOptions
from tumtools.model.camera import CameraInfo, calibration
from tumtools.sources import open_source

if TYPE_CHECKING:
    from pathlib import Path

    from tumtools.model.sequence import Sequence

RGB, DEPTH = "/camera/rgb/image_color/compressed", "/camera/depth/image"


def _messages(path: Path, sequence: Sequence | None = None, **options: Any) -> dict[str, list[Any]]:
    convert(sequence or full(), path, "mcap", WriteOptions(**options))
    found: dict[str, list[Any]] = {}
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for _, channel, _, message in reader.iter_decoded_messages():
            found.setdefault(channel.topic, []).append(message)
    return found


def _k(messages: dict[str, list[Any]], stream: str) -> tuple[float, ...]:
    return tuple(messages[f"/camera/{stream}/camera_info"][0].k)


@pytest.mark.parametrize(
    ("choice", "topics"),
    [
        ("both", {"/tf", "/groundtruth/pose"}),
        ("pose", {"/groundtruth/pose"}),
        ("tf", {"/tf"}),
        ("none", set()),
    ],
)
def test_ground_truth_goes_where_it_was_asked_to(tmp_path: Path, choice: str, topics: set[str]) -> None:
    found = _messages(tmp_path / "x.mcap", groundtruth=choice)
    assert {topic for topic in found if topic in {"/tf", "/groundtruth/pose"}} == topics
    with open_source(tmp_path / "x.mcap") as sequence:
        assert (sequence.groundtruth is None) == (choice == "none")


def test_the_modern_layout_has_no_slashes_in_frames(tmp_path: Path) -> None:
    found = _messages(tmp_path / "x.mcap")
    assert {one.header.frame_id for one in found[RGB] + found[DEPTH]} == {"openni_rgb_optical_frame"}
    assert found["/camera/ir/image_raw/compressed"][0].header.frame_id == "openni_depth_optical_frame"
    assert found["/groundtruth/pose"][0].header.frame_id == "world"
    assert found["/tf"][0].transforms[0].child_frame_id == "groundtruth"


def test_the_published_layout(tmp_path: Path) -> None:
    found = _messages(tmp_path / "x.mcap", layout="published")
    assert "/groundtruth/pose" not in found
    transform = found["/tf"][0].transforms[0]
    assert (transform.header.frame_id, transform.child_frame_id) == ("/world", "/openni_rgb_optical_frame")
    assert found[RGB][0].header.frame_id == "/openni_rgb_optical_frame"
    assert found["/camera/rgb/camera_info"][0].header.frame_id == "/openni_rgb_optical_frame"
    with open_source(tmp_path / "x.mcap") as sequence:
        assert sequence.groundtruth is not None
        assert len(sequence.groundtruth) == 3
        assert sequence.info.frame_ids == {}


def test_frames_and_topics_can_be_named(tmp_path: Path) -> None:
    frames = {"rgb": "left_eye", "accelerometer": "body", "groundtruth": "map"}
    found = _messages(tmp_path / "x.mcap", frame_ids=frames, topics={"rgb": "/eye", "groundtruth": "/truth"})
    assert found["/eye"][0].header.frame_id == "left_eye"
    assert found["/camera_info"][0].header.frame_id == "left_eye"
    assert found["/imu"][0].header.frame_id == "body"
    assert found["/truth"][0].header.frame_id == "map"
    assert found["/tf"][0].transforms[0].header.frame_id == "map"
    with open_source(tmp_path / "x.mcap") as sequence:
        assert sequence.info.frame_ids["rgb"] == "left_eye"
        assert sequence.info.images["rgb"].source == "/eye"


@pytest.mark.parametrize(
    "topics",
    [{"rgb": "/a", "depth": "/a"}, {"groundtruth": "/tf"}, {"accelerometer": "/camera/rgb/camera_info"}],
)
def test_one_topic_for_two_things_is_refused(tmp_path: Path, topics: dict[str, str]) -> None:
    with pytest.raises(UsageError, match="two streams would be written to the topic"):
        _messages(tmp_path / "x.mcap", topics=topics)


def test_one_topic_is_not_read_as_two_streams(tmp_path: Path) -> None:
    convert(full(), tmp_path / "x.mcap", "mcap")
    options = ReadOptions(topics={"rgb": DEPTH})
    with pytest.raises(UsageError, match=f"{DEPTH} cannot be both rgb and depth"):
        open_source(tmp_path / "x.mcap", options)


def test_the_calibration_is_that_of_the_camera(tmp_path: Path) -> None:
    found = _messages(tmp_path / "x.mcap")
    info = found["/camera/rgb/camera_info"][0]
    expected = calibration("fr1", "rgb", info.width, info.height)
    assert tuple(info.k) == expected.k
    assert tuple(info.d) == expected.d
    assert tuple(info.p) == expected.p
    assert tuple(info.r) == (1, 0, 0, 0, 1, 0, 0, 0, 1)
    assert info.distortion_model == "plumb_bob"
    assert _k(found, "depth") == _k(found, "rgb")
    assert _k(found, "ir") == calibration("fr1", "ir", info.width, info.height).k


@pytest.mark.parametrize("to", ["mcap", "rosbag1", "rosbag2", "rawlog"])
def test_the_camera_that_was_asked_for_is_the_one_that_is_named(tmp_path: Path, to: str) -> None:
    convert(full(), tmp_path / "x", to)
    for first, camera in ((tmp_path / "x", "fr2"), (tmp_path / "y-fr2", "fr3")):
        target = tmp_path / f"y-{camera}"
        with open_source(first) as sequence:
            convert(sequence, target, to, WriteOptions(camera=camera))
        with open_source(target) as result:
            assert result.info.camera == camera
            assert result.info.images["rgb"].width
            assert all(
                found == calibration(camera, stream, found.width, found.height)
                for stream, found in result.cameras.items()
            )


def test_an_unknown_camera_is_said_to_be_unknown(tmp_path: Path) -> None:
    sequence = Memory({"rgb": [START]}, camera=None)
    report = convert(sequence, tmp_path / "x.mcap", "mcap")
    assert len(report.warnings) == 1
    assert "--camera" in report.warnings[0]
    found = _messages(tmp_path / "y.mcap", sequence)
    assert _k(found, "rgb") == calibration("ros-default", "rgb", 8, 6).k
    assert not convert(sequence, tmp_path / "z.mcap", "mcap", WriteOptions(camera="fr2")).warnings


def test_a_calibration_that_was_asked_for_comes_before_all_others(tmp_path: Path) -> None:
    mine = CameraInfo.pinhole(7.0, 8.0, 4.0, 3.0, width=8, height=6)
    sequence = full()
    sequence.cameras = {"rgb": CameraInfo.pinhole(1.0, 1.0, 1.0, 1.0, width=8, height=6)}
    found = _messages(tmp_path / "a.mcap", sequence)
    assert _k(found, "rgb")[0] == 1
    assert _k(found, "depth") == calibration("fr1", "depth", 8, 6).k
    with open_source(tmp_path / "a.mcap") as result:
        assert result.cameras == sequence.cameras
    found = _messages(tmp_path / "b.mcap", sequence, camera="fr3", cameras={"rgb": mine})
    assert _k(found, "rgb") == mine.k
    assert _k(found, "depth") == calibration("fr3", "depth", 8, 6).k


@pytest.mark.parametrize(
    ("source", "asked", "written"),
    [
        ("mono8", "rgb8", "mono8"),
        ("bgr8", "rgb8", "rgb8"),
        ("rgb8", "bgr8", "bgr8"),
        ("bgr8", "bgr8", "bgr8"),
    ],
)
def test_colour_encodings(tmp_path: Path, source: str, asked: str, written: str) -> None:
    sequence = Memory({"rgb": [START]}, encoding=source)
    found = _messages(tmp_path / "x.mcap", sequence, color_encoding=asked)
    (image,) = found["/camera/rgb/image_color"]
    assert image.encoding == written
    assert image.step == image.width * (1 if written == "mono8" else 3)
    assert len(image.data) == image.step * image.height


@pytest.mark.parametrize(
    "options",
    [
        {"profile": "ros3"},
        {"layout": "mine"},
        {"groundtruth": "some"},
        {"storage": "mcap"},
        {"compression": "bz2"},
    ],
)
def test_options_that_mcap_does_not_have_are_refused(tmp_path: Path, options: dict[str, str]) -> None:
    with pytest.raises(UsageError):
        convert(full(), tmp_path / "x.mcap", "mcap", WriteOptions(**options))  # type: ignore[arg-type]  # as given
    assert not list(tmp_path.iterdir())


def test_signals_alone_are_a_recording(tmp_path: Path) -> None:
    sequence = Memory({}, accelerometer=accelerometer(START), groundtruth=groundtruth(START))
    found = _messages(tmp_path / "x.mcap", sequence)
    assert set(found) == {"/imu", "/tf", "/groundtruth/pose"}
