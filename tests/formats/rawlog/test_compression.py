# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Compression is told by the first bytes; damage is named; a large file is inflated piece by piece."""

from __future__ import annotations

import gzip
import io
import os
import random
import tracemalloc
import zlib
from contextlib import closing
from typing import TYPE_CHECKING

import pytest
import zstandard

from tumtools.errors import InputError, MissingInputError
from tumtools.formats.rawlog.compression import CONTAINERS, Content, Pieces, deflate, deflater

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

DATA = bytes(range(256)) * 3000 + b"its end"


def _all(path: Path) -> tuple[str, bytes]:
    with closing(Pieces(path)) as pieces:
        return pieces.container, b"".join(iter(pieces.next, b""))


@pytest.mark.parametrize("container", CONTAINERS)
def test_a_stream_comes_back(container: str, tmp_path: Path) -> None:
    path = tmp_path / "file"
    compressor = deflater(container)  # type: ignore[arg-type]
    parts = [compressor.compress(DATA[:1000]), compressor.compress(DATA[1000:]), compressor.flush()]
    path.write_bytes(b"".join(parts))
    assert _all(path) == (container, DATA)
    content = Content(deflate(DATA, container), path)  # type: ignore[arg-type]  # a parameter is any text
    assert [content.read(8), content.read(len(DATA)), content.read(1)] == [DATA[:8], DATA[8:], b""]


@pytest.mark.parametrize("size", [1, 100, 256 * 1024 - 20])
def test_gzip_may_have_several_members_wherever_they_end(size: int, tmp_path: Path) -> None:
    path = tmp_path / "file"
    noise = zlib.compress(DATA) * 100
    path.write_bytes(gzip.compress(noise[:size], 0) + gzip.compress(DATA) + bytes(600_000))
    assert _all(path) == ("gzip", noise[:size] + DATA)


def _up_to_the_error(path: Path) -> tuple[bytes, str]:
    found = []
    with closing(Pieces(path)) as pieces, pytest.raises(InputError) as caught:
        found += iter(pieces.next, b"")
    return b"".join(found), str(caught.value)


@pytest.mark.parametrize(
    "rest",
    [b"garbage", bytes(600_000) + b"x", b"\0" + gzip.compress(b"more"), b"\x1f"],
    ids=["garbage", "zeros and a byte", "zero and a member", "half a magic"],
)
def test_what_follows_a_gzip_member_and_is_none_is_named(rest: bytes, tmp_path: Path) -> None:
    path = tmp_path / "file"
    first = gzip.compress(DATA)
    path.write_bytes(first + rest)
    found, message = _up_to_the_error(path)
    assert found == DATA
    assert f"offset {len(first)} of the file: what follows a gzip member is neither" in message


def test_a_member_whose_first_bytes_were_hit_is_not_passed_over(tmp_path: Path) -> None:
    path = tmp_path / "file"
    first, second = gzip.compress(DATA), bytearray(gzip.compress(DATA))
    second[1] ^= 1
    path.write_bytes(first + second)
    assert "what follows a gzip member is neither" in _up_to_the_error(path)[1]


