# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Recordings of other people, as they are."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING

import pytest

from tumtools.digest import digest
from tumtools.errors import InputError
from tumtools.formats.options import ReadOptions
from tumtools.formats.rosbag1.recording import BagRecording
from tumtools.formats.rosbag2.recording import Rosbag2Recording
from tumtools.sources import open_source

if TYPE_CHECKING:
    from pathlib import Path

    from tumtools.formats.ros.recording import Recording

pytestmark = pytest.mark.real


@pytest.fixture(scope="module")
def bags(real_data: Path) -> Path:
    return real_data / "bags"


def content(recording: Recording) -> str:
    """Digest everything that two recordings share whatever their compression."""
    state = hashlib.sha256()
    for message in recording.messages(recording.channels):
        state.update(f"{message.channel.topic} {message.log_time} {len(message.data)}\n".encode())
        state.update(message.data)
    return state.hexdigest()


@pytest.mark.parametrize(
    ("name", "rows"),
    [
        ("evo/tf_example.bag", 0),
        ("evo/tf_example", 0),
        ("evo/tf_example/tf_example.db3", 0),
        ("evo/nav2_turtlebot.mcap", 0),
        ("foxglove/example.bag", 0),
        ("robot_localization_test2.bag", 3061),
        ("rosbag2/talker_mcap", 0),
        ("rosbag2/talker_sqlite3", 0),
        ("rosbag2/wbag_mcap", 0),
        ("tum_freiburg1_calibration.bag", 0),
    ],
)
def test_every_recording_can_be_looked_at(bags: Path, name: str, rows: int) -> None:
    with open_source(bags / name, ReadOptions(lenient=True)) as sequence:
        assert len(sequence.accelerometer or ()) == rows
        assert sequence.info.not_carried or rows
        digest(sequence)


def test_an_empty_file_and_a_bag_without_messages_are_told_apart(bags: Path) -> None:
    with pytest.raises(InputError, match=r"empty-file\.bag.*: the file is empty \(0 bytes\)"):
        open_source(bags / "foxglove" / "empty-file.bag")
    with open_source(bags / "foxglove" / "no-messages.bag") as sequence:
        assert sequence.info.warnings == ("the recording has no messages",)


def test_compression_changes_nothing(bags: Path) -> None:
    names = ("example.bag", "example-bz2.bag", "example-lz4.bag")
    assert len({content(BagRecording(bags / "foxglove" / name)) for name in names}) == 1


def test_split_recording_is_one_in_order_of_time(bags: Path) -> None:
    recording = Rosbag2Recording(bags / "rosbag2" / "wbag_mcap")
    times = [message.log_time for message in recording.messages(recording.channels)]
    assert len(times) == 6074
    assert times == sorted(times)
    assert sum(channel.count or 0 for channel in recording.channels) == 6074


def test_the_same_transforms_in_both_containers(bags: Path) -> None:
    options = ReadOptions(topics={"groundtruth": "/tf:odom.base_footprint"})
    with (
        open_source(bags / "evo" / "tf_example.bag", options) as first,
        open_source(bags / "evo" / "tf_example", options) as second,
    ):
        assert first.groundtruth is not None
        assert second.groundtruth is not None
        assert len(first.groundtruth) == 517
        assert first.groundtruth.values.tolist() == second.groundtruth.values.tolist()
        assert first.groundtruth.stamps.tolist() == second.groundtruth.stamps.tolist()


@pytest.mark.parametrize("name", ["evo/tf_example.bag", "tum_freiburg1_calibration.bag"])
def test_transforms_that_are_nowhere_used_are_offered(bags: Path, name: str) -> None:
    with open_source(bags / name) as sequence:
        assert sequence.groundtruth is None
        assert any("--topic groundtruth=/tf:WORLD.CAMERA" in text for text in sequence.info.warnings)


def test_navigation_recording_offers_its_poses(bags: Path) -> None:
    for topic, count in (("/odom", 2639), ("/amcl_pose", 135)):
        options = ReadOptions(topics={"groundtruth": topic})
        with open_source(bags / "evo" / "nav2_turtlebot.mcap", options) as sequence:
            assert len(sequence.groundtruth or ()) == count
