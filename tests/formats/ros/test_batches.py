# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Messages that are found many at a time are those that are found one by one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from tests.formats.mcap.foreign import Foreign
from tumtools.convert import convert
from tumtools.errors import InputError
from tumtools.formats.mcap import recording as mcap_recording
from tumtools.formats.mcap.recording import McapRecording
from tumtools.formats.options import WriteOptions
from tumtools.formats.ros import batches
from tumtools.formats.ros.batches import BATCH_BYTES, in_batches, tables
from tumtools.formats.ros.recording import Channel, RawMessage
from tumtools.formats.rosbag1 import recording as rosbag1_recording
from tumtools.formats.rosbag1 import records
from tumtools.formats.rosbag1.recording import BagRecording
from tumtools.formats.rosbag2.recording import Rosbag2Recording
from tumtools.sources import open_source

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from tumtools.formats.ros.batches import Batch
    from tumtools.formats.ros.recording import Recording

FULL = Path(__file__).parents[3] / "fixtures" / "full"
START = 1305031102175304000
IN_ROS1 = {"/imu", "/tf"}
IN_ROS2 = {"/imu", "/tf", "/groundtruth/pose"}
WRITTEN: dict[str, tuple[str, WriteOptions, Callable[[Path], Recording]]] = {
    "mcap": ("mcap", WriteOptions(), McapRecording),
    "mcap ros1": ("mcap", WriteOptions(profile="ros1", compression="none"), McapRecording),
    "rosbag1": ("rosbag1", WriteOptions(), BagRecording),
    "rosbag1 lz4": ("rosbag1", WriteOptions(compression="lz4"), BagRecording),
    "rosbag2 sqlite3": ("rosbag2", WriteOptions(storage="sqlite3"), Rosbag2Recording),
    "rosbag2 mcap": ("rosbag2", WriteOptions(storage="mcap"), Rosbag2Recording),
}
Row = tuple[str, int, bytes]


def _written(path: Path, case: str) -> Recording:
    to, options, recording_of = WRITTEN[case]
    with open_source(FULL) as sequence:
        convert(sequence, path, to, options)
    return recording_of(path)


def _rows(messages: Iterable[RawMessage]) -> list[Row]:
    return [(message.channel.topic, message.log_time, bytes(message.data)) for message in messages]


def _rows_of(found: Iterable[Batch]) -> list[Row]:
    return [
        (batch.channel.topic, int(time), batch.data[start : start + length].tobytes())
        for batch in found
        for time, start, length in zip(batch.log_times, batch.starts, batch.lengths, strict=True)
    ]


def _by_topic(rows: list[Row]) -> dict[str, list[Row]]:
    return {topic: [row for row in rows if row[0] == topic] for topic in sorted({row[0] for row in rows})}


def _signals(recording: Recording) -> list[Channel]:
    return [channel for channel in recording.channels if "camera" not in channel.topic]


