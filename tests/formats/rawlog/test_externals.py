# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""External files are found where MRPT looks, and never outside; depth is told by its content."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING

import numpy as np
import pytest

from tumtools.errors import InputError, MissingInputError
from tumtools.formats.rawlog.compression import CONTAINERS, deflate
from tumtools.formats.rawlog.externals import Folder, depth_payload, metres_payload, read_depth

if TYPE_CHECKING:
    from pathlib import Path

COUNTS = np.array([[0, 1, 2], [5000, 65534, 65535]], np.uint16)
METRES = (COUNTS / 5000).astype(np.float32)


@pytest.fixture
def folder(tmp_path: Path) -> Folder:
    (tmp_path / "a_Images").mkdir()
    return Folder(tmp_path / "a.rawlog")


@pytest.mark.parametrize("name", ["a_Images", "a_images", "a_IMAGES", "Images"])
def test_the_folder_has_one_of_four_names(name: str, tmp_path: Path) -> None:
    (tmp_path / name / "sub").mkdir(parents=True)
    (tmp_path / name / "sub" / "x.png").write_bytes(b"x")
    found = Folder(tmp_path / "a.rawlog")
    assert found.read("sub/x.png") == b"x"
    assert found.read("sub\\x.png") == b"x"


@pytest.mark.parametrize(
    ("rawlog", "name"),
    [
        ("ref.log", "ref_Images"),
        ("ref.RAWLOG", "ref_images"),
        ("ref.v2.log", "ref.v2_IMAGES"),
        ("ref.rawlog.rawlog", "ref.rawlog_Images"),
        ("ref.rawlog.gz", "ref.rawlog_Images"),
        ("ref", "ref_Images"),
        ("ref.log", "ref.log_Images"),
        (".rawlog", "_Images"),
    ],
)
def test_the_name_of_the_folder_is_that_of_the_rawlog_without_any_extension(
    rawlog: str, name: str, tmp_path: Path
) -> None:
    (tmp_path / "Images").mkdir()
    (tmp_path / name).mkdir()
    assert Folder(tmp_path / rawlog).path == tmp_path / name


def test_a_missing_folder_is_told_by_the_name_that_mrpt_looks_for(tmp_path: Path) -> None:
    with pytest.raises(MissingInputError, match="no folder 'ref_Images'"):
        Folder(tmp_path / "ref.log").read("x.png")


def test_the_first_name_wins(tmp_path: Path) -> None:
    for name in ("Images", "a_Images", "a.log_Images"):
        (tmp_path / name).mkdir()
    assert Folder(tmp_path / "a.log").path == tmp_path / "a_Images"
    assert Folder(tmp_path / "a.rawlog").path == tmp_path / "a_Images"


@pytest.mark.parametrize(
    "name",
    [
        "/etc/passwd",
        "../secret",
        "a/../../secret",
        "..\\secret",
        "C:\\x",
        "C:/x",
        "\\\\host\\x",
        "..",
    ],
)
def test_names_that_lead_outside_are_refused(name: str, folder: Folder) -> None:
    with pytest.raises(InputError, match="leads out of the folder"):
        folder.read(name)


@pytest.mark.parametrize("name", ["", "a\0b"])
def test_what_can_be_no_name_is_refused(name: str, folder: Folder) -> None:
    with pytest.raises(InputError, match="is the name of no file"):
        folder.read(name)


def test_what_is_missing_is_named(folder: Folder, tmp_path: Path) -> None:
    with pytest.raises(MissingInputError, match=r"a_Images/x\.png"):
        folder.read("x.png")
    assert folder.size("x.png") is None
    with pytest.raises(MissingInputError, match="no folder 'b_Images'"):
        Folder(tmp_path / "b.rawlog").read("x.png")


@pytest.mark.parametrize("container", CONTAINERS)
@pytest.mark.parametrize("name", [b"\x87CMatrix", b"\x88CMatrixF", b"\x94mrpt::math::CMatrixF"])
def test_depth_is_counts_or_metres_whatever_the_version_says(
    container: str, name: bytes, folder: Folder
) -> None:
    assert folder.path is not None
    matrix = metres_payload(METRES).replace(b"\x87CMatrix", name)
    for payload, expected in ((depth_payload(COUNTS), COUNTS), (matrix, METRES)):
        (folder.path / "d.bin").write_bytes(deflate(payload, container))  # type: ignore[arg-type]
        found = read_depth(folder, "d.bin")
        assert found.dtype == expected.dtype
        np.testing.assert_array_equal(found, expected)


def test_an_image_of_as_many_rows_as_a_name_has_letters_is_no_matrix(folder: Folder) -> None:
    assert folder.path is not None
    counts = np.arange(0x87 * 4, dtype=np.uint16).reshape(0x87, 4)
    (folder.path / "d.bin").write_bytes(depth_payload(counts))
    np.testing.assert_array_equal(read_depth(folder, "d.bin"), counts)


def test_text_depth(folder: Folder) -> None:
    assert folder.path is not None
    np.savetxt(folder.path / "counts.txt", COUNTS, "%.16f")
    np.savetxt(folder.path / "metres.txt", METRES, "%.16f")
    np.testing.assert_array_equal(read_depth(folder, "counts.txt"), COUNTS)
    np.testing.assert_array_equal(read_depth(folder, "metres.txt"), METRES)
    (folder.path / "bad.txt").write_text("1 2\n3\n")
    with pytest.raises(InputError, match=r"bad\.txt, row 1: the depth file is no text matrix"):
        read_depth(folder, "bad.txt")


@pytest.mark.parametrize(
    "payload",
    [
        b"",
        depth_payload(COUNTS)[:-1],
        depth_payload(COUNTS) + b"x",
        metres_payload(METRES)[:-1],
        metres_payload(METRES)[:12],
        b"\x87CMatrix",
        b"\xff" * 100,
        struct.pack("<II", 2**32 - 1, 2**32 - 1) + bytes(8),
        b"\x87CMatrix\0" + struct.pack("<II", 2**32 - 1, 2**32 - 1) + bytes(8),
    ],
)
def test_depth_files_of_the_wrong_size_are_refused(payload: bytes, folder: Folder) -> None:
    assert folder.path is not None
    (folder.path / "d.bin").write_bytes(payload)
    with pytest.raises(InputError, match=r"d\.bin"):
        read_depth(folder, "d.bin")
