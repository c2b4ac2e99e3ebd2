# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The codec against those of other people, in both encodings, and against itself with random messages."""

from __future__ import annotations

import dataclasses
import struct
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from mcap_ros2._dynamic import generate_dynamic
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from tumtools.errors import InputError, UnsupportedInputError
from tumtools.formats.ros import messages
from tumtools.formats.ros.batches import tables
from tumtools.formats.ros.codec import Columns, Message, MessageType

if TYPE_CHECKING:
    from tumtools.formats.ros.recording import MessageEncoding

ENCODINGS: tuple[MessageEncoding, ...] = ("cdr", "ros1")
OURS = list(messages.TYPE_HASHES)
ODD = """\
bool yes
int8 a
uint16 b
string text
float64 wide
int64 long
string[] texts
Part[] parts
Part[2] two
float64[] numbers
int16[3] three
bool[] flags
uint8[] blob
byte last
================================================================================
MSG: odd/Part
int8 small
float32 x
string name
uint64[] ids
"""
"""Every kind of alignment."""

FEW = settings(max_examples=20, deadline=None, phases=(Phase.explicit, Phase.generate))
"""Shrinking a message of forty fields takes minutes and helps nobody."""
NUMBERS = {
    "bool": st.booleans(),
    "byte": st.integers(0, 127),  # signed or not: the releases differ
    "int8": st.integers(-128, 127),
    "uint8": st.integers(0, 255),
    "int16": st.integers(-(2**15), 2**15 - 1),
    "uint16": st.integers(0, 2**16 - 1),
    "int32": st.integers(-(2**31), 2**31 - 1),
    "uint32": st.integers(0, 2**32 - 1),
    "int64": st.integers(-(2**63), 2**63 - 1),
    "uint64": st.integers(0, 2**64 - 1),
    "float32": st.floats(width=32, allow_nan=False),
    "float64": st.floats(allow_nan=False),
}
BIG_ENDIAN = dict(zip(NUMBERS, [f">{code}" for code in "?BbBhHiIqQfd"], strict=True))
TEXTS = st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=9)


def _type(name: str, encoding: MessageEncoding) -> MessageType:
    if name == "odd/msg/Odd":
        return MessageType(ODD, name, encoding)
    return messages.message_type(name, encoding)


def _values(kind: MessageType, name: str) -> st.SearchStrategy[Message]:
    """Return random messages of a type, as plain Python values."""
    fields = {}
    for field in kind.definitions[name]:
        one: st.SearchStrategy[Any]
        if field.type in NUMBERS:
            one = NUMBERS[field.type]
        else:
            one = TEXTS if field.type == "string" else _values(kind, field.type)
        if field.count is not None:
            one = st.lists(one, min_size=field.count, max_size=field.count or 3)
        if name == "time" and field.name == "sec":
            one = st.integers(0, 2**31 - 1)  # rosbags takes it for signed
        fields[field.name] = one
    return st.fixed_dictionaries(fields)


def _plain(value: object) -> object:
    """Return a message with arrays as lists."""
    if isinstance(value, dict):
        return {name: _plain(inner) for name, inner in value.items()}
    if isinstance(value, list):
        return [_plain(inner) for inner in value]
    return value.tolist() if isinstance(value, np.ndarray) else value


def _big_endian(kind: MessageType, message: Message) -> bytes:
    """Serialise as a big-endian machine does: a second, naive implementation."""
    data = bytearray(b"\0\0\0\0")

    def align(size: int) -> None:
        data.extend(bytes(-(len(data) - 4) % size))

    def one(type_name: str, value: Any) -> None:
        if type_name in NUMBERS:
            code = BIG_ENDIAN[type_name]
            align(struct.calcsize(code))
            data.extend(struct.pack(code, value))
        elif type_name == "string":
            align(4)
            text = value.encode() + b"\0"
            data.extend(struct.pack(">I", len(text)) + text)
        else:
            all_of(type_name, value)

    def all_of(type_name: str, values: dict[str, Any]) -> None:
        for field in kind.definitions[type_name]:
            value = values[field.name]
            if field.count is None:
                one(field.type, value)
                continue
            if not field.count:
                align(4)
                data.extend(struct.pack(">I", len(value)))
            for element in value:
                one(field.type, element)

    all_of(kind.name, message)
    return bytes(data)


def _rosbags_message(store: Any, name: str, values: dict[str, Any]) -> Any:
    kind = store.types[name]
    arguments = {}
    for field in dataclasses.fields(kind):
        if field.name == "__msgtype__":
            continue
        value = values[field.name]
        inner = store.fielddefs[name][1]
        description = dict(inner)[field.name]
        arguments[field.name] = _rosbags_value(store, description, value)
    return kind(**arguments)


