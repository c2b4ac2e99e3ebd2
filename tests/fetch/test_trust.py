# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Checksums that nobody publishes are trusted once, noted in a lock file, and demanded from then on."""

from __future__ import annotations

import json
import resource
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import pytest

from tests.fetch.conftest import ARCHIVE, Place, make_tar, sequence_files, sha256
from tumtools.errors import FetchError, InputError, IntegrityError, OutputError
from tumtools.fetch.lockfile import LockFile, Pin, find_lock

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

OTHER = make_tar(sequence_files(500_000))


def lock(place: Place) -> dict[str, Any]:
    document: dict[str, Any] = json.loads((place.folder / "tumtools.lock").read_text())
    return document


def test_the_first_use_is_noted(place: Place) -> None:
    place.serve()
    fetched = place.fetch()
    assert fetched.trust == "first use"
    assert lock(place) == {
        "schema_version": 1,
        "files": {
            "rgbd_dataset_mini.tgz": {
                "name": "rgbd_dataset_mini",
                "url": place.server.url("/f/mini.tgz"),
                "bytes": len(ARCHIVE),
                "sha256": sha256(ARCHIVE),
                "last_modified": "2011-09-30T15:14:33Z",
            }
        },
    }
    assert any("tumtools.lock" in note for note in fetched.notes)


def test_a_known_checksum_needs_no_lock(place: Place) -> None:
    place.serve()
    assert place.fetch(place.entry(sha256=sha256(ARCHIVE), standing="confirmed")).trust == "confirmed"
    assert not (place.folder / "tumtools.lock").exists()


def test_from_then_on_another_file_is_refused_and_nothing_replaced(place: Place) -> None:
    place.serve()
    place.fetch()
    before = lock(place)
    place.serve(OTHER)
    with pytest.raises(IntegrityError, match=r"bytes, .*tumtools\.lock has") as caught:
        place.fetch(dest=place.folder / "other")
    assert caught.value.exit_code == 5
    assert lock(place) == before
    assert not (place.folder / "other" / "rgbd_dataset_mini").exists()
    place.serve()
    assert place.fetch(dest=place.folder / "other").trust == "lock"


def test_a_lock_that_comes_with_a_repository_is_demanded_of_what_is_there(place: Place) -> None:
    place.serve()
    place.fetch()
    document = lock(place)
    document["files"]["rgbd_dataset_mini.tgz"]["sha256"] = "0" * 64
    (place.folder / "tumtools.lock").write_text(json.dumps(document))
    with pytest.raises(IntegrityError, match="what is here is not what is known: its sha256 is"):
        place.fetch()
    assert (place.cache / "rgbd_dataset_mini" / "rgb.txt").is_file()


def test_a_lock_that_contradicts_the_catalogue_ends_it(place: Place) -> None:
    place.serve()
    LockFile(place.folder / "tumtools.lock").add(
        "rgbd_dataset_mini.tgz", Pin("rgbd_dataset_mini", "u", len(ARCHIVE), "0" * 64)
    )
    with pytest.raises(IntegrityError, match=r"tumtools\.lock has 0000"):
        place.fetch(place.entry(sha256=sha256(ARCHIVE)))


def test_a_damaged_lock_is_not_ignored(place: Place) -> None:
    place.serve()
    (place.folder / "tumtools.lock").write_text("{")
    with pytest.raises(InputError, match="cannot be read") as caught:
        place.fetch()
    assert "version control" in str(caught.value.hint)
    assert place.server.requests == []


def test_the_nearest_lock_above_is_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("TUMTOOLS_LOCK", raising=False)
    deep = tmp_path / "a" / "b"
    deep.mkdir(parents=True)
    assert find_lock(deep) == deep / "tumtools.lock"
    (tmp_path / "tumtools.lock").write_text("")
    assert find_lock(deep) == tmp_path / "tumtools.lock"
    monkeypatch.setenv("TUMTOOLS_LOCK", "/elsewhere/x.lock")
    assert str(find_lock(deep)) == "/elsewhere/x.lock"


def test_pins_are_sorted_and_kept(tmp_path: Path) -> None:
    locks = LockFile(tmp_path / "x.lock")
    for name in "cab":
        locks.add(f"{name}.tgz", Pin(name, "http://h/p", 1, "0" * 64))
    assert list(json.loads(locks.path.read_text())["files"]) == ["a.tgz", "b.tgz", "c.tgz"]


