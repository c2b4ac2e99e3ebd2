# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Embedded definitions are understood as ROS writes them, and hostile ones are refused."""

from __future__ import annotations

from functools import cache

import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from tumtools.errors import InputError
from tumtools.formats.ros import messages
from tumtools.formats.ros.definitions import Field, full_name, parse_definitions

MD5_SUMS = {  # those that the spec says a ROS 1 bag must carry
    messages.IMAGE: "060021388200f6f0f447d0fcd9c64743",
    messages.COMPRESSED_IMAGE: "8f7a12909da2c9d3332d540a0977563f",
    messages.CAMERA_INFO: "c9a58c1b0b154e0e6da7578cb991d214",
    messages.IMU: "6a62c6daae103f4ff57a132d6f95cec2",
    messages.TF_MESSAGE: "94810edda583a504dfda3829e70d7eec",
    messages.OLD_TF_MESSAGE: "94810edda583a504dfda3829e70d7eec",
    messages.POSE_STAMPED: "d3812c3cbc69362b77dc0b19b345f8f5",
    messages.STRING: "992ce8a1687cec8c8bd883ec73ca41d1",
}
SEPARATOR = "=" * 80


@cache
def _humble() -> Typestore:
    return get_typestore(Stores.ROS2_HUMBLE)


def _fields(text: str, kind: str = "a/msg/A") -> list[Field]:
    return list(parse_definitions(text, kind)[kind])


@pytest.mark.parametrize(("kind", "md5"), MD5_SUMS.items())
def test_md5_sums_are_those_of_ros(kind: str, md5: str) -> None:
    assert messages.ros1_md5_sum(kind) == md5


@pytest.mark.parametrize("kind", messages.TYPE_HASHES)
def test_type_hashes_are_those_of_ros_2(kind: str) -> None:
    assert messages.TYPE_HASHES[kind] == _humble().hash_rihs01(kind)


@pytest.mark.parametrize("kind", messages.TYPE_HASHES)
def test_the_definitions_we_embed_hash_to_the_same(kind: str) -> None:
    """What another library makes of our text is the message of the distribution."""
    store = Typestore()
    store.register(get_types_from_msg(messages.definition(kind, "cdr"), kind))
    assert store.hash_rihs01(kind) == messages.TYPE_HASHES[kind]


@pytest.mark.parametrize("kind", MD5_SUMS)
def test_the_ros_1_definitions_we_embed_have_the_same_md5(kind: str) -> None:
    store = Typestore()
    store.register(get_types_from_msg(messages.definition(kind, "ros1"), kind))
    assert store.generate_msgdef(kind, ros_version=1)[1] == MD5_SUMS[kind]


@pytest.mark.parametrize("line_end", ["\n", "\r\n"])
def test_the_parts_of_a_definition(line_end: str) -> None:
    text = f"""\
# a comment

std_msgs/Header header  # with a comment
Inner[3] three
Inner[] any
Inner[<=7] at_most
string<=10 name
string<=10[<=5] names
float64 x 1.5
string text "a=b # c"
int32[2] pair [1, 2]
uint8 TYPE=7
string HELLO=there # no comment
int32 WIDE = -5
{SEPARATOR}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{SEPARATOR}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
{SEPARATOR}
MSG: a/Inner
bool yes
""".replace("\n", line_end)
    assert _fields(text) == [
        Field("header", "std_msgs/msg/Header"),
        Field("three", "a/msg/Inner", 3),
        Field("any", "a/msg/Inner", 0),
        Field("at_most", "a/msg/Inner", 0),
        Field("name", "string"),
        Field("names", "string", 0),
        Field("x", "float64"),
        Field("text", "string"),
        Field("pair", "int32", 2),
    ]


def test_a_bare_header_is_that_of_std_msgs() -> None:
    text = f"Header header\n{SEPARATOR}\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n"
    found = parse_definitions(text, "nav_msgs/msg/Odometry")
    assert found["nav_msgs/msg/Odometry"] == (Field("header", "std_msgs/msg/Header"),)
    assert [field.name for field in found["time"]] == ["sec", "nanosec"]


@pytest.mark.parametrize(
    ("name", "package", "full"),
    [("a/B", "", "a/msg/B"), ("a/msg/B", "", "a/msg/B"), ("B", "a", "a/msg/B")],
)
def test_names_are_spelled_as_in_ros_2(name: str, package: str, full: str) -> None:
    assert full_name(name, package) == full


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("uint8", "is no field"),
        ("uint8 1x", "is no field"),
        ("{}", "is no field"),
        ("wstring name", "not defined"),
        ("b/Other x", "b/msg/Other, which is not defined"),
        ("A again", "contains itself"),
        (f"B b\n{SEPARATOR}\nMSG: a/B\nA[] back", "contains itself"),
        (f"uint8[{1 << 30}] huge", "array of"),
        (f"B[1048576] b\n{SEPARATOR}\nMSG: a/B\nstring[1048576] b", "more than"),
        (f"B[] b\n{SEPARATOR}\nMSG: a/B\n", "without fields"),
    ],
)
def test_definitions_that_cannot_be_followed_are_refused(text: str, why: str) -> None:
    with pytest.raises(InputError, match=why):
        parse_definitions(text, "a/msg/A")


def test_definitions_that_double_at_every_level_are_refused_at_once() -> None:
    levels = [f"T{n + 1} one\nT{n + 1} two\n{SEPARATOR}\nMSG: a/T{n + 1}\n" for n in range(29)]
    with pytest.raises(InputError, match="more than"):
        parse_definitions("".join([*levels, "uint8 x"]), "a/msg/T0")


def test_definitions_that_are_nested_very_deep_are_refused() -> None:
    levels = [f"T{n + 1} one\n{SEPARATOR}\nMSG: a/T{n + 1}\n" for n in range(5000)]
    with pytest.raises(InputError, match="deep"):
        parse_definitions("".join([*levels, "uint8 x"]), "a/msg/T0")


def test_a_message_without_fields_has_a_byte_in_ros_2() -> None:
    assert parse_definitions("", "std_msgs/msg/Empty")["std_msgs/msg/Empty"] == ()
    (filler,) = parse_definitions("", "std_msgs/msg/Empty", ros2=True)["std_msgs/msg/Empty"]
    assert filler.type == "uint8"
