# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Damaged files give an error that names the place; never a traceback, a hang, wrong data or much memory."""

from __future__ import annotations

import random
import resource
import struct
from typing import TYPE_CHECKING

import lz4.frame
import numpy as np
import pytest
import zstandard

from tests.formats.mcap.foreign import Foreign
from tests.memory import SECOND, START, Memory, accelerometer, full, groundtruth
from tumtools.convert import convert
from tumtools.digest import digest
from tumtools.errors import InputError, TumtoolsError, UnsupportedInputError
from tumtools.formats.mcap import reader
from tumtools.formats.mcap.file import McapFile
from tumtools.formats.mcap.records import CHUNK_HEADER, MAGIC, Op, record, string
from tumtools.formats.options import ReadOptions, WriteOptions
from tumtools.images.codec import pixels_of
from tumtools.sources import open_source

if TYPE_CHECKING:
    from pathlib import Path

FLIPS = 1000
CUTS = 150
CHUNK_CRC = struct.Struct("<I")


def _ours(path: Path, **options: object) -> bytes:
    times = [START + n * SECOND // 30 for n in range(4)]
    sequence = Memory(
        {"rgb": times, "depth": times},
        accelerometer=accelerometer(*times),
        groundtruth=groundtruth(*times),
    )
    convert(sequence, path, "mcap", WriteOptions(**options))  # type: ignore[arg-type]  # as given
    return path.read_bytes()


def _read_all(path: Path, options: ReadOptions | None = None) -> str:
    """Read everything, decode every image; return the digest of it all."""
    with open_source(path, options or ReadOptions()) as sequence:
        for frame in sequence.images():
            pixels_of(frame.load())
        return digest(sequence, jobs=1).value


def test_a_file_cut_anywhere_names_the_offset(tmp_path: Path) -> None:
    data = _ours(tmp_path / "whole.mcap")
    places = {0, 1, 7, 8, 9, len(data) - 1, len(data) - 8, len(data) - 9, len(data) - 37}
    places |= set(random.Random(1).sample(range(len(data)), CUTS))
    path = tmp_path / "cut.mcap"
    for place in sorted(places):
        path.write_bytes(data[:place])
        with pytest.raises(InputError) as caught:
            _read_all(path)
        assert caught.value.path == str(path)
        assert caught.value.exit_code == 4
        assert place < 9 or "offset" in (caught.value.location or "")


def test_what_stands_before_the_cut_can_be_salvaged(tmp_path: Path) -> None:
    data = _ours(tmp_path / "whole.mcap")
    data_end = data.rindex(bytes([Op.DATA_END]) + (4).to_bytes(8, "little"))
    path = tmp_path / "cut.mcap"
    counts = []
    for place in sorted(random.Random(2).sample(range(len(MAGIC), len(data)), 60)):
        path.write_bytes(data[:place])
        with open_source(path, ReadOptions(salvage=True, lenient=True)) as sequence:
            frames = [pixels_of(frame.load()) for frame in sequence.images()]
            assert any("offset" in text for text in sequence.info.warnings)
            told = {loss.what: loss.count for loss in sequence.info.not_carried}
            assert told.get("end missing") == (1 if place < data_end + 13 else None)
            counts.append(len(frames))
    assert counts == sorted(counts)
    assert counts[0] == 0
    assert counts[-1] == 8


@pytest.mark.parametrize("compression", ["zstd", "lz4"])
def test_a_salvage_leaves_out_a_damaged_chunk_that_the_index_knows_nothing_of(
    tmp_path: Path, compression: str
) -> None:
    path = tmp_path / "x.mcap"
    times = [START + n * SECOND // 30 for n in range(3)]
    sequence = Memory({"rgb": times, "depth": times}, accelerometer=accelerometer(*times), encoding="rgb8")
    convert(sequence, path, "mcap", WriteOptions(color_encoding="rgb8", compression=compression))
    places = [place.offset for place in McapFile(path).chunks]
    data = bytearray(path.read_bytes())
    data[places[0] + 9 + CHUNK_HEADER.size + 60] ^= 0xFF
    path.write_bytes(data)
    with pytest.raises(InputError, match="chunk") as caught:
        _read_all(path)
    assert "--salvage" in (caught.value.hint or "")
    with open_source(path, ReadOptions(salvage=True)) as found:
        assert any(f"offset {places[0]}" in text for text in found.info.warnings)
        for frame in found.images():
            pixels_of(frame.load())
        lost = {loss.stream: loss.count for loss in found.info.not_carried}
        assert {loss.what for loss in found.info.not_carried} == {"messages left out as damaged"}
        assert lost["/camera/rgb/image_color"] == 3 - len(found.image_stamps("rgb"))
        assert lost["/camera/depth/image"] == 3 - len(found.image_stamps("depth"))
        assert sum(lost.values()) > 0


@pytest.mark.parametrize("options", [{}, {"archive": True}, {"compression": "none"}])
def test_a_salvage_of_a_sound_file_leaves_nothing_out(tmp_path: Path, options: dict[str, object]) -> None:
    path = tmp_path / "x.mcap"
    data = _ours(path, **options)
    with open_source(path, ReadOptions(salvage=True)) as found:
        assert (found.info.not_carried, found.info.warnings) == ((), ())
    # Without a summary there is nothing to hold it against, nor is anything missing.
    end = data.rindex(bytes([Op.DATA_END]) + (4).to_bytes(8, "little")) + 13
    path.write_bytes(data[:end] + record(Op.FOOTER, bytes(20)) + MAGIC)
    with open_source(path, ReadOptions(salvage=True)) as found:
        assert (found.info.not_carried, found.info.warnings) == ((), ())


def test_bytes_are_told_where_no_summary_counts_messages(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    data = bytearray(_ours(path))
    place = McapFile(path).chunks[0].offset
    size = int.from_bytes(data[place + 1 : place + 9], "little")
    data[place + 9 + CHUNK_HEADER.size + 60] ^= 0xFF
    end = data.rindex(bytes([Op.DATA_END]) + (4).to_bytes(8, "little")) + 13
    path.write_bytes(data[:end] + record(Op.FOOTER, bytes(20)) + MAGIC)
    with open_source(path, ReadOptions(salvage=True, lenient=True)) as found:
        lost = {(loss.stream, loss.what): loss.count for loss in found.info.not_carried}
    assert lost["recording", "bytes left out as damaged"] == size
    assert ("recording", "end missing") not in lost


def test_attachments_and_notes_of_others_behind_the_damage_are_told(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    with Foreign(path) as file:
        for row in range(3):
            file.image("/camera/image", START + row, row)
        file.library.add_metadata("operator", {"a": "b"})
        file.library.add_attachment(START, START, "calibration.yaml", "text/plain", b"x: 1")
    data = bytearray(path.read_bytes())
    at = data.index(b"\x08\0\0\0operator") - 9
    data[at + 1 : at + 9] = b"\xff" * 8
    path.write_bytes(data)
    with open_source(path, ReadOptions(salvage=True)) as found:
        assert [(loss.stream, loss.what, loss.count) for loss in found.info.not_carried] == [
            ("/camera/image", "messages left out as damaged", 3),
            ("attachments", "left out as damaged", 1),
            ("metadata records", "left out as damaged", 1),
        ]


def test_messages_of_a_channel_that_is_nowhere_are_told(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    message = record(Op.MESSAGE, (7).to_bytes(2, "little") + bytes(20) + b"hello")
    head = record(Op.HEADER, string("ros2"), string("somebody"))
    path.write_bytes(MAGIC + head + message * 2 + record(Op.FOOTER, bytes(20)) + MAGIC)
    with open_source(path) as found:
        (loss,) = found.info.not_carried
        assert (loss.what, loss.count) == ("messages of unknown channels not carried over", 2)


def test_a_salvage_uses_what_stands_before_the_damage_in_a_chunk_without_a_checksum(tmp_path: Path) -> None:
    whole = tmp_path / "whole.mcap"
    data = bytearray(_ours(whole, compression="none"))
    file = McapFile(whole)
    place = file.chunks[0].offset
    CHUNK_CRC.pack_into(data, place + 9 + CHUNK_HEADER.size - 4, 0)
    inner = [at for _, _, at in file.inner(file.chunk(0), place)]
    start = data.index(bytes(file.chunk(0)[:16]), place)
    data[start + inner[-1] + 1 : start + inner[-1] + 9] = b"\xff" * 8
    (tmp_path / "x.mcap").write_bytes(data)
    with open_source(tmp_path / "x.mcap", ReadOptions(salvage=True, lenient=True)) as found:
        frames = [pixels_of(frame.load()) for frame in found.images()]
        assert found.accelerometer is not None
        assert len(frames) + len(found.accelerometer) > 0
        assert any("does not fit" in text for text in found.info.warnings)


@pytest.mark.parametrize("options", [{}, {"archive": True}], ids=["default", "archive"])
def test_flipped_bits_are_noticed_or_harmless(tmp_path: Path, options: dict[str, object]) -> None:
    """A flip may go unnoticed only where nothing that is read stands; it never changes what is read."""
    data = _ours(tmp_path / "whole.mcap", **options)
    expected = _read_all(tmp_path / "whole.mcap")
    path = tmp_path / "flipped.mcap"
    chance = random.Random(3)
    noticed = 0
    for _ in range(FLIPS // 2):
        place = chance.randrange(len(data) * 8)
        flipped = bytearray(data)
        flipped[place // 8] ^= 1 << place % 8
        path.write_bytes(flipped)
        try:
            found = _read_all(path)
        except TumtoolsError as error:
            noticed += 1
            assert error.path == str(path), str(error)  # noqa: PT017 - an error is not expected each time
        else:
            assert found == expected, f"bit {place} changes what is read"
    assert noticed > FLIPS // 8
    used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert used < 1_000_000


@pytest.mark.parametrize("options", [{}, {"archive": True}], ids=["default", "archive"])
def test_flipped_bits_do_not_stop_a_salvage(tmp_path: Path, options: dict[str, object]) -> None:
    data = _ours(tmp_path / "whole.mcap", **options)
    path = tmp_path / "flipped.mcap"
    chance = random.Random(4)
    for _ in range(FLIPS // 5):
        place = chance.randrange(len(data) * 8)
        flipped = bytearray(data)
        flipped[place // 8] ^= 1 << place % 8
        path.write_bytes(flipped)
        try:
            _read_all(path, ReadOptions(salvage=True, lenient=True))
        except TumtoolsError as error:
            assert error.path == str(path), str(error)  # noqa: PT017 - an error is not expected each time


def _file(*records: bytes) -> bytes:
    return b"".join([MAGIC, record(Op.HEADER, string("ros2"), string("test")), *records])


def _chunk(body: bytes, size: int, compression: str, crc: int = 0) -> bytes:
    head = CHUNK_HEADER.pack(0, 0, size, crc) + string(compression)
    return record(Op.CHUNK, head, struct.pack("<Q", len(body)), body)


END = record(Op.DATA_END, bytes(4)) + record(Op.FOOTER, bytes(20)) + MAGIC
BIG = 1 << 40


@pytest.mark.parametrize(
    ("records", "why"),
    [
        (struct.pack("<BQ", Op.CHUNK, BIG), "says it has"),
        (_chunk(b"", BIG, ""), "none has more than"),
        (_chunk(b"x", 1 << 27, ""), "its header says"),
        (_chunk(zstandard.compress(bytes(10)), 1 << 27, "zstd"), "says it has 10 bytes, its header says"),
        (_chunk(b"\x28\xb5\x2f\xfd\xc0" + struct.pack("<Q", BIG) + bytes(20), 100, "zstd"), "says it has"),
        (_chunk(zstandard.compress(bytes(1 << 20)), 100, "zstd"), "says it has"),
        (_chunk(lz4.frame.compress(bytes(1 << 20)), 100, "lz4"), "bytes, its header says"),
        (_chunk(lz4.frame.compress(bytes(10)), 100, "lz4"), "bytes, its header says"),
        (_chunk(b"nonsense", 100, "lz4"), "cannot be decompressed"),
        (_chunk(b"nonsense", 100, "zstd"), "cannot be decompressed"),
        (_chunk(bytes(10), 10, "", crc=1), "CRC of the chunk"),
        (_chunk(struct.pack("<BQ", Op.MESSAGE, BIG), 9, ""), "does not fit"),
        (_chunk(struct.pack("<BQ", Op.MESSAGE, 3) + b"abc", 12, ""), "does not fit"),
        (_chunk(b"\5", 1, ""), "does not fit"),
        (record(Op.MESSAGE, b"abc"), "without its header"),
        (record(Op.SCHEMA, b"\1\0", struct.pack("<I", 2**32 - 1)), "ends too early"),
        (record(Op.CHANNEL, bytes(4), string("a"), string("b"), struct.pack("<I", 7)), "ends too early"),
        (record(Op.METADATA, string("tumtools"), string(b"abc")), "ends too early"),
    ],
)
def test_sizes_that_lie_take_no_memory(tmp_path: Path, records: bytes, why: str) -> None:
    path = tmp_path / "x.mcap"
    path.write_bytes(_file(records) + END)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(InputError, match=why) as caught:
        _read_all(path)
    assert caught.value.path == str(path)
    assert "offset" in (caught.value.location or "")
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 400_000


def test_a_footer_of_another_length_is_damage(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    data = bytearray(_ours(path))
    data[len(data) - len(MAGIC) - 28] ^= 1 << 4
    path.write_bytes(data)
    with pytest.raises(InputError, match="the footer says it has 4 bytes") as caught:
        _read_all(path)
    assert caught.value.location == f"offset {len(data) - len(MAGIC) - 29}"
    assert _read_all(path, ReadOptions(salvage=True))


def test_an_unknown_compression_is_named(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    path.write_bytes(_file(_chunk(b"x", 1, "brotli")) + END)
    with pytest.raises(UnsupportedInputError, match="brotli"):
        _read_all(path)


def test_an_index_that_names_a_chunk_many_times_is_refused(tmp_path: Path) -> None:
    """It would make a small file fill the memory."""
    data = _ours(tmp_path / "x.mcap")
    start = len(data) - len(MAGIC) - 20
    summary, _, _ = struct.unpack_from("<QQI", data, start)
    body = data[summary : start - 9]
    footer = record(Op.FOOTER, struct.pack("<QQI", summary, 0, 0)) + MAGIC
    (tmp_path / "x.mcap").write_bytes(data[:summary] + body * 50 + footer)
    with pytest.raises(InputError, match="twice"):
        _read_all(tmp_path / "x.mcap")


def test_an_empty_file(tmp_path: Path) -> None:
    (tmp_path / "x.mcap").touch()
    for opened in (lambda path: reader.open(path, ReadOptions()), open_source):
        with pytest.raises(InputError, match="empty"):
            opened(tmp_path / "x.mcap")


def test_a_wrong_time_in_the_index_of_messages_is_noticed(tmp_path: Path) -> None:
    """No checksum covers these indexes, and stamps are taken from them."""
    convert(full(), tmp_path / "x.mcap", "mcap")
    data = bytearray((tmp_path / "x.mcap").read_bytes())
    place = data.index(b"\x07" + struct.pack("<Q", 2 + 4 + 16))
    time = struct.unpack_from("<Q", data, place + 15)[0]
    struct.pack_into("<Q", data, place + 15, time + 1)
    (tmp_path / "x.mcap").write_bytes(data)
    with pytest.raises(InputError, match="index is wrong"):
        _read_all(tmp_path / "x.mcap")


def test_depth_values_survive_untouched(tmp_path: Path) -> None:
    _ours(tmp_path / "x.mcap")
    with open_source(tmp_path / "x.mcap") as sequence:
        convert(sequence, tmp_path / "out", "tum")
    with open_source(tmp_path / "out") as result:
        found = np.unique(np.concatenate([pixels_of(frame.load()) for frame in result.images(["depth"])]))
        assert {0, 65535} <= set(found.tolist())


def test_a_file_may_be_overwritten_once_it_is_closed(tmp_path: Path) -> None:
    """No thread goes on to read ahead in a file that may have become shorter, which would end the process."""
    path = tmp_path / "x.mcap"
    data = _ours(path, compression="none")
    for _ in range(50):
        with open_source(path) as sequence:
            next(sequence.images())
        path.write_bytes(b"")
        path.write_bytes(data)
