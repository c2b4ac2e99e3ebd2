# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Recordings of other people are read, whatever their writer left out."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from tests.formats.mcap.foreign import WRITERS, Foreign
from tests.memory import SECOND, START, full, picture
from tumtools.cli.main import run
from tumtools.convert import ConvertOptions, convert
from tumtools.errors import InputError, LossRefusedError, UsageError
from tumtools.formats.mcap.recording import McapRecording
from tumtools.formats.options import ReadOptions
from tumtools.images.codec import canonical, pixels_of
from tumtools.model.sequence import streams_of
from tumtools.sources import open_source

if TYPE_CHECKING:
    from pathlib import Path

    from tumtools.formats.ros.recording import MessageEncoding
    from tumtools.model.sequence import Sequence

STAMPS = [START + n * 33_000_000 for n in range(5)]


def _recording(path: Path, encoding: MessageEncoding = "cdr", **writer: Any) -> Path:
    with Foreign(path, encoding, writer) as file:
        for row, stamp in enumerate(STAMPS):
            file.image("/camera/color/image_raw", stamp, row, late=5_000_000)
            file.image("/camera/aligned_depth_to_color/image_raw", stamp + 10, row, encoding="16UC1")
            file.imu(stamp + 1000, float(row))
            file.pose(stamp + 2000, float(row))
        file.other("/markers", "SceneUpdate", "protobuf", b"\x0a\x00")
        file.other("/log", "Log", "jsonschema")
        file.library.add_attachment(START, START, "calibration.yaml", "text/plain", b"x: 1")
        file.library.add_metadata("somebody", {"a": "b"})
        file.library.add_metadata("operator", {"name": "Ada"})
        file.library.add_metadata("somebody", {"a": "c"})
    return path


def _check(sequence: Sequence) -> None:
    assert list(sequence.info.images) == ["rgb", "depth"]
    assert sequence.image_stamps("rgb").tolist() == STAMPS
    assert sequence.image_stamps("depth").tolist() == [stamp + 10 for stamp in STAMPS]
    frames = list(sequence.images())
    assert [frame.stamp for frame in frames] == sorted(frame.stamp for frame in frames)
    for frame in frames:
        found = frame.load()
        expected = picture(frame.stream, frame.row, encoding="bgr8" if frame.stream == "rgb" else None)
        assert found.encoding == expected.encoding
        np.testing.assert_array_equal(pixels_of(found), pixels_of(expected))
    assert sequence.info.images["depth"].depth_units_per_metre == 1000
    assert sequence.accelerometer is not None
    assert sequence.groundtruth is not None
    assert sequence.accelerometer.values[:, 0].tolist() == [0, 1, 2, 3, 4]
    assert sequence.groundtruth.positions[:, 0].tolist() == [0, 1, 2, 3, 4]
    assert sequence.info.frame_ids["rgb"] == "somewhere"
    assert sequence.info.frame_ids["groundtruth"] == "map"


@pytest.mark.parametrize("encoding", ["cdr", "ros1"])
@pytest.mark.parametrize("writer", WRITERS)
def test_what_the_writer_left_out_is_found_all_the_same(
    tmp_path: Path, writer: str, encoding: MessageEncoding
) -> None:
    with open_source(_recording(tmp_path / "x.mcap", encoding, **WRITERS[writer])) as sequence:
        _check(sequence)
        dropped = {loss.stream: loss for loss in sequence.info.not_carried}
        counts = {"attachments": 1, "metadata operator": 1, "metadata somebody": 2, "rgb": 5}
        assert {name: loss.count for name, loss in dropped.items()} == {"/markers": 1, "/log": 1, **counts}
        assert "foxglove.SceneUpdate" in dropped["/markers"].why
        assert not sequence.info.warnings


