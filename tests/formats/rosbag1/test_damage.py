# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
from __future__ import annotations

import random
import struct
from collections import Counter
from contextlib import closing
from typing import TYPE_CHECKING

import pytest

from tests.formats.rosbag1.samples import bag_bytes, plain, read, some_messages
from tumtools.errors import InputError, MissingInputError, UnsupportedInputError
from tumtools.formats.rosbag1 import records
from tumtools.formats.rosbag1.compression import COMPRESSIONS
from tumtools.formats.rosbag1.index import read_index
from tumtools.formats.rosbag1.recording import BagRecording
from tumtools.formats.rosbag1.records import Block, read_record

if TYPE_CHECKING:
    from pathlib import Path

INDEX_POSITION = slice(13 + 4 + 4 + 16 + 4 + 15 + 4 + 10, 13 + 4 + 4 + 16 + 4 + 15 + 4 + 18)
"""Where the bag's header says where the index is."""

SMALL = some_messages(24, size=400)


def without_index(bag: bytes) -> bytes:
    """Return the bag as its recorder leaves it when it is killed after a chunk."""
    (index_at,) = struct.unpack("<Q", bag[INDEX_POSITION])
    return bag[: INDEX_POSITION.start] + bytes(8) + bag[INDEX_POSITION.stop : index_at]


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_a_bag_without_index_is_scanned_and_says_so(tmp_path: Path, compression: str) -> None:
    messages = some_messages(100)
    path = tmp_path / "a.bag"
    path.write_bytes(without_index(bag_bytes(messages, compression)))

    assert read(path) == plain(messages)
    (warning,) = BagRecording(path).warnings
    assert "no index" in warning


def test_a_chunk_that_was_still_open_is_read(tmp_path: Path) -> None:
    """ROS fills in the sizes of a chunk when it closes it; until then they are 0."""
    bag = bytearray(without_index(bag_bytes(SMALL)))
    chunk = bag.index(b"compression=none") - 4
    bag[bag.index(b"size=", chunk) + 5 :][:4] = bytes(4)
    size_at = bag.index(b"size=", chunk) + 5
    header_end = chunk + struct.unpack_from("<I", bag, chunk - 4)[0]
    bag[size_at : size_at + 4] = bytes(4)
    bag[header_end : header_end + 4] = bytes(4)
    path = tmp_path / "a.bag"
    path.write_bytes(bag)

    assert read(path) == plain(SMALL)


