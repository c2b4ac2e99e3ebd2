# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Channels of one topic are read as one, as in bags, where they say the same of its messages."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from tests.formats.mcap.by_hand import IMU, ByHand, One, in_order, value_of
from tests.formats.mcap.foreign import Foreign
from tests.memory import START
from tumtools.convert import ConvertOptions, convert
from tumtools.digest import digest
from tumtools.errors import InputError, UsageError
from tumtools.formats.mcap.recording import McapRecording
from tumtools.formats.options import ReadOptions
from tumtools.formats.ros.qos import qos_profile
from tumtools.formats.rosbag2.recording import Rosbag2Recording
from tumtools.sources import open_source

if TYPE_CHECKING:
    from pathlib import Path

    from tumtools.formats.ros.recording import Recording

LATCHED = {"offered_qos_profiles": qos_profile(latched=True)}
PUBLISHERS = ByHand(
    [
        [One(1, START + 10 * n, n) for n in range(20)],
        [One(2, START + 10 * n + 5, 100 + n) for n in range(20)],
        One(2, START + 50, 200),
        [One(channel, START + 500, 300 + channel) for channel in (2, 1, 3)],
    ],
    channels={1: (1, "/imu"), 2: (2, "/imu"), 3: (1, "/other")},
    schemas={1: IMU, 2: IMU},
)
"""Two publishers, whose messages are of the same schema under two numbers, and another topic."""


def _rows(recording: Recording) -> list[tuple[str, int, float]]:
    found = recording.messages(recording.channels)
    return [(one.channel.topic, one.log_time, value_of(one.data)) for one in found]


def test_publishers_of_one_topic_are_one_channel(tmp_path: Path) -> None:
    recording = McapRecording(PUBLISHERS.write(tmp_path / "x.mcap"))
    imu, other = recording.channels
    assert (imu.topic, imu.count, imu.latched) == ("/imu", 43, False)
    assert (other.topic, other.count) == ("/other", 1)
    assert [row[1:] for row in _rows(recording)] == in_order(PUBLISHERS)
    expected = [(time, x) for time, x in in_order(PUBLISHERS) if x != 303]
    assert recording.log_times(imu).tolist() == [time for time, _ in expected]
    batches = list(recording.batches([imu]))
    assert np.concatenate([batch.log_times for batch in batches]).tolist() == [time for time, _ in expected]
    found = [
        value_of(batch.data[start : start + length].data)
        for batch in batches
        for start, length in zip(batch.starts.tolist(), batch.lengths.tolist(), strict=True)
    ]
    assert found == [x for _, x in expected]
    assert {batch.channel.id for batch in batches} == {imu.id}


def test_messages_of_several_publishers_are_taken_together_from_a_chunk(tmp_path: Path) -> None:
    chunk = [One(1 + n % 2, START + n, n) for n in range(100)]
    path = ByHand([chunk], channels={1: (1, "/imu"), 2: (1, "/imu")}).write(tmp_path / "x.mcap")
    recording = McapRecording(path)
    (batch,) = recording.batches(recording.channels)
    assert batch.log_times.tolist() == [START + n for n in range(100)]
    with open_source(path) as sequence:
        assert sequence.accelerometer is not None
        assert sequence.accelerometer.values[:, 0].tolist() == list(range(100))
        assert sequence.info.sources == {"accelerometer": "/imu"}
        assert sequence.info.not_carried == ()


def test_a_topic_is_latched_if_one_of_its_publishers_latches(tmp_path: Path) -> None:
    file = replace(PUBLISHERS, extra={2: LATCHED})
    imu, other = McapRecording(file.write(tmp_path / "x.mcap")).channels
    assert (imu.latched, other.latched) == (True, False)


DIFFERENT = {
    "definition": ({2: (*IMU[:2], IMU[2] + "# another\n")}, 2),
    "type": ({2: ("my_msgs/msg/Imu", *IMU[1:])}, 2),
    "encoding": ({2: (IMU[0], "ros2idl", IMU[2])}, 2),
    "no schema": ({}, 0),
    "a schema that is nowhere": ({}, 7),
}


