# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Archives are read without unpacking, in any order of members; hostile and damaged ones are refused."""

from __future__ import annotations

import gzip
import io
import random
import shutil
import struct
import tarfile
import tracemalloc
import zipfile
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
import zstandard

from tests.formats.tum.archives import ORDERS, SUFFIXES, file, files_of, pack, tar
from tumtools.digest import digest
from tumtools.errors import InputError
from tumtools.formats.options import ReadOptions
from tumtools.formats.tum import inflate
from tumtools.formats.tum.inflate import SeekableStream
from tumtools.sources import open_source

if TYPE_CHECKING:
    from collections.abc import Callable

    from tests.formats.tum.archives import Member

FULL = Path(__file__).parents[3] / "fixtures" / "full"
LIST = b"1.000000 rgb/1.000000.png\n"


@pytest.fixture(params=["checkpoints", "spool"], autouse=True)
def way(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Compressed archives are read in two ways, and every test holds for both."""
    options = ReadOptions(scratch=tmp_path if request.param == "spool" else None)
    monkeypatch.setattr(f"{__name__}.open_source", partial(open_source, options=options))


def _value(path: Path) -> str:
    with open_source(path) as sequence:
        return digest(sequence).value


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("order", ORDERS)
def test_every_archive_in_any_order_holds_what_the_folder_holds(
    tmp_path: Path, suffix: str, order: str
) -> None:
    path = pack(FULL, tmp_path / f"full{suffix}", order)
    with open_source(path) as sequence, open_source(FULL) as folder:
        assert digest(sequence) == digest(folder)
        assert digest(sequence, jobs=1) == digest(folder)
        assert sequence.info == folder.info


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_files_at_the_top_of_the_archive_and_deep_in_it_are_found(tmp_path: Path, suffix: str) -> None:
    outer = tmp_path / "outer" / "inner" / "seq"
    shutil.copytree(FULL, outer)
    for number, folder in enumerate([outer, tmp_path / "outer"]):
        assert _value(pack(folder, tmp_path / f"{number}{suffix}")) == _value(FULL)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_files_beside_the_sequence_are_not_part_of_it_and_told(tmp_path: Path, suffix: str) -> None:
    folder = tmp_path / "outer"
    shutil.copytree(FULL, folder / "seq")
    name = next((FULL / "rgb").iterdir()).name
    (folder / "rgb").mkdir()
    (folder / "rgb" / name).write_bytes(b"another file of the same name")
    (folder / "README").write_text("hello")
    path = pack(folder, tmp_path / f"x{suffix}", "alphabetical")
    assert _value(path) == _value(FULL)
    with open_source(path) as sequence:
        assert [(loss.stream, loss.count) for loss in sequence.info.not_carried] == [
            ("../README", 1),
            ("../rgb/", 1),
        ]
        assert all("beside the folder of the sequence" in loss.why for loss in sequence.info.not_carried)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_two_sequences_are_refused_with_their_names(tmp_path: Path, suffix: str) -> None:
    for name in ("one", "two"):
        shutil.copytree(FULL, tmp_path / "both" / name)
    with pytest.raises(InputError, match="more than one sequence in this archive: both/one/, both/two/"):
        open_source(pack(tmp_path / "both", tmp_path / f"both{suffix}"))


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_an_archive_without_a_sequence_is_refused(tmp_path: Path, suffix: str) -> None:
    (tmp_path / "x").mkdir()
    (tmp_path / "x" / "readme.txt").write_text("nothing")
    with pytest.raises(InputError, match=r"no sequence in this archive: none of rgb.txt"):
        open_source(pack(tmp_path / "x", tmp_path / f"x{suffix}"))


# --- hostile archives -----------------------------------------------------------------------------------


def _member(kind: bytes, name: str = "seq/x", link: str = "") -> Member:
    member = tarfile.TarInfo(name)
    member.type, member.linkname = kind, link
    return member, b""


HOSTILE: dict[str, Member] = {
    "parent": file("../seq/x", b"x"),
    "parent inside": file("seq/../../x", b"x"),
    "absolute": file("/etc/x", b"x"),
    "backslash": file("..\\x", b"x"),
    "drive": file("C:/x", b"x"),
    "symbolic link": _member(tarfile.SYMTYPE, link="/etc/passwd"),
    "hard link": _member(tarfile.LNKTYPE, link="seq/rgb.txt"),
    "device": _member(tarfile.CHRTYPE),
    "pipe": _member(tarfile.FIFOTYPE),
}


@pytest.mark.parametrize("compress", [bytes, gzip.compress, zstandard.compress], ids=["tar", "tgz", "zst"])
@pytest.mark.parametrize("what", HOSTILE)
def test_hostile_members_of_a_tar_are_refused(
    tmp_path: Path, what: str, compress: Callable[[bytes], bytes]
) -> None:
    path = tmp_path / "x.tgz"
    path.write_bytes(compress(tar([file("seq/rgb.txt", LIST), HOSTILE[what]])))
    with pytest.raises(InputError, match=r"leads outside|is a link|neither a file nor a folder") as caught:
        open_source(path)
    assert caught.value.path == str(path)
    assert caught.value.location == f"member {HOSTILE[what][0].name}"


@pytest.mark.parametrize(
    ("name", "mode", "said"),
    [
        ("../x", 0o100644, "leads outside"),
        ("/x", 0o100644, "leads outside"),
        ("seq/link", 0o120777, "a link"),
        ("seq/device", 0o020666, "neither a file nor a folder"),
    ],
)
def test_hostile_members_of_a_zip_are_refused(tmp_path: Path, name: str, mode: int, said: str) -> None:
    path = tmp_path / "x.zip"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("seq/rgb.txt", LIST)
        member = zipfile.ZipInfo(name)
        member.external_attr = mode << 16
        archive.writestr(member, b"/etc/passwd")
    with pytest.raises(InputError, match=said) as caught:
        open_source(path)
    assert caught.value.location == f"member {name}"


def _with_size(size: int) -> bytes:
    """Return a tar archive whose second member claims a size."""
    member, data = file("seq/rgb/1.000000.png")
    member.size = size
    return tar([file("seq/rgb.txt", LIST)])[:1024] + member.tobuf() + data


@pytest.mark.parametrize("size", [600, 10**6, 2**28])
def test_a_member_with_a_lying_size_is_refused(tmp_path: Path, size: int) -> None:
    path = tmp_path / "x.tar"
    path.write_bytes(_with_size(size) + bytes(512))
    with pytest.raises(InputError, match="the archive ends inside of this member") as caught:
        open_source(path)
    assert caught.value.location == "member seq/rgb/1.000000.png"


@pytest.mark.parametrize("size", [2**28 + 1, 2**33, 2**60])
def test_a_member_too_large_for_the_memory_is_refused(tmp_path: Path, size: int) -> None:
    path = tmp_path / "x.tar"
    path.write_bytes(_with_size(size) + bytes(2048))
    with pytest.raises(InputError, match=f"the member has {size} bytes"):
        open_source(path)


def test_a_negative_size_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "x.tar"
    data = bytearray(_with_size(0) + bytes(1024))
    data[1024 + 124 : 1024 + 136] = b"\xff" * 12
    data[1024 + 148 : 1024 + 156] = b" " * 8
    data[1024 + 148 : 1024 + 156] = b"%06o\0 " % sum(data[1024 : 1024 + 512])
    path.write_bytes(data)
    with pytest.raises(InputError, match="the member has -1 bytes"):
        open_source(path)


@pytest.mark.parametrize("compress", [gzip.compress, zstandard.compress], ids=["tgz", "zst"])
def test_a_bomb_in_a_header_or_in_many_texts_takes_no_memory(
    tmp_path: Path, compress: Callable[[bytes], bytes]
) -> None:
    long_name = tarfile.TarInfo("././@LongLink")
    long_name.type, long_name.size = tarfile.GNUTYPE_LONGNAME, 1 << 26
    header = tmp_path / "header.tgz"
    header.write_bytes(compress(long_name.tobuf(tarfile.GNU_FORMAT) + bytes((1 << 26) + 1024)))
    texts = tmp_path / "texts.tgz"
    zeros = bytes(1 << 25)
    texts.write_bytes(
        compress(tar([file("seq/rgb.txt", LIST), *(file(f"seq/{n}.txt", zeros) for n in "abc")]))
    )
    del zeros
    tracemalloc.start()
    try:
        with pytest.raises(InputError, match="a header of 67108864 bytes"):
            open_source(header)
        open_source(texts).close()
        assert tracemalloc.get_traced_memory()[1] < 60e6
    finally:
        tracemalloc.stop()


def test_chained_headers_do_not_exhaust_the_stack(tmp_path: Path) -> None:
    header = tarfile.TarInfo("x")
    header.type, header.size = tarfile.XHDTYPE, 0
    path = tmp_path / "x.tar"
    path.write_bytes(header.tobuf() * 5000 + bytes(1024))
    with pytest.raises(InputError, match="not a readable tar archive"):
        open_source(path)


def test_a_zip_member_that_unpacks_to_more_than_it_says_is_refused(tmp_path: Path) -> None:
    path = pack(FULL, tmp_path / "x.zip")
    data = bytearray(path.read_bytes())
    name = f"full/rgb/{min((FULL / 'rgb').iterdir()).name}".encode()
    directory = data.index(b"PK\1\2", data.rindex(name) - 46)
    (size,) = struct.unpack_from("<I", data, directory + 24)
    struct.pack_into("<I", data, directory + 24, size - 100)
    path.write_bytes(data)
    with pytest.raises(InputError, match=r"unpacks to|damaged") as caught:
        _value(path)
    assert caught.value.location == f"member {name.decode().removeprefix('full/')}"


# --- damaged archives -----------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("share", [0.02, 0.3, 0.5, 0.9, 0.99, 0.9999])
def test_a_cut_archive_is_refused(tmp_path: Path, suffix: str, share: float) -> None:
    path = pack(FULL, tmp_path / f"x{suffix}")
    data = path.read_bytes()
    # A plain tar is whole with the second of its zero blocks; the others are padding.
    end = len(data.rstrip(b"\0")) + 1024 if suffix == ".tar" else len(data)
    path.write_bytes(data[: int(end * share)])
    with pytest.raises(InputError) as caught:
        _value(path)
    assert caught.value.path == str(path)
    assert caught.value.location or suffix == ".zip"


@pytest.mark.parametrize("suffix", [".tar", ".tgz"])
def test_an_archive_that_ends_after_a_whole_member_is_refused(tmp_path: Path, suffix: str) -> None:
    data = tar([file("seq/rgb.txt", b"# nothing\n")])[:1024]
    path = tmp_path / f"x{suffix}"
    path.write_bytes(gzip.compress(data) if suffix == ".tgz" else data)
    with pytest.raises(InputError, match="without its end marker") as caught:
        open_source(path)
    assert caught.value.location == "after member seq/rgb.txt"


COMPRESS: dict[str, Callable[[bytes], bytes]] = {
    ".tar": bytes,
    ".tgz": gzip.compress,
    ".tar.zst": zstandard.compress,
}


def _harm(data: bytearray, offset: int, harm: str) -> None:
    if harm == "flipped bit":
        data[offset + 3] ^= 1
    else:
        data[offset : offset + 512] = bytes(512)


@pytest.mark.parametrize("suffix", COMPRESS)
@pytest.mark.parametrize("layout", [tarfile.GNU_FORMAT, tarfile.PAX_FORMAT], ids=["gnu", "pax"])
@pytest.mark.parametrize("harm", ["flipped bit", "zeroed header"])
def test_a_damaged_header_is_not_the_end_of_the_archive(
    tmp_path: Path, suffix: str, layout: int, harm: str
) -> None:
    target = io.BytesIO()
    with tarfile.open(fileobj=target, mode="w", format=layout) as archive:
        archive.add(FULL, "full")
    data = bytearray(target.getvalue())
    with tarfile.open(fileobj=io.BytesIO(data)) as archive:
        members = archive.getmembers()
    headers = [member.offset for member in members if member.name.startswith("full/rgb")]
    headers += [member.offset_data - 512 for member in members if member.name.startswith("full/rgb/")][:1]
    path = tmp_path / f"x{suffix}"
    for offset in headers:
        broken = bytearray(data)
        _harm(broken, offset, harm)
        path.write_bytes(COMPRESS[suffix](bytes(broken)))
        with pytest.raises(
            InputError, match=r"header at offset \d+|behind its end marker|end of file header|bad checksum"
        ) as caught:
            open_source(path).close()
        assert caught.value.location
        assert caught.value.location.startswith("after member full")


@pytest.mark.parametrize("suffix", COMPRESS)
def test_an_archive_ends_with_two_zero_blocks_and_nothing_but_zeros(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"x{suffix}"
    content = tar([file("seq/rgb.txt", b"# nothing\n")])[:1024]
    path.write_bytes(COMPRESS[suffix](content + bytes(1024)))
    open_source(path).close()
    path.write_bytes(COMPRESS[suffix](content + bytes(512)))
    with pytest.raises(InputError, match="without its end marker"):
        open_source(path)
    path.write_bytes(COMPRESS[suffix](content + bytes(600_000) + b"x"))
    with pytest.raises(InputError, match=r"data at offset 601024 .* behind its end marker at 1024"):
        open_source(path)


@pytest.mark.parametrize("suffix", [".tgz", ".tar.zst"])
def test_data_behind_the_padding_of_a_compressed_archive_is_refused(tmp_path: Path, suffix: str) -> None:
    path = pack(FULL, tmp_path / f"x{suffix}")
    path.write_bytes(path.read_bytes() + bytes(3000) + b"x")
    with pytest.raises(InputError, match="behind the zeros that end the compressed data"):
        open_source(path)


def test_a_checksum_behind_the_end_marker_is_looked_at(tmp_path: Path) -> None:
    path = pack(FULL, tmp_path / "x.tgz")
    data = bytearray(path.read_bytes())
    data[-6] ^= 1
    path.write_bytes(data)
    with pytest.raises(InputError, match=r"incorrect data check|Incorrect checksum"):
        open_source(path)


@pytest.mark.parametrize("suffix", [".tgz", ".tar.zst", ".zip"])
def test_no_flipped_bit_changes_what_is_read(tmp_path: Path, suffix: str) -> None:
    path = pack(FULL, tmp_path / f"x{suffix}")
    good, value = path.read_bytes(), _value(path)
    random_bits = random.Random(0)
    for _ in range(40):
        data = bytearray(good)
        data[random_bits.randrange(len(data))] ^= 1 << random_bits.randrange(8)
        path.write_bytes(data)
        try:
            found = _value(path)
        except InputError as error:
            assert error.path or error.location  # noqa: PT017 - either outcome is right
        else:
            assert found == value


def test_zeros_after_a_compressed_archive_are_padding(tmp_path: Path) -> None:
    for suffix in (".tgz", ".tar.zst"):
        path = pack(FULL, tmp_path / f"x{suffix}")
        path.write_bytes(path.read_bytes() + bytes(3000))
        assert _value(path) == _value(FULL)


def test_an_archive_may_have_several_compressed_parts(tmp_path: Path) -> None:
    data = tar(file(f"full/{name}", text) for name, text in sorted(files_of(FULL).items()))
    parts = [data[start : start + 20_000] for start in range(0, len(data), 20_000)]
    for suffix, compress in ((".tgz", gzip.compress), (".tar.zst", zstandard.compress)):
        path = tmp_path / f"x{suffix}"
        path.write_bytes(b"".join(map(compress, parts)))
        assert _value(path) == _value(FULL)


@pytest.mark.parametrize("data", [b"\x1f\x8b" + bytes(50), zstandard.compress(b"x" * 99)[:10] + b"\xff" * 40])
def test_a_damaged_beginning_is_named(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "x.tgz"
    path.write_bytes(data)
    with pytest.raises(InputError) as caught:
        open_source(path)
    assert caught.value.path == str(path)


@pytest.mark.parametrize("compress", [gzip.compress, zstandard.compress], ids=["tgz", "zst"])
def test_something_else_compressed_is_no_sequence(tmp_path: Path, compress: Callable[[bytes], bytes]) -> None:
    path = tmp_path / "x.tgz"
    path.write_bytes(compress(b"\x7fELF no archive"))
    with pytest.raises(InputError, match="no format of tumtools begins with"):
        open_source(path)


# --- random access --------------------------------------------------------------------------------------


@pytest.mark.parametrize("compress", [gzip.compress, zstandard.compress], ids=["gzip", "zstd"])
@pytest.mark.parametrize("scanned", [True, False])
def test_any_place_of_the_stream_is_read_in_any_order(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compress: Callable[[bytes], bytes], scanned: bool
) -> None:
    monkeypatch.setattr(inflate, "_MIN_SPACING", 10_000)
    content = np.random.default_rng(0).integers(0, 64, 3_000_000, np.uint8).tobytes()
    path = tmp_path / "x"
    path.write_bytes(compress(content))
    stream = SeekableStream(path)
    if scanned:
        stream.skip_scan(10**9)
        assert stream.scanned == len(content)
        assert stream.scan(10) == b""
    random_places = random.Random(0)
    for _ in range(100):
        offset, size = random_places.randrange(len(content) + 10), random_places.randrange(100_000)
        assert stream.read_at(offset, size) == content[offset : offset + size]
    stream.close()


def test_checkpoints_hold_no_content(tmp_path: Path) -> None:
    path = tmp_path / "x.gz"
    path.write_bytes(
        gzip.compress(np.random.default_rng(0).integers(0, 200, 8_000_000, np.uint8).tobytes(), 1)
    )
    stream = SeekableStream(path)
    stream.skip_scan(10**9)
    assert len(stream._checkpoints) >= 2
    assert not any(cursor._buffer for cursor in stream._checkpoints)
    stream.close()


def test_an_archive_is_not_kept_open_when_it_is_refused(tmp_path: Path) -> None:
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w") as archive:
        archive.writestr("x", b"")
    (tmp_path / "x.zip").write_bytes(target.getvalue())
    with pytest.raises(InputError):  # an archive left open warns, and warnings are errors here
        open_source(tmp_path / "x.zip")