def test_messages_beside_the_chunks_are_found_if_nothing_counts_them(tmp_path: Path) -> None:
    """An index names messages in chunks only."""
    with Foreign(tmp_path / "x.mcap", writer={"use_statistics": False}) as file:
        file.imu(START, 0.0)
        with file.beside_the_chunks():
            file.imu(START + 1, 1.0)
    with open_source(tmp_path / "x.mcap") as sequence:
        assert sequence.accelerometer is not None
        assert sequence.accelerometer.values[:, 0].tolist() == [0, 1]


@pytest.mark.parametrize("writer", WRITERS)
def test_our_own_metadata_survives_other_writers(tmp_path: Path, writer: str) -> None:
    """As when somebody filters or merges our files."""
    convert(full(), tmp_path / "ours.mcap", "mcap")
    ours = McapRecording(tmp_path / "ours.mcap")
    with Foreign(tmp_path / "theirs.mcap", writer=WRITERS[writer]) as file:
        file.copy(ours)
    with open_source(tmp_path / "theirs.mcap") as sequence:
        assert sequence.info.name == "memory"
        assert sequence.info.camera == "fr1"
        assert sequence.image_stamps("ir").tolist() == [START, START + 100, START + SECOND]
        report = convert(sequence, tmp_path / "again.mcap", "mcap")
    assert report.losses == ()
    assert (tmp_path / "again.mcap").read_bytes() == (tmp_path / "ours.mcap").read_bytes()


def test_chunks_that_overlap_in_time(tmp_path: Path) -> None:
    with Foreign(tmp_path / "x.mcap", writer={"chunk_size": 400}) as file:
        for row, stamp in reversed(list(enumerate(STAMPS))):
            file.image("/camera/color/image_raw", stamp, row)
        for row, stamp in enumerate(STAMPS):
            file.compressed("/camera/depth/image_raw", stamp + 10, row, stream="depth")
    with open_source(tmp_path / "x.mcap") as sequence:
        assert sequence.image_stamps("rgb").tolist() == STAMPS
        assert [frame.stamp for frame in sequence.images()] == sorted(STAMPS + [s + 10 for s in STAMPS])
        assert sequence.info.images["depth"].depth_units_per_metre == 1000


@pytest.mark.parametrize("late", [[9, 0, 7, 1, 30], [0, 500, 400, 300, 200]])
def test_images_come_in_order_of_their_headers(tmp_path: Path, late: list[int]) -> None:
    """Frames that were received out of order wait; the log's time is no stamp."""
    with Foreign(tmp_path / "x.mcap") as file:
        for row, stamp in enumerate(STAMPS):
            file.image("/camera/color/image_raw", stamp, row, late=late[row] * 10_000_000)
            file.image(
                "/camera/depth/image_raw", stamp + 10, row, encoding="16UC1", late=late[-row] * 7_000_000
            )
    with open_source(tmp_path / "x.mcap") as sequence:
        frames = list(sequence.images())
        assert [frame.stamp for frame in frames] == sorted(STAMPS + [s + 10 for s in STAMPS])
        for frame in frames:
            expected = picture(frame.stream, frame.row, encoding="bgr8" if frame.stream == "rgb" else None)
            np.testing.assert_array_equal(pixels_of(frame.load()), pixels_of(expected))
        part = list(sequence.images(["depth"], STAMPS[1], STAMPS[3] + 10))
        assert [frame.row for frame in part] == [1, 2, 3]
        assert list(sequence.images(start=STAMPS[-1] + SECOND)) == []


def test_streams_whose_clocks_disagree_are_not_kept_in_memory(tmp_path: Path) -> None:
    """Depth is stamped by a clock that is an hour behind."""
    with Foreign(tmp_path / "x.mcap") as file:
        for row in range(100):
            stamp = START + row * 33_000_000
            file.image("/camera/color/image_raw", stamp, row)
            file.image(
                "/camera/depth/image_raw", stamp - 3600 * SECOND, row, encoding="16UC1", late=3600 * SECOND
            )
    with open_source(tmp_path / "x.mcap") as sequence:
        frames = list(sequence.images())
        assert [frame.stream for frame in frames] == ["depth"] * 100 + ["rgb"] * 100
        assert [frame.row for frame in frames] == [*range(100), *range(100)]
        assert sequence._images.most_waiting(["rgb", "depth"]) > 50
        assert sequence._images.most_waiting(["rgb"]) == 0