@pytest.mark.parametrize(("schemas", "number"), DIFFERENT.values(), ids=DIFFERENT)
def test_channels_that_differ_in_what_they_say_stay_apart(
    tmp_path: Path, schemas: dict[int, tuple[str, str, str]], number: int
) -> None:
    file = replace(
        PUBLISHERS,
        channels={1: (1, "/imu"), 2: (number, "/imu"), 3: (1, "/other")},
        schemas={1: IMU, **schemas},
    )
    recording = McapRecording(file.write(tmp_path / "x.mcap"))
    assert [(one.topic, one.count) for one in recording.channels] == [
        ("/imu", 21),
        ("/imu", 22),
        ("/other", 1),
    ]
    assert len(_rows(recording)) == 44


def test_channels_of_one_topic_that_differ_have_to_be_chosen_between(tmp_path: Path) -> None:
    file = ByHand(
        [[One(1, START, 1), One(2, START + 1, 2)]],
        channels={1: (1, "/imu"), 2: (2, "/imu")},
        schemas={1: IMU, 2: (*IMU[:2], IMU[2] + "# another\n")},
    )
    with pytest.raises(UsageError, match="several topics could be accelerometer"):
        open_source(file.write(tmp_path / "x.mcap"))


def test_images_of_a_recording_that_was_split_and_joined_are_one_stream(tmp_path: Path) -> None:
    """With other numbers of channels and schemas behind the seam, as programs that join recordings write."""
    made = {}
    for joined in (True, False):
        path = tmp_path / f"{joined}" / "x.mcap"
        path.parent.mkdir()
        with Foreign(path, writer={"chunk_size": 400}) as file:
            for row in range(8):
                if joined and row == 4:
                    file.forget()
                file.image("/camera/color/image_raw", START + row * 10**7, row)
                file.image("/camera/depth/image_raw", START + row * 10**7, row, encoding="16UC1")
                file.imu(START + row, float(row))
            file.other("/log", "Log", "jsonschema")
            if joined:
                file.other("/log", "Log", "jsonschema")
        with open_source(path) as sequence:
            assert sequence.info.images["rgb"].count == 8
            assert [frame.row for frame in sequence.images(["depth"])] == [*range(8)]
            losses = {loss.stream: loss.count for loss in sequence.info.not_carried}
            assert losses == {"/log": 1 + joined}
            convert(sequence, path.with_name("y"), "tum")
        texts = {one.name: one.read_bytes() for one in path.with_name("y").glob("*.txt")}
        with open_source(path.with_name("y")) as result:
            made[joined] = texts, digest(result).value
    assert made[True] == made[False]


def test_strict_refuses_nothing_of_what_is_read_together(tmp_path: Path) -> None:
    path = ByHand(
        [[One(1 + n % 2, START + n * 10**7, n) for n in range(10)]],
        channels={1: (1, "/imu"), 2: (1, "/imu")},
    ).write(tmp_path / "x.mcap")
    with open_source(path) as sequence:
        report = convert(sequence, tmp_path / "y.mcap", "mcap", options=ConvertOptions(strict=True))
    assert report.losses == ()


def test_what_a_salvage_leaves_out_of_a_topic_is_told_once(tmp_path: Path) -> None:
    file = replace(PUBLISHERS, counted={1: 22, 2: 25, 3: 1})
    path = file.write(tmp_path / "x.mcap")
    with pytest.raises(InputError, match="22 messages of channel 1; 21 are found"):
        McapRecording(path)
    recording = McapRecording(path, salvage=True)
    assert [(loss.stream, loss.count) for loss in recording.left_out] == [("/imu", 4)]
    with open_source(path, ReadOptions(salvage=True, lenient=True)) as sequence:
        assert [warning for warning in sequence.info.warnings if "offset" in warning] == []


def test_a_file_of_a_rosbag2_is_read_likewise(tmp_path: Path) -> None:
    PUBLISHERS.write(tmp_path / "x.mcap")
    recording = Rosbag2Recording(tmp_path / "x.mcap")
    assert [(one.topic, one.count) for one in recording.channels] == [("/imu", 43), ("/other", 1)]
    assert [row[1:] for row in _rows(recording)] == in_order(PUBLISHERS)
    batches = list(recording.batches(recording.channels))
    assert sum(len(batch.log_times) for batch in batches) == 44
