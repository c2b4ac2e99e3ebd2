# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""rosbag2 folders that we write, read by other people's libraries and programs."""

from __future__ import annotations

import hashlib
import re
import sqlite3
from contextlib import closing
from typing import TYPE_CHECKING, Any

import pytest
import yaml
from mcap_ros2._dynamic import generate_dynamic
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

from tests.interop.expected import check_messages, write
from tests.interop.programs import program, read_with_node, run

if TYPE_CHECKING:
    from pathlib import Path

pytestmark = [pytest.mark.interop, pytest.mark.real]


@pytest.fixture(scope="module")
def sqlite_bag(real_sequence: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(real_sequence, tmp_path_factory.mktemp("bag") / "rpy", "rosbag2")


@pytest.fixture(scope="module")
def mcap_bag(real_sequence: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(real_sequence, tmp_path_factory.mktemp("bag") / "rpy", "rosbag2", storage="mcap")


def plain(value: Any) -> Any:
    """Turn a message of mcap-ros2-support into what JSON could hold."""
    if isinstance(value, (bytes, memoryview, bytearray)):
        return {"length": len(value), "sha256": hashlib.sha256(value).hexdigest()}
    if hasattr(value, "nanosec"):
        return str(value.sec * 10**9 + value.nanosec)
    if hasattr(value, "__slots__"):
        return {name: plain(getattr(value, name)) for name in value.__slots__}
    return [plain(item) for item in value] if isinstance(value, (list, tuple)) else value


def test_sqlite_is_decoded_with_its_embedded_definitions(sqlite_bag: Path, real_sequence: Path) -> None:
    query = (
        "SELECT t.name, t.type, m.timestamp, m.data FROM messages m JOIN topics t ON t.id = m.topic_id "
        "ORDER BY m.timestamp, m.id"
    )
    with closing(sqlite3.connect(sqlite_bag / "rpy_0.db3")) as database:
        assert database.execute("PRAGMA integrity_check").fetchall() == [("ok",)]
        definitions = dict(
            database.execute("SELECT topic_type, encoded_message_definition FROM message_definitions")
        )
        decoders = {kind: generate_dynamic(kind, text)[kind] for kind, text in definitions.items()}
        messages = [
            {"topic": topic, "time": str(time), "message": plain(decoders[kind](data))}
            for topic, kind, time, data in database.execute(query)
        ]
    check_messages(real_sequence, messages, png=True)


def test_foxglove_reads_sqlite(sqlite_bag: Path, real_sequence: Path) -> None:
    check_messages(real_sequence, read_with_node("rosbag2_sqlite3", sqlite_bag / "rpy_0.db3"), png=True)


def test_foxglove_reads_mcap_storage(mcap_bag: Path, real_sequence: Path) -> None:
    check_messages(real_sequence, read_with_node("mcap", mcap_bag / "rpy_0.mcap"), png=True)


def test_foxglove_reads_mcap_of_profile_ros1(real_sequence: Path, tmp_path: Path) -> None:
    path = write(real_sequence, tmp_path / "rpy.mcap", "mcap", profile="ros1")
    check_messages(real_sequence, read_with_node("mcap", path), png=True)


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_rosbags_reads_topics_qos_and_custom_data(
    storage: str, sqlite_bag: Path, mcap_bag: Path, real_sequence: Path
) -> None:
    store = get_typestore(Stores.ROS2_HUMBLE)
    with Reader(sqlite_bag if storage == "sqlite3" else mcap_bag) as reader:
        assert reader.message_count == sum(1 for _ in reader.messages())
        for connection in reader.connections:
            assert connection.digest == store.hash_rihs01(connection.msgtype)
            (profile,) = connection.ext.offered_qos_profiles
            assert (profile.reliability.name, profile.durability.name) == ("RELIABLE", "VOLATILE")
        custom = reader.storage.metadata.custom  # there is no other way to them
        assert custom is not None
        assert custom["name"] == real_sequence.name


def test_metadata_is_what_the_parser_of_humble_expects(sqlite_bag: Path) -> None:
    info = yaml.safe_load((sqlite_bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert info["version"] == 8
    for topic in info["topics_with_message_count"]:
        profiles = yaml.safe_load(topic["topic_metadata"]["offered_qos_profiles"])
        for profile in profiles:
            assert all(type(profile[name]) is int for name in ("history", "reliability", "durability"))


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_evo_reads_the_same_trajectory(
    storage: str, sqlite_bag: Path, mcap_bag: Path, real_sequence: Path
) -> None:
    evo = program("evo_traj", "TUMTOOLS_EVO")
    bag = sqlite_bag if storage == "sqlite3" else mcap_bag
    facts = [
        re.findall(r"infos:\s*(\d+) poses, ([\d.]+)m path length", run(evo, *arguments))
        for arguments in (("bag2", bag, "/groundtruth/pose"), ("tum", real_sequence / "groundtruth.txt"))
    ]
    assert facts[0] == facts[1]
    assert facts[0][0][0] == "401"