def test_several_candidates_are_an_error_that_lists_them(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    with Foreign(path) as file:
        for topic in ("/left/image_raw", "/right/image_raw"):
            for row, stamp in enumerate(STAMPS):
                file.image(topic, stamp, row)
        file.imu(START, 1.0, "/imu/a")
        file.imu(START, 2.0, "/imu/b")
        file.pose(START, 1.0)
    with pytest.raises(UsageError, match=r"/left/image_raw .* /right/image_raw") as caught:
        open_source(path)
    assert caught.value.path == str(path)
    assert "--topic rgb=/left/image_raw" in str(caught.value.hint)
    options = ReadOptions(topics={"rgb": "/right/image_raw", "accelerometer": "/imu/b"})
    with open_source(path, options) as sequence:
        assert sequence.info.images["rgb"].source == "/right/image_raw"
        assert sequence.accelerometer is not None
        assert sequence.accelerometer.values[0, 0] == 2
        assert {loss.stream for loss in sequence.info.not_carried} == {"/left/image_raw", "/imu/a"}
    with open_source(path, ReadOptions(lenient=True)) as sequence:
        assert sequence.info.images == {}
        assert len(sequence.info.warnings) == 2
        assert sequence.groundtruth is not None


@pytest.mark.parametrize(
    ("topics", "why"),
    [
        ({"rgb": "/nowhere"}, "no such topic"),
        ({"rgb": "/imu/data"}, "its type is sensor_msgs/msg/Imu"),
        ({"depth": "/log"}, "its type is"),
        ({"groundtruth": "/camera/color/image_raw"}, "its type is"),
    ],
)
def test_topics_that_do_not_fit_are_refused(tmp_path: Path, topics: dict[str, str], why: str) -> None:
    with pytest.raises(UsageError, match=why) as caught:
        open_source(_recording(tmp_path / "x.mcap"), ReadOptions(topics=topics))
    assert caught.value.hint


def test_a_file_without_images_is_a_sequence_of_signals(tmp_path: Path) -> None:
    with Foreign(tmp_path / "x.mcap") as file:
        for row, stamp in enumerate(STAMPS):
            file.pose(stamp, float(row))
    with open_source(tmp_path / "x.mcap") as sequence:
        assert sequence.info.images == {}
        assert sequence.groundtruth is not None
        assert len(sequence.groundtruth) == 5
        assert list(sequence.images()) == []


def test_a_file_without_anything(tmp_path: Path) -> None:
    with Foreign(tmp_path / "x.mcap"):
        pass
    with open_source(tmp_path / "x.mcap") as sequence:
        assert sequence.info.images == {}
        assert sequence.groundtruth is None


def test_foreign_colour_is_not_swapped_on_the_way_to_png(tmp_path: Path) -> None:
    with open_source(_recording(tmp_path / "x.mcap")) as sequence:
        convert(sequence, tmp_path / "out", "tum")
    with open_source(tmp_path / "out") as result:
        frame = next(result.images(["rgb"]))
        expected, _ = canonical(pixels_of(picture("rgb", 0, encoding="bgr8")), "bgr8")
        np.testing.assert_array_equal(pixels_of(frame.load()), expected)


@pytest.mark.parametrize(
    "definition",
    [
        "uint8 x\n",
        "uint32 height\nuint32 width\nstd_msgs/Header header\n"
        + "=" * 80
        + "\nMSG: std_msgs/Header\nuint8 x\n",
    ],
)
def test_an_image_type_that_is_none_is_an_error_of_ours(tmp_path: Path, definition: str) -> None:
    from tumtools.errors import InputError

    with Foreign(tmp_path / "x.mcap") as file:
        number = file.channel("/camera/color/image_raw", "sensor_msgs/msg/Image", definition)
        file.library.add_message(number, START, b"\0\1\0\0" + bytes(40), START)
    with pytest.raises(InputError, match=r"x\.mcap"):
        open_source(tmp_path / "x.mcap")


@pytest.mark.real
@pytest.mark.parametrize("name", ["evo/nav2_turtlebot.mcap", "rosbag2/talker_mcap/talker.mcap"])
def test_real_recordings(real_data: Path, name: str) -> None:
    with open_source(real_data / "bags" / name, ReadOptions(lenient=True)) as sequence:
        assert sequence.info.not_carried
        assert all(loss.why for loss in sequence.info.not_carried)


def test_frame_ids_that_change_within_a_stream_are_a_loss(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    with Foreign(path) as file:
        for row, stamp in enumerate(STAMPS):
            file.image("/camera/color/image_raw", stamp, row, frame_id=f"camera{row % 2}")
    with open_source(path) as sequence:
        (loss,) = sequence.info.not_carried
        assert (loss.stream, loss.what, loss.count) == ("rgb", "frame ids of single messages", 2)
        with pytest.raises(LossRefusedError):
            convert(sequence, tmp_path / "y.mcap", "mcap", options=ConvertOptions(strict=True))


@pytest.mark.parametrize("encoding", ["cdr", "ros1"])
def test_calibrations_that_change_within_a_stream_are_a_loss(
    tmp_path: Path, encoding: MessageEncoding
) -> None:
    path = tmp_path / "x.mcap"
    with Foreign(path, encoding) as file:
        for row, stamp in enumerate(STAMPS):
            file.image("/camera/color/image_raw", stamp, row)
            file.calibration("/camera/color/camera_info", stamp, 500.0 + (row > 2))
            file.image("/camera/depth/image_raw", stamp, row, encoding="16UC1")
            file.calibration("/camera/depth/camera_info", stamp, 500.0)
    with open_source(path) as sequence:
        (loss,) = sequence.info.not_carried
        assert (loss.stream, loss.count) == ("rgb", 2)
        assert "calibrations" in loss.what
        assert sequence.cameras["rgb"].k[0] == 500
        with pytest.raises(LossRefusedError):
            convert(sequence, tmp_path / "y.mcap", "mcap", options=ConvertOptions(strict=True))
        convert(sequence, tmp_path / "y.mcap", "mcap")
    with open_source(tmp_path / "y.mcap") as result:
        assert result.info.not_carried == ()


def test_what_is_not_wanted_need_not_be_clear(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    with Foreign(path) as file:
        for row, stamp in enumerate(STAMPS):
            file.image("/camera/color/image_raw", stamp, row)
            file.image("/camera/other/image_raw", stamp, row)
            file.imu(stamp, 1.0)
            file.imu(stamp, 1.0, "/imu/other")
            file.pose(stamp, float(row))
    with open_source(path, ReadOptions(streams=frozenset({"groundtruth"}))) as sequence:
        assert streams_of(sequence) == ("groundtruth",)
        assert sequence.info.sources == {"groundtruth": "/mocap/pose"}
        assert sequence.info.warnings == ()
    with pytest.raises(UsageError, match="several topics could be accelerometer"):
        open_source(path, ReadOptions(streams=frozenset({"groundtruth", "accelerometer"})))
    assert run(["convert", str(path), str(tmp_path / "y"), "--to", "tum", "--streams", "groundtruth"]) == 0
    assert run(["evaluate", "ate", str(path), str(tmp_path / "y" / "groundtruth.txt")]) == 0


@pytest.mark.parametrize("to", ["tum", "mcap", "rosbag1", "rosbag2", "rawlog"])
def test_a_recording_without_any_stream_is_no_input(tmp_path: Path, to: str) -> None:
    path = tmp_path / "x.mcap"
    with Foreign(path) as file:
        file.other("/log", "Log", "jsonschema")
    with open_source(path) as sequence, pytest.raises(InputError, match="nothing to convert"):
        convert(sequence, tmp_path / "y", to)
    assert sorted(tmp_path.iterdir()) == [path]