def _rosbags_value(store: Any, description: Any, value: Any) -> Any:
    node, detail = description
    if node == 1:  # a primitive
        return value
    if node == 2:  # a message
        return _rosbags_message(store, detail, value)
    element = detail[0]
    if element[0] == 1 and element[1][0] != "string":
        return np.array(value, {"byte": "u1"}.get(element[1][0], element[1][0]))
    return [_rosbags_value(store, element, one) for one in value]


@cache
def _store(name: str, encoding: MessageEncoding) -> Any:
    if name == "odd/msg/Odd":
        store = get_typestore(Stores.EMPTY)
        store.register(get_types_from_msg(ODD, name))
        return store
    return get_typestore(Stores.ROS1_NOETIC if encoding == "ros1" else Stores.ROS2_HUMBLE)


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("name", [*OURS, "odd/msg/Odd"])
@FEW
@given(data=st.data())
def test_what_we_write_is_what_rosbags_writes(
    name: str, encoding: MessageEncoding, data: st.DataObject
) -> None:
    kind, store = _type(name, encoding), _store(name, encoding)
    values = data.draw(_values(kind, name))
    ours = kind.encode(values)
    if name == messages.TF_MESSAGE and encoding == "ros1":
        pytest.skip("not in that type store; its parts are tested by the others")
    other = _rosbags_message(store, name, values)
    if encoding == "ros1":
        theirs = bytes(store.serialize_ros1(other, name))
    else:
        theirs = bytes(store.serialize_cdr(other, name))
    assert ours == theirs
    assert _plain(kind.decode(memoryview(theirs))) == values


@pytest.mark.parametrize("name", [*OURS, "odd/msg/Odd"])
@FEW
@given(data=st.data())
def test_mcap_ros2_support_reads_what_we_write(name: str, data: st.DataObject) -> None:
    kind = _type(name, "cdr")
    values = data.draw(_values(kind, name))
    text = ODD if name == "odd/msg/Odd" else messages.definition(name, "cdr")
    decoder = generate_dynamic(name, text)[name]
    assert _attributes(decoder(kind.encode(values)), values) == values


def _attributes(found: Any, like: Any) -> Any:
    """Return the attributes of another library's message in the shape of ours."""
    if isinstance(like, dict):
        return {name: _attributes(getattr(found, name), like[name]) for name in like}
    if isinstance(like, list):
        assert len(found) == len(like)
        return [_attributes(one, other) for one, other in zip(found, like, strict=True)]
    return found


@pytest.mark.parametrize("name", [*OURS, "odd/msg/Odd"])
@FEW
@given(data=st.data())
def test_big_endian_messages_are_read(name: str, data: st.DataObject) -> None:
    kind = _type(name, "cdr")
    values = data.draw(_values(kind, name))
    assert _plain(kind.decode(memoryview(_big_endian(kind, values)))) == values


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("name", [messages.IMU, messages.POSE_STAMPED, messages.TF_MESSAGE, "odd/msg/Odd"])
@FEW
@given(data=st.data())
def test_columns_say_what_the_messages_say(name: str, encoding: MessageEncoding, data: st.DataObject) -> None:
    kind = _type(name, encoding)
    values = data.draw(st.lists(_values(kind, name), max_size=6))
    encoded = [memoryview(kind.encode(one)) for one in values]
    if encoding == "cdr" and data.draw(st.booleans()):
        encoded = [memoryview(_big_endian(kind, one)) for one in values]
    seen = []
    for part in _columns(kind, encoded):
        for place, row in enumerate(part.rows.tolist()):
            seen.append(row)
            for path, column in part.numbers.items():
                assert column[place].tolist() == _at(values[row], path)
            for path, text in part.texts.items():
                assert text == _at(values[row], path)
    assert sorted(seen) == list(range(len(values)))


def _columns(kind: MessageType, encoded: list[memoryview]) -> list[Columns]:
    lengths = np.array([len(one) for one in encoded], np.int64)
    parts = tables(np.frombuffer(b"".join(encoded), np.uint8), np.cumsum(lengths) - lengths, lengths)
    return [columns for rows, table in parts for columns in kind.columns_of(rows, table)]


