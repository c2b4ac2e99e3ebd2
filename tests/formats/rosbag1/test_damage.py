# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
from __future__ import annotations

import random
import struct
from typing import TYPE_CHECKING

import pytest

from tests.formats.rosbag1.samples import bag_bytes, plain, read, some_messages
from tumtools.errors import InputError, MissingInputError, UnsupportedInputError
from tumtools.formats.rosbag1.compression import COMPRESSIONS
from tumtools.formats.rosbag1.recording import BagRecording

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
