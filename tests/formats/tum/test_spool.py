# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A compressed archive is inflated once to a file without a name, where there is room for that.

That it is read rightly, whatever the order of members or the damage, is in test_archives.py.
"""

from __future__ import annotations

import errno
import gzip
import os
import shutil
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import pytest

from tests.formats.tum.archives import file, pack, tar
from tumtools.cli.main import run
from tumtools.digest import digest
from tumtools.formats.options import ReadOptions
from tumtools.formats.tum import spool
from tumtools.formats.tum.reader import TumSequence
from tumtools.formats.tum.spool import NoRoomError, SpooledStream
from tumtools.sources import open_source

if TYPE_CHECKING:
    from collections.abc import Callable

FULL = Path(__file__).parents[3] / "fixtures" / "full"


@pytest.fixture
def scratch(tmp_path: Path) -> Path:
    folder = tmp_path / "scratch"
    folder.mkdir()
    return folder


def _open(path: Path, scratch: Path) -> TumSequence:
    sequence = open_source(path, ReadOptions(scratch=scratch))
    assert isinstance(sequence, TumSequence)
    return sequence


def test_nothing_with_a_name_is_in_the_folder_at_any_time(tmp_path: Path, scratch: Path) -> None:
    with _open(pack(FULL, tmp_path / "x.tgz", "random"), scratch) as sequence:
        assert not sequence._storage.sequential  # it is spooled
        assert not list(scratch.iterdir())
        next(sequence.images())
        assert not list(scratch.iterdir())


def _full_disk(descriptor: int, block: bytes) -> NoReturn:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


NO_ROOM: dict[str, Callable[[pytest.MonkeyPatch, Path], None]] = {
    "little room": lambda monkeypatch, _: monkeypatch.setattr(
        shutil, "disk_usage", lambda _: shutil._ntuple_diskusage(10**6, 10**6 - 1000, 1000)
    ),
    "a disk that becomes full": lambda monkeypatch, _: monkeypatch.setattr(spool, "_write", _full_disk),
    "a folder that is not there": lambda _, scratch: scratch.rmdir(),
}


@pytest.mark.parametrize("harm", NO_ROOM)
def test_without_room_the_archive_is_read_all_the_same(
    tmp_path: Path, scratch: Path, monkeypatch: pytest.MonkeyPatch, harm: str
) -> None:
    path = pack(FULL, tmp_path / "x.tgz", "random")
    with open_source(FULL) as folder:
        NO_ROOM[harm](monkeypatch, scratch)
        with _open(path, scratch) as sequence:
            assert sequence._storage.sequential
            assert digest(sequence) == digest(folder)


def test_what_inflates_out_of_all_proportion_does_not_fill_the_disk(
    tmp_path: Path, scratch: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(spool, "_ALLOWANCE", 1 << 20)
    path = tmp_path / "x.tgz"
    path.write_bytes(gzip.compress(tar([file("seq/rgb.txt"), file("seq/zeros", bytes(1 << 22))])))
    stream = SpooledStream(path, scratch)
    with pytest.raises(NoRoomError):
        stream.skip_scan(1 << 22)
    stream.close()
    with _open(path, scratch) as sequence:
        assert sequence._storage.sequential


def test_a_conversion_has_the_same_bytes_from_the_folder_and_from_archives(tmp_path: Path) -> None:
    names = {"folder": FULL}
    for suffix in (".tgz", ".tar", ".tar.zst", ".zip"):
        for order in ("alphabetical", "random"):
            names[order + suffix] = pack(FULL, tmp_path / f"{order}{suffix}", order)
    results = set()
    for name, source in names.items():
        target = tmp_path / "out" / f"{name}.mcap"
        assert run(["convert", str(source), str(target), "--to", "mcap", "--archive"]) == 0
        results.add(target.read_bytes())
    assert len(results) == 1
    assert len(list((tmp_path / "out").iterdir())) == len(names)