def _at(value: Any, path: str) -> Any:
    for name in path.split("."):
        value = value[int(name)] if isinstance(value, list) else value[name]
    return [int(one) if isinstance(one, bool) else one for one in value] if isinstance(value, list) else value


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_columns_are_written_as_the_messages_one_by_one(encoding: MessageEncoding) -> None:
    kind = messages.message_type(messages.POSE_STAMPED, encoding)
    zero = {"x": 0.0, "y": 0.0, "z": 0.0}
    header = {"seq": 0, "stamp": {"sec": 0, "nanosec": 0}, "frame_id": "world"}
    template: Message = {"header": header, "pose": {"position": zero, "orientation": zero | {"w": 1.0}}}
    xs, seconds = np.linspace(-1, 1, 5), np.arange(5)
    table = kind.encode_columns(template, {"pose.position.x": xs, "header.stamp.sec": seconds})
    for row, x, second in zip(table, xs.tolist(), seconds.tolist(), strict=True):
        message: Message = {
            "header": header | {"stamp": {"sec": second, "nanosec": 0}},
            "pose": {"position": zero | {"x": x}, "orientation": zero | {"w": 1.0}},
        }
        assert row.tobytes() == kind.encode(message)


def test_columns_of_very_many_layouts_do_not_take_quadratic_time() -> None:
    kind = MessageType("string text\nuint8 number\n", "a/msg/A", "ros1")
    encoded = [memoryview(kind.encode({"text": f"{n:06d}", "number": n % 256})) for n in range(20_000)]
    numbers = {int(part.rows[0]): int(part.numbers["number"][0]) for part in _columns(kind, encoded)}
    assert numbers == {n: n % 256 for n in range(20_000)}


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_a_message_that_is_cut_anywhere_is_refused(encoding: MessageEncoding) -> None:
    kind = _type("odd/msg/Odd", encoding)
    part = {"small": 1, "x": 2.0, "name": "abc", "ids": [1, 2]}
    message: Message = {
        "yes": True, "a": 1, "b": 2, "text": "hello", "wide": 1.0, "long": 2, "texts": ["a", "b"],
        "parts": [part], "two": [part, part], "numbers": [1.0], "three": [1, 2, 3], "flags": [True],
        "blob": [1, 2], "last": 3,
    }  # fmt: skip
    data = kind.encode(message)
    assert _plain(kind.decode(memoryview(data))) == message
    for end in range(len(data)):
        with pytest.raises(InputError, match=r"too early|do not fit") as caught:
            kind.decode(memoryview(data[:end]))
        assert caught.value.location is not None
        assert "offset" in caught.value.location
        with pytest.raises(InputError):
            _columns(kind, [memoryview(data[:end])])


@pytest.mark.parametrize(
    "definition", ["uint8[] data", "string data", "string[] data", "float64[] data", "B[] d"]
)
@pytest.mark.parametrize("encoding", ENCODINGS)
def test_lengths_that_lie_take_no_memory(definition: str, encoding: MessageEncoding) -> None:
    kind = MessageType(f"{definition}\n{'=' * 80}\nMSG: a/B\nuint8 x", "a/msg/A", encoding)
    head = b"\0\1\0\0" if encoding == "cdr" else b""
    for length in (9, 2**31 - 1, 2**31, 2**32 - 1):
        with pytest.raises(InputError, match=r"too early|do not fit"):
            kind.decode(memoryview(head + struct.pack("<I", length) + bytes(8)))


@pytest.mark.parametrize("head", ["0002", "0003", "0006", "0007", "000a", "0100", "ffff"])
def test_other_representations_are_named(head: str) -> None:
    kind = messages.message_type(messages.STRING, "cdr")
    with pytest.raises(UnsupportedInputError, match=head):
        kind.decode(memoryview(bytes.fromhex(head) + bytes(20)))


def test_a_text_of_foreign_writers_may_lack_its_zero() -> None:
    kind = messages.message_type(messages.STRING, "cdr")
    head = b"\0\1\0\0"
    assert kind.decode(memoryview(head + struct.pack("<I", 2) + b"ab")) == {"data": "ab"}
    assert kind.decode(memoryview(head + struct.pack("<I", 0))) == {"data": ""}
    assert kind.decode(memoryview(head + struct.pack("<I", 3) + b"a\xff\0")) == {"data": "a\ufffd"}


def test_arrays_are_views_into_the_message() -> None:
    kind = messages.message_type(messages.COMPRESSED_IMAGE, "cdr")
    header = {"stamp": {"sec": 1, "nanosec": 2}, "frame_id": "f"}
    data = memoryview(kind.encode({"header": header, "format": "png", "data": list(range(100))}))
    pixels = kind.decode(data)["data"]
    assert isinstance(pixels, np.ndarray)
    assert np.shares_memory(pixels, np.frombuffer(data, np.uint8))