@pytest.mark.parametrize("size", [3, 2048])
@pytest.mark.parametrize("case", WRITTEN)
def test_batches_hold_the_messages_of_each_channel_in_order(
    case: str, size: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recording = _written(tmp_path / "out", case)
    for module in (batches, mcap_recording, rosbag1_recording):
        monkeypatch.setattr(module, "BATCH", size)
    wanted = _signals(recording)
    one_by_one = _by_topic(_rows(recording.messages(wanted)))
    assert set(one_by_one) == (IN_ROS1 if case.startswith("rosbag1") else IN_ROS2)
    assert _by_topic(_rows_of(recording.batches(wanted))) == one_by_one
    assert _by_topic(_rows_of(in_batches(recording.messages(wanted)))) == one_by_one
    assert all(len(batch.log_times) <= size for batch in recording.batches(wanted))
    assert list(recording.batches([])) == []
    recording.close()


def test_messages_in_no_chunk_are_found_too(tmp_path: Path) -> None:
    with Foreign(tmp_path / "x.mcap", writer={"use_chunking": False}) as file:
        for number in range(5):
            file.imu(START + number, float(number))
    recording = McapRecording(tmp_path / "x.mcap")
    assert _rows_of(recording.batches(recording.channels)) == _rows(recording.messages(recording.channels))


ORDERS = [(b"conn", b"op", b"time"), (b"op", b"conn", b"time"), (b"time", b"op", b"conn")]


def _in_order(path: Path, order: tuple[bytes, ...], monkeypatch: pytest.MonkeyPatch) -> BagRecording:
    """Write a bag whose headers of messages have their fields in an order."""

    def encode(fields: dict[bytes, bytes]) -> bytes:
        return inner({name: fields[name] for name in order} if set(fields) == set(order) else fields)

    inner = records.encode_fields
    with monkeypatch.context() as patch, open_source(FULL) as sequence:
        patch.setattr(records, "encode_fields", encode)
        convert(sequence, path, "rosbag1")
    return BagRecording(path)


@pytest.mark.parametrize("order", ORDERS)
def test_bags_have_the_same_messages_whatever_the_order_of_their_headers(
    order: tuple[bytes, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ours = _written(tmp_path / "ours.bag", "rosbag1")
    theirs = _in_order(tmp_path / "theirs.bag", order, monkeypatch)
    assert (tmp_path / "ours.bag").read_bytes() != (tmp_path / "theirs.bag").read_bytes()
    if order != ORDERS[-1]:  # one that no program is known for
        monkeypatch.setattr(rosbag1_recording, "find_message", None)
    expected = _by_topic(_rows_of(ours.batches(ours.channels)))
    assert _by_topic(_rows_of(theirs.batches(theirs.channels))) == expected


def _last_of(recording: Recording, topic: str) -> tuple[Channel, bytes, int]:
    """Return a channel, the chunk with its last message, and where in the chunk that begins."""
    channel = next(one for one in recording.channels if one.topic == topic)
    *_, last = recording.batches([channel])
    return channel, last.data.tobytes(), int(last.starts[-1])


@pytest.mark.parametrize(
    ("before", "put", "said"),
    [
        (b"time=", b"tame=", "without the field 'time'"),
        (b"conn=", b"conn=\x7f", "the index says that a message of connection .* is here"),
        (b"time=", b"time=\0\0\0\0\xff\xff\xff\xff", "the index says that a message of connection"),
    ],
)
def test_messages_of_a_bag_that_are_not_what_its_index_says_are_named(
    before: bytes, put: bytes, said: str, tmp_path: Path
) -> None:
    path = tmp_path / "out.bag"
    channel, chunk, start = _last_of(_written(path, "rosbag1"), "/imu")
    whole = path.read_bytes()
    at = whole.index(chunk) + chunk.rindex(before, 0, start)
    path.write_bytes(whole[:at] + put + whole[at + len(put) :])
    with pytest.raises(InputError, match=said):
        list(BagRecording(path).batches([channel]))


def test_lengths_of_messages_of_a_bag_that_lie_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "out.bag"
    channel, chunk, start = _last_of(_written(path, "rosbag1"), "/imu")
    whole = path.read_bytes()
    at = whole.index(chunk) + start - 4
    path.write_bytes(whole[:at] + b"\xff\xff\xff\x7f" + whole[at + 4 :])
    with pytest.raises(InputError, match="the data of a record has 2147483647 bytes by its length field"):
        list(BagRecording(path).batches([channel]))


@pytest.mark.parametrize(
    ("column", "change", "said"),
    [
        (0, 1, "the message index is wrong: it says"),
        (2, 1, "where there is none|the message index is wrong"),
        (2, 2**40, "outside of the chunk"),
        (2, -(2**40), "outside of the chunk"),
    ],
)
def test_a_message_index_that_is_wrong_is_named(
    column: int, change: int, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recording = _written(tmp_path / "out.mcap", "mcap")
    assert isinstance(recording, McapRecording)
    channel = next(one for one in recording.channels if one.topic == "/imu")
    changed = recording._index[channel.id].copy()
    changed[-1, column] += change
    monkeypatch.setitem(recording._index, channel.id, changed)
    for read in (recording.batches, recording.messages):
        with pytest.raises(InputError, match=said):
            list(read([channel]))


def test_a_message_index_that_names_a_message_twice_is_refused(tmp_path: Path) -> None:
    recording = _written(tmp_path / "out.mcap", "mcap")
    assert isinstance(recording, McapRecording)
    channel = next(one for one in recording.channels if one.topic == "/imu")
    first = recording._file.chunks[0].index[channel.id] + 15
    data = (tmp_path / "out.mcap").read_bytes()
    (tmp_path / "out.mcap").write_bytes(data[: first + 16] + data[first : first + 16] + data[first + 32 :])
    with pytest.raises(InputError, match=r"the message index names the message at .* twice"):
        McapRecording(tmp_path / "out.mcap")
    salvaged = McapRecording(tmp_path / "out.mcap", salvage=True)
    assert _rows(salvaged.messages([channel])) == _rows(recording.messages([channel]))


def test_a_message_index_that_names_a_message_of_another_channel_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recording = _written(tmp_path / "out.mcap", "mcap")
    assert isinstance(recording, McapRecording)
    wanted = _signals(recording)
    imu, pose = (next(one.id for one in wanted if one.topic == topic) for topic in ("/imu", "/tf"))
    monkeypatch.setitem(recording._index, imu, recording._index[pose])
    for read in (recording.batches, recording.messages):
        with pytest.raises(InputError, match=f"it says channel {imu} and .* which is of channel {pose}"):
            list(read(wanted))


@pytest.mark.parametrize("size", [64, 4096])
def test_messages_in_many_small_chunks_are_found_too(size: int, tmp_path: Path) -> None:
    with Foreign(tmp_path / "x.mcap", writer={"chunk_size": size}) as file:
        for number in range(40):
            file.imu(START + number, float(number))
            file.pose(START + number, float(number))
    recording = McapRecording(tmp_path / "x.mcap")
    expected = _by_topic(_rows(recording.messages(recording.channels)))
    assert _by_topic(_rows_of(recording.batches(recording.channels))) == expected


@pytest.mark.parametrize("case", ["mcap", "rosbag1"])
def test_a_message_that_an_index_names_again_and_again_is_not_copied_as_often(
    case: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recording = _written(tmp_path / "out", case)
    image = next(one for one in recording.channels if "image" in one.topic and "info" not in one.topic)
    if isinstance(recording, McapRecording):
        entries = np.repeat(recording._index[image.id][:1], 100_000, axis=0)
        monkeypatch.setitem(recording._index, image.id, entries)
    elif isinstance(recording, BagRecording):
        entries = recording._index.entries
        own = entries[entries["connection"] == image.id][:1]
        object.__setattr__(recording._index, "entries", np.repeat(own, 100_000))
    for number, batch in zip(range(5), recording.batches([image]), strict=False):
        assert batch.data.size <= BATCH_BYTES + int(batch.lengths.max()), number


def test_copies_of_messages_are_handed_on_before_they_are_many_bytes() -> None:
    channel = Channel(1, "/large", "a/msg/B", "cdr", "")
    large = memoryview(bytes(BATCH_BYTES // 4))
    found = list(in_batches(RawMessage(channel, time, large) for time in range(10)))
    assert [batch.log_times.tolist() for batch in found] == [[0, 1, 2, 3], [4, 5, 6, 7], [8, 9]]


def test_tables_are_made_of_messages_of_one_length() -> None:
    data = np.arange(10, dtype=np.uint8)
    starts, lengths = np.array([0, 4, 2, 9, 10]), np.array([2, 3, 2, 1, 0])
    found = [(rows.tolist(), table.tolist()) for rows, table in tables(data, starts, lengths)]
    assert found == [
        ([4], [[]]),
        ([3], [[9]]),
        ([0, 2], [[0, 1], [2, 3]]),
        ([1], [[4, 5, 6]]),
    ]