def test_zstd_may_have_several_frames(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(zstandard.compress(DATA) + zstandard.compress(b"more"))
    assert _all(path) == ("zstd", DATA + b"more")


def test_gzip_that_is_cut_off_is_given_up_to_the_cut_and_then_named(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(gzip.compress(DATA)[:-12])
    with closing(Pieces(path)) as pieces:
        assert pieces.next()
        with pytest.raises(InputError, match="ends before the end of the gzip member"):
            list(iter(pieces.next, b""))


def test_a_wrong_checksum_is_named(tmp_path: Path) -> None:
    path = tmp_path / "file"
    data = bytearray(gzip.compress(DATA))
    data[-6] ^= 1
    path.write_bytes(data)
    with pytest.raises(InputError, match="damaged gzip data"):
        _all(path)


@pytest.mark.parametrize("name", ["", "a name.rawlog"])
def test_what_comes_before_a_wrong_checksum_is_given(name: str, tmp_path: Path) -> None:
    path = tmp_path / "file"
    packed = io.BytesIO()
    with gzip.GzipFile(name, "wb", fileobj=packed) as file:
        file.write(DATA)
    data = bytearray(packed.getvalue())
    data[-6] ^= 1
    path.write_bytes(gzip.compress(b"before") + data)
    found, message = _up_to_the_error(path)
    assert found == b"before" + DATA
    assert f"before offset {path.stat().st_size} of the file: damaged gzip data" in message


def test_what_comes_before_damaged_data_is_given_but_for_a_little(tmp_path: Path) -> None:
    path = tmp_path / "file"
    noise = random.Random(0).randbytes(1_000_000)
    data = bytearray(gzip.compress(noise + DATA))
    middle = len(data) - len(gzip.compress(DATA)) // 2
    data[middle : middle + 10] = b"\xff" * 10
    path.write_bytes(data)
    found, _ = _up_to_the_error(path)
    assert found[:1_000_000] == noise


def test_a_pipe_is_refused_and_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match="no file but a pipe"):
        Pieces(tmp_path / "pipe")


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(MissingInputError, match=r"no\.rawlog"):
        Pieces(tmp_path / "no.rawlog")


def test_a_small_file_that_inflates_to_a_giant_takes_no_memory(tmp_path: Path) -> None:
    path = tmp_path / "bomb"
    compressor = zlib.compressobj(9, zlib.DEFLATED, 31)
    zeros = bytes(2**20)
    path.write_bytes(b"".join(compressor.compress(zeros) for _ in range(200)) + compressor.flush())
    tracemalloc.start()
    with closing(Pieces(path)) as pieces:
        total = sum(map(len, iter(pieces.next, b"")))
    assert len(Content(path.read_bytes(), path).read(1_000_000)) == 1_000_000
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert total == 200 * 2**20
    assert peak < 20 * 2**20


def test_the_gzip_of_a_rawlog_is_that_of_mrpt() -> None:
    compressor = deflater("gzip")
    # 1F 8B, deflate, no flags, no time, "fastest", Unix.
    assert compressor.compress(b"") + compressor.flush() == bytes.fromhex(
        "1f8b080000000000040303000000000000000000"
    )


@pytest.mark.parametrize("external", [False, True])
def test_a_flipped_bit_in_what_zstd_has_packed_is_noticed(external: bool, tmp_path: Path) -> None:
    noise = random.Random(0).randbytes(40_000)
    compressor = deflater("zstd")
    packed = deflate(noise, "zstd") if external else compressor.compress(noise) + compressor.flush()
    path = tmp_path / "file"
    for position in range(20, len(packed), 500):
        data = bytearray(packed)
        data[position] ^= 4
        path.write_bytes(data)
        with pytest.raises(InputError, match=r"damaged (zstd|compression)"):
            Content(bytes(data), path).read(50_000) if external else _all(path)


@pytest.mark.parametrize("behind", [b"garbage", b"garbage" * 100_000])
def test_what_zstd_gives_before_damage_is_given(behind: bytes, tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(zstandard.compress(DATA) + behind)
    found, message = _up_to_the_error(path)
    assert found == DATA
    assert "damaged zstd data" in message


def test_zstd_that_is_cut_off_before_it_gives_anything_is_not_empty(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(zstandard.compress(random.Random(0).randbytes(999) * 9)[:500])
    assert "ends before the first block is whole" in _up_to_the_error(path)[1]


@pytest.mark.parametrize("pack", [gzip.compress, zstandard.compress], ids=["gzip", "zstd"])
def test_a_small_file_may_be_in_several_parts(pack: Callable[[bytes], bytes], tmp_path: Path) -> None:
    whole = pack(DATA[:5]) + pack(b"") + pack(DATA[5:1000]) + pack(DATA[1000:])
    content = Content(whole, tmp_path / "file")
    assert content.read(8) == DATA[:8]
    assert content.read(len(DATA)) == DATA[8:]
    assert content.read(1) == b""


def test_a_small_file_may_end_with_zeros_and_with_nothing_else(tmp_path: Path) -> None:
    packed, path = gzip.compress(DATA), tmp_path / "file"
    assert Content(packed + bytes(9), path).read(len(DATA) + 1) == DATA
    for rest in (b"\0x", b"garbage", b"\x1f"):
        with pytest.raises(InputError, match="what follows a gzip member is neither"):
            Content(packed + rest, path).read(len(DATA) + 1)
    with pytest.raises(InputError, match="ends before the end of the gzip member"):
        Content(packed + packed[:30], path).read(2 * len(DATA))


def test_a_file_of_very_many_gzip_members_is_no_image(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="more than 100 gzip members"):
        Content(gzip.compress(b"") * 5000, tmp_path / "file").read(1)
