# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING

import pytest
from rosbags.rosbag1 import Reader

from tests.formats.rosbag1.samples import (
    CONNECTIONS,
    SECOND,
    START,
    bag_bytes,
    plain,
    read,
    some_messages,
    string,
)
from tumtools.errors import OutputError
from tumtools.formats.ros.recording import OutMessage
from tumtools.formats.rosbag1.compression import COMPRESSIONS
from tumtools.formats.rosbag1.recording import BagRecording
from tumtools.formats.rosbag1.structure import Connection

if TYPE_CHECKING:
    from pathlib import Path


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_what_is_written_is_read_in_the_same_order(tmp_path: Path, compression: str) -> None:
    messages = some_messages(200)
    path = tmp_path / "a.bag"
    path.write_bytes(bag_bytes(messages, compression))

    assert read(path) == plain(messages)


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_another_reader_reads_the_same(tmp_path: Path, compression: str) -> None:
    messages = some_messages(200)
    path = tmp_path / "a.bag"
    path.write_bytes(bag_bytes(messages, compression))

    with Reader(path) as reader:
        found = [(connection.topic, time, bytes(data)) for connection, time, data in reader.messages()]
        assert {c.topic: (c.msgtype, c.digest, c.ext.latching) for c in reader.connections} == {
            c.topic: ("std_msgs/msg/String", c.md5sum, 1 if c.latched else None) for c in CONNECTIONS
        }
    assert found == plain(messages)


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_bytes_do_not_depend_on_the_number_of_threads(compression: str) -> None:
    messages = some_messages(200)
    digests = {hashlib.sha256(bag_bytes(messages, compression, jobs=jobs)).hexdigest() for jobs in (1, 2, 5)}
    assert len(digests) == 1


def test_lz4_frames_are_those_that_ros_reads() -> None:
    """roslz4 wants independent blocks, a content checksum and no content size: descriptor byte 0x64."""
    bag = bag_bytes(some_messages(), "lz4")
    frames = [bag[at + 4] for at in range(len(bag)) if bag.startswith(b"\x04\x22\x4d\x18", at)]
    assert frames
    assert set(frames) == {0x64}


def test_topics_latching_and_counts_come_from_the_index(tmp_path: Path) -> None:
    path = tmp_path / "a.bag"
    path.write_bytes(bag_bytes(some_messages(40)))
    bag = BagRecording(path)

    assert [(c.topic, c.type, c.encoding, c.count, c.latched) for c in bag.channels] == [
        ("/one", "std_msgs/msg/String", "ros1", 14, False),
        ("/two", "std_msgs/msg/String", "ros1", 13, False),
        ("/static", "std_msgs/msg/String", "ros1", 13, True),
    ]
    assert bag.warnings == ()


def test_a_time_range_includes_both_ends(tmp_path: Path) -> None:
    messages = some_messages(40)
    path = tmp_path / "a.bag"
    path.write_bytes(bag_bytes(messages, "lz4"))
    bag = BagRecording(path)

    first, last = messages[5].stamp, messages[20].stamp
    found = [m.log_time for m in bag.messages(bag.channels[:1], first, last)]
    assert found == [m.stamp for m in messages[5:21] if m.channel == 0]


def test_publishers_of_one_topic_are_one_channel(tmp_path: Path) -> None:
    connections = [
        CONNECTIONS[0],
        CONNECTIONS[0],
        Connection("/one", "std_msgs/UInt8", "0" * 32, "uint8 data\n"),
    ]
    messages = [OutMessage(i % 2, START + i, (string(str(i)),)) for i in range(10)]
    messages.append(OutMessage(2, START + 10, (b"\1",)))
    path = tmp_path / "a.bag"
    path.write_bytes(bag_bytes(messages, connections=connections))
    bag = BagRecording(path)

    assert [(c.topic, c.type, c.count) for c in bag.channels] == [
        ("/one", "std_msgs/msg/String", 10),
        ("/one", "std_msgs/msg/UInt8", 1),
    ]
    assert [bytes(m.data) for m in bag.messages(bag.channels[:1])] == [string(str(i)) for i in range(10)]


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_chunks_that_overlap_in_time_are_merged(tmp_path: Path, compression: str) -> None:
    """Recorders write what comes; a message may be in a later chunk than one with a later stamp."""
    big = "x" * 300_000
    stamps = [START + (i // 2 if i % 2 else 100 - i) * SECOND for i in range(60)]
    messages = [OutMessage(i % 3, stamp, (string(f"{i} {big}"),)) for i, stamp in enumerate(stamps)]
    path = tmp_path / "a.bag"
    path.write_bytes(bag_bytes(messages, compression))

    assert read(path) == sorted(plain(messages), key=lambda message: message[1])


def test_views_stay_valid_after_closing(tmp_path: Path) -> None:
    path = tmp_path / "a.bag"
    path.write_bytes(bag_bytes(some_messages(10)))
    bag = BagRecording(path)
    kept = list(bag.messages(bag.channels))
    bag.close()

    assert [bytes(message.data) for message in kept] == [data for _, _, data in plain(some_messages(10))]


def test_an_iteration_that_is_given_up_leaves_no_thread(tmp_path: Path) -> None:
    path = tmp_path / "a.bag"
    path.write_bytes(bag_bytes(some_messages(300), "bz2"))
    bag = BagRecording(path)
    messages = bag.messages(bag.channels)
    next(messages)
    messages.close()

    assert next(bag.messages(bag.channels)).log_time == START


def test_bag_without_messages_is_a_bag(tmp_path: Path) -> None:
    path = tmp_path / "a.bag"
    path.write_bytes(bag_bytes([]))
    bag = BagRecording(path)

    assert bag.channels == ()
    assert read(path) == []


@pytest.mark.parametrize("stamp", [-1, 2**32 * SECOND])
def test_a_stamp_that_ros_time_cannot_hold_is_refused(stamp: int) -> None:
    with pytest.raises(OutputError, match="stamps of 0 to 4294967295 s"):
        bag_bytes([OutMessage(0, stamp, (string("a"),))])


@pytest.mark.real
@pytest.mark.parametrize(
    "name",
    [
        "evo/tf_example.bag",
        "foxglove/example.bag",
        "foxglove/example-bz2.bag",
        "foxglove/example-lz4.bag",
        "foxglove/no-messages.bag",
        "robot_localization_test2.bag",
        "tum_freiburg1_calibration.bag",
    ],
)
@pytest.mark.parametrize("salvage", [False, True])
def test_real_bags_are_read_as_another_reader_reads_them(real_data: Path, name: str, salvage: bool) -> None:
    path = real_data / "bags" / name
    with Reader(path) as reader:
        expected = [(connection.topic, time, bytes(data)) for connection, time, data in reader.messages()]

    assert read(path, salvage=salvage) == expected