def test_an_empty_file_and_a_file_of_something_else_are_told_apart(tmp_path: Path) -> None:
    path = tmp_path / "a.bag"
    path.write_bytes(b"")
    with pytest.raises(InputError, match=r"a\.bag: the file is empty \(0 bytes\)"):
        BagRecording(path)
    path.write_bytes(b"\x89MCAP0\r\n" + bytes(100))
    with pytest.raises(InputError, match="not a ROS bag"):
        BagRecording(path)
    path.write_bytes(b"#ROSBAG V1.2\n" + bytes(100))
    with pytest.raises(UnsupportedInputError, match=r"version V1\.2, only 2\.0"):
        BagRecording(path)
    with pytest.raises(MissingInputError):
        BagRecording(tmp_path / "b.bag")
    with pytest.raises(InputError):
        BagRecording(tmp_path)


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_what_comes_before_a_cut_is_salvaged(tmp_path: Path, compression: str) -> None:
    messages = some_messages(400)
    bag = bag_bytes(messages, compression)
    path = tmp_path / "a.bag"
    path.write_bytes(bag[: len(bag) // 2])

    with pytest.raises(InputError, match="the file was cut or not finished") as error:
        BagRecording(path)
    assert error.value.exit_code == 4
    assert "--salvage" in str(error.value)
    found = read(path, salvage=True)
    assert found == plain(messages)[: len(found)]
    assert len(found) > 50
    assert any("offset" in warning for warning in BagRecording(path, salvage=True).warnings)


@pytest.mark.parametrize("compression", ["bz2", "lz4"])
def test_a_damaged_chunk_is_an_error_and_the_others_are_salvaged(tmp_path: Path, compression: str) -> None:
    messages = some_messages(200)
    bag = bytearray(bag_bytes(messages, compression))
    bag[bag.index(b"compression=" + compression.encode()) + 300] ^= 1
    path = tmp_path / "a.bag"
    path.write_bytes(bag)

    with pytest.raises(InputError, match=f"offset 4117: a chunk whose {compression} data"):
        read(path)
    found = read(path, salvage=True)
    assert 0 < len(found) < len(messages)
    assert set(found) < set(plain(messages))


def told(path: Path) -> dict[tuple[str, str], int]:
    """Return what a salvage tells that it leaves out."""
    with closing(BagRecording(path, salvage=True)) as bag:
        assert all(loss.why for loss in bag.left_out)
        return {(loss.stream, loss.what): loss.count for loss in bag.left_out}


def index_at(bag: bytes) -> int:
    return int.from_bytes(bag[INDEX_POSITION], "little")


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_a_salvage_tells_what_it_leaves_out_wherever_a_bag_was_cut(tmp_path: Path, compression: str) -> None:
    messages = some_messages(60)
    bag = bag_bytes(messages, compression)
    path = tmp_path / "a.bag"
    places = random.Random(3).sample(range(5000, len(bag)), 40)
    for place in (*places, index_at(bag), len(bag) - 1, len(bag)):
        path.write_bytes(bag[:place])
        is_whole = read(path, salvage=True) == plain(messages)
        assert bool(told(path)) == (not is_whole or place < index_at(bag)), place
        if place < index_at(bag):
            assert told(path)["recording", "bytes missing at its end"] == index_at(bag) - place


def test_a_cut_between_two_records_is_told(tmp_path: Path) -> None:
    """Nothing is damaged there: only the header knows that the file goes on."""
    bag = bag_bytes(some_messages(300))
    path = tmp_path / "a.bag"
    with closing(BagRecording(_written(path, bag))) as whole:
        second = whole._index.chunks[1].offset
    missing = {("recording", "bytes missing at its end"): index_at(bag) - second}
    assert told(_written(path, bag[:second])) == missing


def _written(path: Path, data: bytes) -> Path:
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("compression", ["bz2", "lz4"])
def test_the_index_tells_how_many_messages_of_each_topic_were_in_a_damaged_chunk(
    tmp_path: Path, compression: str
) -> None:
    messages = some_messages(200)
    bag = bytearray(bag_bytes(messages, compression))
    bag[bag.index(b"compression=" + compression.encode()) + 300] ^= 1
    path = _written(tmp_path / "a.bag", bytes(bag))
    lost = Counter(topic for topic, _, _ in plain(messages))
    lost.subtract(topic for topic, _, _ in read(path, salvage=True))
    assert sum(lost.values()) > 10
    assert told(path) == {(topic, "messages left out as damaged"): count for topic, count in lost.items()}
    # Without it the bytes of the chunk are told, and messages whose connection was described there.
    unindexed = without_index(bytes(bag))
    told_of_part = told(_written(path, unindexed))
    assert told_of_part["recording", "bytes left out as damaged"] > 1000
    assert told_of_part["recording", "messages left out as damaged"] == len(messages) - sum(lost.values())
    headless = unindexed.replace(b"index_pos", b"index_poz")
    assert told(_written(path, headless)) == told_of_part | {("recording", "header left out as damaged"): 1}


def test_messages_of_a_connection_that_is_lost_are_told(tmp_path: Path) -> None:
    bag = bag_bytes(SMALL, "none")
    damaged = without_index(bag).replace(b"\4\0\0\0op=\7", b"\4\0\0\0op=\4", 1)
    found = told(_written(tmp_path / "a.bag", damaged))
    assert found["recording", "messages left out as damaged"] == 8


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_a_salvage_of_a_sound_bag_leaves_nothing_out(tmp_path: Path, compression: str) -> None:
    path = tmp_path / "a.bag"
    for bag in (bag_bytes(SMALL, compression), without_index(bag_bytes(SMALL, compression))):
        assert told(_written(path, bag)) == {}


def try_to_read(path: Path, *, salvage: bool) -> str:
    try:
        read(path, salvage=salvage)
    except InputError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_no_cut_gives_anything_but_an_error_of_ours(tmp_path: Path, compression: str) -> None:
    bag = bag_bytes(SMALL, compression)
    path = tmp_path / "a.bag"
    places = random.Random(1).sample(range(len(bag)), 334)
    for place in places:
        path.write_bytes(bag[:place])
        assert try_to_read(path, salvage=False), f"cut at {place}"
        message = try_to_read(path, salvage=True)
        assert not message or place < 4117, f"cut at {place}: {message}"


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_no_flipped_bit_gives_anything_but_an_error_of_ours(tmp_path: Path, compression: str) -> None:
    bag = bag_bytes(SMALL, compression)
    path = tmp_path / "a.bag"
    generator = random.Random(2)
    # The padding of the bag's header has no meaning; flips there would test nothing.
    places = [place for place in range(len(bag)) if not 90 < place < 4110]
    for place in generator.choices(places, k=334):
        damaged = bytearray(bag)
        damaged[place] ^= 1 << generator.randrange(8)
        path.write_bytes(damaged)
        for salvage in (False, True):
            try_to_read(path, salvage=salvage)


@pytest.mark.parametrize("compression", ["bz2", "lz4"])
@pytest.mark.parametrize("salvage", [False, True])
def test_a_chunk_that_claims_to_be_huge_takes_no_memory(
    tmp_path: Path, compression: str, salvage: bool
) -> None:
    bag = bytearray(bag_bytes(SMALL, compression))
    size_at = bag.index(b"size=", bag.index(b"compression=")) + 5
    bag[size_at : size_at + 4] = struct.pack("<I", 2**32 - 1)
    path = tmp_path / "a.bag"
    path.write_bytes(bag)
    if salvage:
        assert read(path, salvage=True) == []
    else:
        with pytest.raises(UnsupportedInputError, match="a compressed chunk of 4294967295 bytes"):
            read(path)


def _with_entry(bag: bytes, change: bytes, at: int) -> tuple[bytes, int]:
    """Change the first entry of the first index record behind the last chunk; return where that record is."""
    file = Block("a.bag", memoryview(bag))
    record = read_record(file, read_index(file).chunks[-1].end)
    place = record.data_start + at
    return bag[:place] + change + bag[place + len(change) :], record.offset


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_an_index_that_points_behind_its_chunk_is_named(tmp_path: Path, compression: str) -> None:
    bag, record = _with_entry(bag_bytes(SMALL, compression), b"\xff\xff\xff\x7f", 8)
    path = tmp_path / "a.bag"
    path.write_bytes(bag)
    with pytest.raises(InputError, match="an index points behind the end of its chunk") as error:
        BagRecording(path)
    assert error.value.location == f"offset {record}"


def test_an_index_that_names_a_message_twice_is_refused(tmp_path: Path) -> None:
    bag = bag_bytes(SMALL)
    file = Block("a.bag", memoryview(bag))
    entries = bytes(read_record(file, read_index(file).chunks[-1].end).data)
    assert len(entries) > 12
    path = tmp_path / "a.bag"
    path.write_bytes(_with_entry(bag, entries[:12], 12)[0])
    with pytest.raises(InputError, match=r"the index names the message at .* twice"):
        BagRecording(path)
    assert len(read(path, salvage=True)) == len(SMALL)


@pytest.mark.parametrize("salvage", [False, True])
def test_an_index_with_a_time_that_is_none_is_damage(tmp_path: Path, salvage: bool) -> None:
    bag, _ = _with_entry(bag_bytes(SMALL), b"\xff" * 8, 0)
    path = tmp_path / "a.bag"
    path.write_bytes(bag)
    if salvage:
        assert len(read(path, salvage=True)) == len(SMALL)
    else:
        with pytest.raises(InputError, match="the index says that a message of connection"):
            read(path)


def test_headers_of_absurd_size_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.bag"
    path.write_bytes(bag_bytes(SMALL))
    monkeypatch.setattr(records, "_MOST_FIELDS", 10)
    with pytest.raises(UnsupportedInputError, match="bytes of header fields, more than 10"):
        BagRecording(path)
