# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Messages that are found many at a time are those that are found one by one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from tumtools.convert import convert
from tumtools.errors import InputError
from tumtools.formats.mcap import recording as mcap_recording
from tumtools.formats.mcap.recording import McapRecording
from tumtools.formats.options import WriteOptions
from tumtools.formats.ros import batches
from tumtools.formats.ros.batches import in_batches, tables
from tumtools.formats.rosbag1 import records
from tumtools.formats.rosbag1.recording import BagRecording
from tumtools.formats.rosbag2.recording import Rosbag2Recording
from tumtools.sources import open_source

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from tumtools.formats.ros.batches import Batch
    from tumtools.formats.ros.recording import RawMessage, Recording

FULL = Path(__file__).parents[3] / "fixtures" / "full"
WRITTEN: dict[str, tuple[str, WriteOptions, Callable[[Path], Recording]]] = {
    "mcap": ("mcap", WriteOptions(), McapRecording),
    "mcap ros1": ("mcap", WriteOptions(profile="ros1", compression="none"), McapRecording),
    "rosbag1": ("rosbag1", WriteOptions(), BagRecording),
    "rosbag1 lz4": ("rosbag1", WriteOptions(compression="lz4"), BagRecording),
    "rosbag2 sqlite3": ("rosbag2", WriteOptions(storage="sqlite3"), Rosbag2Recording),
    "rosbag2 mcap": ("rosbag2", WriteOptions(storage="mcap"), Rosbag2Recording),
}
Row = tuple[str, int, bytes]


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


@pytest.mark.parametrize("size", [3, 2048])
@pytest.mark.parametrize("case", WRITTEN)
def test_batches_hold_the_messages_of_each_channel_in_order(
    case: str, size: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    to, options, recording_of = WRITTEN[case]
    with open_source(FULL) as sequence:
        convert(sequence, tmp_path / "out", to, options)
    for module in (batches, mcap_recording):
        monkeypatch.setattr(module, "BATCH", size)
    recording = recording_of(tmp_path / "out")
    wanted = [channel for channel in recording.channels if "camera" not in channel.topic]
    one_by_one = _by_topic(_rows(recording.messages(wanted)))
    assert len(one_by_one) == (2 if to == "rosbag1" else 3)
    assert _by_topic(_rows_of(recording.batches(wanted))) == one_by_one
    assert _by_topic(_rows_of(in_batches(recording.messages(wanted)))) == one_by_one
    assert list(recording.batches([])) == []
    recording.close()


@pytest.mark.parametrize(
    "order", [(b"conn", b"op", b"time"), (b"op", b"conn", b"time"), (b"time", b"op", b"conn")]
)
def test_bags_whose_headers_have_another_order_are_read_one_by_one(
    order: tuple[bytes, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def encode(fields: dict[bytes, bytes]) -> bytes:
        known = {name: fields[name] for name in order if name in fields}
        return inner({**known, **fields} if len(known) == len(order) else fields)

    inner = records.encode_fields
    with open_source(FULL) as sequence:
        convert(sequence, tmp_path / "ours.bag", "rosbag1")
        monkeypatch.setattr(records, "encode_fields", encode)
        convert(sequence, tmp_path / "theirs.bag", "rosbag1")
    ours, theirs = BagRecording(tmp_path / "ours.bag"), BagRecording(tmp_path / "theirs.bag")
    assert (tmp_path / "ours.bag").read_bytes() != (tmp_path / "theirs.bag").read_bytes()
    found = (_by_topic(_rows_of(bag.batches(bag.channels))) for bag in (ours, theirs))
    assert next(found) == next(found)


@pytest.mark.parametrize(
    ("find", "put", "said"),
    [
        (b"time=", b"tame=", "without the field 'time'|the index says"),
        (b"conn=", b"conn=\x7f", "the index says that a message of connection .* is here"),
    ],
)
def test_messages_of_a_bag_that_are_not_what_its_index_says_are_named(
    find: bytes, put: bytes, said: str, tmp_path: Path
) -> None:
    with open_source(FULL) as sequence:
        convert(sequence, tmp_path / "out.bag", "rosbag1")
    recording = BagRecording(tmp_path / "out.bag")
    channel = next(one for one in recording.channels if one.topic == "/imu")
    (first, *_) = recording.batches([channel])
    at = first.data.tobytes().rindex(find, 0, int(first.starts[-1]))
    whole = (tmp_path / "out.bag").read_bytes()
    at += whole.index(first.data.tobytes())
    (tmp_path / "out.bag").write_bytes(whole[:at] + put + whole[at + len(put) :])
    damaged = BagRecording(tmp_path / "out.bag")
    with pytest.raises(InputError, match=said):
        list(damaged.batches([channel]))


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