def test_a_pin_is_never_replaced(tmp_path: Path) -> None:
    locks = LockFile(tmp_path / "x.lock")
    locks.add("a.tgz", Pin("a", "http://h/p", 1, "0" * 64))
    before = locks.path.read_bytes()
    with pytest.raises(IntegrityError, match="was noted with sha256 0000"):
        locks.add("a.tgz", Pin("a", "http://h/p", 1, "1" * 64))
    assert locks.path.read_bytes() == before


def test_offline_takes_what_is_there_and_nothing_else(place: Place) -> None:
    with pytest.raises(FetchError, match="--offline forbids to download it"):
        place.fetch(offline=True)
    place.serve()
    place.fetch()
    place.server.requests.clear()
    assert place.fetch(offline=True).downloaded == 0
    assert place.server.requests == []


def test_no_extract_keeps_the_archive_and_a_later_fetch_unpacks_it(place: Place) -> None:
    place.serve()
    fetched = place.fetch(unpack=False)
    assert fetched.path == place.cache / "rgbd_dataset_mini.tgz"
    assert fetched.path.read_bytes() == ARCHIVE
    assert not (place.cache / "rgbd_dataset_mini").exists()
    again = place.fetch(offline=True)
    assert (again.path / "rgb.txt").is_file()
    assert fetched.path.is_file()
    assert len(place.server.requests) == 1


def test_keep_archive_keeps_both(place: Place) -> None:
    place.serve()
    fetched = place.fetch(keep_archive=True)
    assert (fetched.path / "rgb.txt").is_file()
    assert (place.cache / "rgbd_dataset_mini.tgz").read_bytes() == ARCHIVE


def test_an_archive_that_the_user_put_there_is_checked_and_used(place: Place) -> None:
    place.cache.mkdir()
    mine = place.cache / "rgbd_dataset_mini.tgz"
    mine.write_bytes(OTHER)
    with pytest.raises(IntegrityError, match="what is here is not what is known"):
        place.fetch(place.entry(sha256=sha256(ARCHIVE)))
    assert mine.read_bytes() == OTHER
    mine.write_bytes(ARCHIVE)
    assert (place.fetch(place.entry(sha256=sha256(ARCHIVE))).path / "rgb.txt").is_file()
    assert place.server.requests == []


def test_a_folder_that_is_not_ours_is_left_alone(place: Place) -> None:
    place.serve()
    (place.cache / "rgbd_dataset_mini").mkdir(parents=True)
    with pytest.raises(OutputError, match="is in the way: it was not fetched by tumtools"):
        place.fetch()
    assert place.server.requests == []


def test_a_folder_of_a_destination_remembers_what_it_has(place: Place) -> None:
    place.serve()
    destination = place.folder / "data"
    assert place.fetch(dest=destination).path == destination / "rgbd_dataset_mini"
    assert place.fetch(dest=destination).downloaded == 0
    assert len(place.server.requests) == 1
    assert not place.cache.exists()


def test_a_recording_is_no_archive(place: Place) -> None:
    bag = b"#ROSBAG V2.0\n" + bytes(5000)
    place.serve(bag, "/f/mini.bag")
    fetched = place.fetch(place.entry(kind="bag"))
    assert fetched.path == place.cache / "rgbd_dataset_mini.bag"
    assert fetched.path.read_bytes() == bag
    place.serve(b"#ROSBAG V1.2\n" + bytes(5000), "/f/mini.bag")
    with pytest.raises(IntegrityError, match="is not a ROS 1 bag"):
        place.fetch(place.entry(kind="bag"), dest=place.folder / "other")


def test_a_full_disk_keeps_what_has_come(place: Place) -> None:
    place.serve()
    with (
        file_size_limit(300_000),
        pytest.raises(OutputError, match="cannot be written: File") as caught,
    ):
        place.fetch()
    assert "what is there is kept" in str(caught.value.hint)
    assert next(place.cache.glob("*.part")).stat().st_size == 300_000
    assert place.nothing_in_place()
    place.fetch()
    assert place.server.starts == [None, 300_000]


def test_a_disk_that_is_full_while_unpacking_keeps_the_download(place: Place) -> None:
    place.serve(make_tar({**sequence_files(1000), "rgbd_dataset_mini/zeros.bin": bytes(1_000_000)}))
    with (
        file_size_limit(300_000),
        pytest.raises(OutputError, match="cannot be unpacked: File") as caught,
    ):
        place.fetch()
    assert "zeros.bin" in str(caught.value.location)
    assert place.nothing_in_place()
    place.fetch()
    assert len(place.server.requests) == 1


@contextmanager
def file_size_limit(size: int) -> Iterator[None]:
    """Writing beyond `size` fails, as it does on a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
