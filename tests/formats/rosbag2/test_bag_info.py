# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""metadata.yaml in the versions that the releases of ROS 2 read."""

from __future__ import annotations

import pytest
import yaml

from tumtools.formats.ros.messages import STRING, TF_MESSAGE, TYPE_HASHES
from tumtools.formats.ros.qos import is_latched
from tumtools.formats.ros.recording import OutChannel, OutMessage
from tumtools.formats.rosbag2.bag_info import (
    DISTRO_VERSIONS,
    Tally,
    format_bag_info,
    parse_bag_info,
    quoted,
)

CHANNELS = (OutChannel("/text", STRING), OutChannel("/tf_static", TF_MESSAGE, latched=True))
CUSTOM = {"name": "fr1/rpy", "text": '{"head": "# a\\n\\t\\u00e9"}\n\x85\u2028\U0001f600 "quoted" \\'}


def describe(distro: str) -> str:
    tally = Tally(CHANNELS)
    messages = [OutMessage(0, 30, (b"",)), OutMessage(0, 10, (b"",)), OutMessage(1, 50, (b"",))]
    assert list(tally.watch(messages)) == messages
    text, copy = format_bag_info(
        tally.summary("a_0.db3"), storage="sqlite3", ros_distro=distro, custom_data=CUSTOM
    )
    assert yaml.safe_load(text) == {"rosbag2_bagfile_information": yaml.safe_load(copy)}
    return text


def load(distro: str) -> dict[str, object]:
    return yaml.safe_load(describe(distro))["rosbag2_bagfile_information"]


@pytest.mark.parametrize("distro", DISTRO_VERSIONS)
def test_every_version_is_read_back(distro: str) -> None:
    info = parse_bag_info(describe(distro), "metadata.yaml")
    assert (info.storage, info.files, info.compression_mode) == ("sqlite3", ("a_0.db3",), "")
    assert not is_latched(info.qos["/text"])
    assert is_latched(info.qos["/tf_static"])
    assert info.custom_data == CUSTOM


def test_the_default_is_what_humble_reads() -> None:
    assert next(iter(DISTRO_VERSIONS)) == "humble"
    info = load("humble")
    assert info["version"] == 8
    assert info["message_count"] == 3
    assert info["starting_time"] == {"nanoseconds_since_epoch": 10}
    assert info["duration"] == {"nanoseconds": 40}
    for topic, durability in zip(info["topics_with_message_count"], (2, 1), strict=True):
        (profile,) = yaml.safe_load(topic["topic_metadata"]["offered_qos_profiles"])
        assert profile["durability"] == durability
        kind = topic["topic_metadata"]["type"]
        assert topic["topic_metadata"]["type_description_hash"] == TYPE_HASHES[kind]


def test_later_releases_have_words_in_a_list() -> None:
    info = load("jazzy")
    assert info["version"] == 9
    (profile,) = info["topics_with_message_count"][1]["topic_metadata"]["offered_qos_profiles"]
    assert (profile["durability"], profile["reliability"]) == ("transient_local", "reliable")


def test_early_releases_have_no_more_than_they_know_but_for_our_own_data() -> None:
    info = load("foxy")
    assert info["version"] == 4
    assert not {"files", "ros_distro"} & info.keys()
    assert info["custom_data"] == CUSTOM, "or the way back would lose what messages have no field for"


@pytest.mark.parametrize(
    "text", ["", "plain", "\x00\x7f\x85", "\u2028\ufeff", "\U0010ffff", "a: b # c\n- d\t'"]
)
def test_any_text_survives_quoting(text: str) -> None:
    assert quoted(text).isascii()
    assert yaml.safe_load(quoted(text)) == text
