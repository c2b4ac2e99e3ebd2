# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Archives: unpacked as a whole or not at all, and nothing outside of their folder."""

from __future__ import annotations

import gzip
import io
import tarfile
import zipfile
from typing import TYPE_CHECKING, Self

import pytest
import zstandard

from tests.fetch.conftest import ARCHIVE, Place, make_tar, sequence_files, sha256
from tumtools.errors import IntegrityError, OutputError
from tumtools.fetch import job, unpack

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from pathlib import Path

FILES = sequence_files()


def tree(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def make_zip(files: dict[str, bytes]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return buffer.getvalue()


KINDS = {
    "tgz": ARCHIVE,
    "tar": make_tar(FILES, "w:"),
    "tar.zst": zstandard.compress(make_tar(FILES, "w:")),
    "zip": make_zip(FILES),
}


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_archive_is_unpacked(place: Place, kind: str) -> None:
    place.serve(KINDS[kind], f"/f/mini.{kind}", drops=[100_000])
    fetched = place.fetch(place.entry(kind=kind))
    assert tree(fetched.path) == {name.partition("/")[2]: data for name, data in FILES.items()}
    assert fetched.sha256 == sha256(KINDS[kind])
    place.fetch(place.entry(kind=kind))
    assert len(place.server.requests) == 2  # it is there


@pytest.mark.parametrize("kind", KINDS)
def test_a_cut_off_archive_of_unknown_checksum_is_not_trusted(place: Place, kind: str) -> None:
    place.serve(KINDS[kind][:-5000], f"/f/mini.{kind}")
    with pytest.raises(IntegrityError, match=r"damaged or cut off|are there"):
        place.fetch(place.entry(kind=kind))
    assert place.nothing_in_place()


@pytest.mark.parametrize("harm", ["flipped bit", "zeroed header"])
def test_a_damaged_header_is_not_the_end_of_the_archive(place: Place, harm: str) -> None:
    data = bytearray(KINDS["tar"])
    with tarfile.open(fileobj=io.BytesIO(data)) as archive:
        offset = archive.getmembers()[-1].offset
    if harm == "flipped bit":
        data[offset + 3] ^= 1
    else:
        data[offset : offset + 512] = bytes(512)
    place.serve(bytes(data), "/f/mini.tar")
    with pytest.raises(IntegrityError, match="damaged or cut off"):
        place.fetch(place.entry(kind="tar"))
    assert place.nothing_in_place()


@pytest.mark.parametrize("kind", KINDS)
def test_nor_is_it_without_unpacking(place: Place, kind: str) -> None:
    place.serve(KINDS[kind][:-5000], f"/f/mini.{kind}")
    with pytest.raises(IntegrityError, match="damaged or cut off"):
        place.fetch(place.entry(kind=kind), unpack=False)
    assert place.nothing_in_place()


@pytest.mark.parametrize("kind", KINDS)
def test_a_whole_archive_of_unknown_checksum_stays_packed(place: Place, kind: str) -> None:
    place.serve(KINDS[kind], f"/f/mini.{kind}")
    assert place.fetch(place.entry(kind=kind), unpack=False).path.read_bytes() == KINDS[kind]


def test_a_whole_archive_with_an_unusual_end_is_read_through(place: Place) -> None:
    body = make_tar(FILES, "w:") + bytes(7)  # no whole block at the end
    place.serve(body, "/f/mini.tar")
    assert place.fetch(place.entry(kind="tar"), unpack=False).path.read_bytes() == body
    body = ARCHIVE + bytes(7)  # padding after the gzip stream
    place.serve(body)
    assert place.fetch(unpack=False).path.read_bytes() == body


def test_an_archive_without_a_folder_at_its_top_gets_one(place: Place) -> None:
    place.serve(make_tar({name.partition("/")[2]: data for name, data in FILES.items()}))
    assert sorted(tree(place.fetch().path)) == ["rgb.txt", "rgb/1305031102.175304.png"]


def test_two_gzip_streams_after_each_other_are_one_archive(place: Place) -> None:
    plain = make_tar(FILES, "w:")
    place.serve(gzip.compress(plain[:200_000]) + gzip.compress(plain[200_000:]))
    assert len(tree(place.fetch().path)) == 2


def member(name: str, kind: bytes = tarfile.REGTYPE, link: str = "", size: int = 0) -> tarfile.TarInfo:
    info = tarfile.TarInfo(name)
    info.type, info.linkname, info.size = kind, link, size
    return info


HOSTILE: dict[str, tuple[Iterable[tarfile.TarInfo], str]] = {
    "parent": ([member("../../evil.txt")], "leads outside"),
    "parent inside": ([member("rgbd_dataset_mini/../../evil.txt")], "leads outside"),
    "absolute": ([member("/evil.txt")], "leads outside"),
    "backslash": ([member("..\\..\\evil.txt")], "leads outside"),
    "drive": ([member("C:\\evil.txt")], "leads outside"),
    "symbolic link": ([member("rgb", tarfile.SYMTYPE, "/etc")], "is a link"),
    "through a link": ([member("d", tarfile.SYMTYPE, ".."), member("d/evil.txt")], "is a link"),
    "hard link": ([member("passwd", tarfile.LNKTYPE, "/etc/passwd")], "is a link"),
    "device": ([member("null", tarfile.CHRTYPE)], "neither a file nor a folder"),
    "fifo": ([member("pipe", tarfile.FIFOTYPE)], "neither a file nor a folder"),
    "twice": ([member("a.txt"), member("./a.txt")], "occurs twice"),
    "file as folder": ([member("a"), member("a/b.txt")], "a file and a folder at once"),
    "folder as file": (
        [member("a/b.txt"), member("a")],
        "a file and a folder at once",
    ),
}


@pytest.mark.parametrize("what", HOSTILE)
def test_hostile_members_end_it_and_leave_nothing(place: Place, what: str) -> None:
    members, message = HOSTILE[what]

    def extra(archive: tarfile.TarFile) -> None:
        for info in members:
            archive.addfile(info)

    place.serve(make_tar(FILES, extra=extra))
    with pytest.raises(IntegrityError, match=message) as caught:
        place.fetch()
    assert "member" in str(caught.value)
    assert place.nothing_in_place()
    assert not list(place.folder.parent.rglob("evil*"))


def test_a_hostile_zip_is_refused_too(place: Place) -> None:
    place.serve(make_zip({**FILES, "../evil.txt": b"x"}), "/f/mini.zip")
    with pytest.raises(IntegrityError, match="leads outside"):
        place.fetch(place.entry(kind="zip"))
    assert place.nothing_in_place()
    assert not list(place.folder.parent.rglob("evil*"))


def bomb_tgz() -> bytes:
    buffer = io.BytesIO()
    with gzip.GzipFile(fileobj=buffer, mode="wb", compresslevel=1) as file:
        header = member("zeros.bin", size=200 << 20).tobuf()
        file.write(header)
        for _ in range(200):
            file.write(bytes(1 << 20))
    return buffer.getvalue()


def bomb_zip() -> bytes:
    return make_zip({"zeros.bin": bytes(200 << 20)})


@pytest.mark.parametrize(("kind", "bomb"), [("tgz", bomb_tgz), ("zip", bomb_zip)])
def test_a_bomb_is_stopped_early(
    place: Place, kind: str, bomb: Callable[[], bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    written = 0
    original = unpack._create

    class Counting:
        def __init__(self, file: io.FileIO) -> None:
            self.file = file

        def __enter__(self) -> Self:
            return self

        def __exit__(self, *_: object) -> None:
            self.file.close()

        def write(self, data: memoryview) -> int:
            nonlocal written
            written += len(data)
            return self.file.write(data)

    monkeypatch.setattr(unpack, "_create", lambda *args: Counting(original(*args)))
    place.serve(bomb(), f"/f/mini.{kind}")
    with pytest.raises(IntegrityError, match="decompression bomb") as caught:
        place.fetch(place.entry(kind=kind))
    assert "trust" in str(caught.value.hint)
    assert written < unpack.BOMB_FLOOR + (1 << 20)
    assert place.nothing_in_place()


def test_a_huge_extended_header_does_not_fill_the_memory(place: Place) -> None:
    buffer = io.BytesIO()
    with gzip.GzipFile(fileobj=buffer, mode="wb") as file:
        file.write(member("x", tarfile.XHDTYPE, size=30 << 20).tobuf())
        file.write(bytes(30 << 20))
    place.serve(buffer.getvalue())
    with pytest.raises(IntegrityError, match="an extended header of 31457280 bytes"):
        place.fetch()


def test_a_member_larger_than_any_image_is_refused(place: Place) -> None:
    buffer = io.BytesIO()
    with gzip.GzipFile(fileobj=buffer, mode="wb") as file:
        file.write(member("big.bin", size=1 << 40).tobuf() + bytes(4096))
    place.serve(buffer.getvalue())
    with pytest.raises(IntegrityError, match="1099511627776 bytes"):
        place.fetch()


def test_too_little_space_is_said_before_with_the_numbers(
    place: Place, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Usage:
        free = 500_000_000

    monkeypatch.setattr(job.shutil, "disk_usage", lambda _path: Usage)
    place.serve(content_length=400_000_000)
    with pytest.raises(OutputError) as caught:
        place.fetch()
    assert caught.value.path == str(place.cache)
    assert (
        "mini/one needs 857 MB (400 MB to download, 440 MB unpacked and some to spare), 500 MB are free"
        in str(caught.value)
    )
    assert place.server.sent < 1_000_000  # the answer was not read
    assert place.nothing_in_place()


def test_a_list_that_names_missing_images_is_told(place: Place) -> None:
    files = {name: data for name, data in FILES.items() if not name.endswith("png")}
    place.serve(make_tar({**files, "rgbd_dataset_mini/depth.txt": b""}))
    notes = place.fetch().notes
    assert "rgb.txt names 1 images, 1 of them are not there (first: rgb/1305031102.175304.png)" in notes


@pytest.mark.parametrize(
    ("facts", "message"),
    [
        ({"frames": {"rgb": 2}}, "rgb.txt names 1 images, the catalogue counts 2"),
        ({"streams": ("rgb", "depth")}, "depth.txt is missing"),
        ({"streams": ("groundtruth",)}, "groundtruth.txt is missing"),
        ({"inner_files": {"rgb.txt": {"bytes": 3}}}, "rgb.txt has 99 bytes, the catalogue's has 3"),
        ({"inner_files": {"rgb.txt": {"sha256": "0" * 64}}}, "rgb.txt has another sha256"),
    ],
)
def test_what_differs_from_the_catalogue_is_refused_unless_the_checksum_is_right(
    place: Place, facts: dict[str, object], message: str
) -> None:
    from tumtools.catalogue.entry import as_table, parse_entry

    table = as_table(place.entry())
    assert isinstance(table, dict)
    place.serve()
    with pytest.raises(IntegrityError, match=message):
        place.fetch(parse_entry({**table, **facts}, "x", "y"))
    assert place.nothing_in_place()
    table["files"]["tgz"]["sha256"] = sha256(ARCHIVE)
    assert message in " ".join(place.fetch(parse_entry({**table, **facts}, "x", "y")).notes)
    assert len(place.server.requests) == 1  # what was downloaded had been kept
