# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A file that has its final name is complete; nothing else is left."""

from __future__ import annotations

import errno
import fcntl
import os
import socket
import threading
from pathlib import Path

import pytest

from tumtools import staging
from tumtools.errors import MissingInputError, OutputError, UsageError
from tumtools.staging import staged, staged_file


def _names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def _stale(target: Path, *, lock: bool = True) -> Path:
    folder = target.parent / f".{target.name}.tumtools-killed"
    folder.mkdir()
    (folder / target.name).write_text("half")
    if lock:
        (folder / staging._LOCK).touch()
    return folder


def test_a_file_appears_when_the_block_ends_well(tmp_path: Path) -> None:
    target = tmp_path / "deep" / "x.mcap"
    with staged(target) as path:
        assert path.name == target.name
        assert not target.exists()
        path.write_text("whole")
        assert not target.exists()
    assert target.read_text() == "whole"
    assert _names(target.parent) == ["x.mcap"]


def test_a_folder_appears_with_all_that_is_in_it(tmp_path: Path) -> None:
    with staged(tmp_path / "x") as path:
        (path / "a" / "b").mkdir(parents=True)
        (path / "a" / "b" / "c").write_text("whole")
    assert (tmp_path / "x" / "a" / "b" / "c").read_text() == "whole"
    assert _names(tmp_path) == ["x"]


@pytest.mark.parametrize("error", [RuntimeError("x"), KeyboardInterrupt(), MissingInputError("x")])
def test_nothing_is_left_when_the_block_fails(tmp_path: Path, error: BaseException) -> None:
    with pytest.raises(type(error)), staged(tmp_path / "x") as path:
        path.write_text("half")
        raise error
    assert _names(tmp_path) == []


def test_what_the_system_refuses_is_said_in_words(tmp_path: Path) -> None:
    with (
        pytest.raises(OutputError, match="cannot write: No space left on device") as caught,
        staged(tmp_path / "x") as path,
    ):
        path.write_text("half")
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    assert caught.value.path == str(tmp_path / "x")
    assert "free some space" in str(caught.value.hint)
    assert _names(tmp_path) == []


def test_an_input_that_is_missing_is_not_taken_for_the_output(tmp_path: Path) -> None:
    with pytest.raises(MissingInputError), staged(tmp_path / "x"):
        raise MissingInputError("gone", path="source")


def test_a_parent_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match="cannot write"), staged(tmp_path / "file" / "x"):
        pass


@pytest.mark.parametrize("kind", ["file", "folder", "link to nowhere"])
def test_what_exists_is_not_touched_without_force(tmp_path: Path, kind: str) -> None:
    target = tmp_path / "x"
    {
        "file": target.touch,
        "folder": target.mkdir,
        "link to nowhere": lambda: target.symlink_to("nowhere"),
    }[kind]()
    with pytest.raises(UsageError, match="the target exists"), staged(target):
        raise AssertionError
    assert _names(tmp_path) == ["x"]


def test_a_target_that_appears_in_the_meantime_is_not_replaced(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="the target exists"), staged(tmp_path / "x") as path:
        path.write_text("late")
        (tmp_path / "x").write_text("early")
    assert (tmp_path / "x").read_text() == "early"
    assert _names(tmp_path) == ["x"]


@pytest.mark.parametrize("old", ["file", "folder", "link"])
@pytest.mark.parametrize("new", ["file", "folder"])
def test_force_replaces_whatever_is_there(tmp_path: Path, old: str, new: str) -> None:
    target, elsewhere = tmp_path / "x", tmp_path / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "kept").touch()
    if old == "file":
        target.write_text("old")
    elif old == "folder":
        (target / "sub").mkdir(parents=True)
    else:
        target.symlink_to(elsewhere)
    with staged(target, force=True) as path:
        if new == "file":
            path.write_text("new")
        else:
            path.mkdir()
            (path / "new").touch()
    assert target.is_file() if new == "file" else _names(target) == ["new"]
    assert not target.is_symlink()
    assert _names(tmp_path) == ["elsewhere", "x"]
    assert _names(elsewhere) == ["kept"]


@pytest.mark.parametrize("force", [True, False])
@pytest.mark.parametrize("kind", ["pipe", "socket", "device", "link to a device"])
def test_a_pipe_or_device_is_never_replaced(tmp_path: Path, kind: str, force: bool) -> None:
    target = tmp_path / "x"
    if kind == "pipe":
        os.mkfifo(target)
    elif kind == "socket":
        with socket.socket(socket.AF_UNIX) as server:
            server.bind(str(target))
    elif kind == "link to a device":
        target.symlink_to(os.devnull)
    else:
        target = Path(os.devnull)
    before = target.lstat()
    with pytest.raises(UsageError, match="neither a file nor a folder"), staged(target, force=force):
        raise AssertionError
    assert target.lstat() == before
    assert _names(tmp_path) == ([] if kind == "device" else ["x"])


def test_force_keeps_the_old_one_when_the_block_fails(tmp_path: Path) -> None:
    (tmp_path / "x").write_text("old")
    with pytest.raises(RuntimeError), staged(tmp_path / "x", force=True) as path:
        path.write_text("half")
        raise RuntimeError
    assert (tmp_path / "x").read_text() == "old"
    assert _names(tmp_path) == ["x"]


@pytest.mark.parametrize("lock", [True, False])
def test_what_a_killed_process_left_is_removed_by_the_next(tmp_path: Path, lock: bool) -> None:
    _stale(tmp_path / "x", lock=lock)
    other = _stale(tmp_path / "y")
    with staged(tmp_path / "x") as path:
        path.touch()
    assert _names(tmp_path) == [other.name, "x"]


def test_the_staging_folder_of_a_living_process_stays(tmp_path: Path) -> None:
    folder = _stale(tmp_path / "x")
    with (folder / staging._LOCK).open("r+") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        with staged(tmp_path / "x") as path:
            path.touch()
    assert _names(tmp_path) == [folder.name, "x"]


def test_a_folder_that_is_removed_before_it_is_locked_is_made_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    flock = staging.fcntl.flock
    removed = []

    def flock_late(file: object, operation: int) -> None:
        if not removed:
            # Another process finds the folder without a locked file and takes it for stale.
            (folder,) = tmp_path.iterdir()
            removed.append(folder)
            staging.shutil.rmtree(folder)
        flock(file, operation)

    monkeypatch.setattr(staging.fcntl, "flock", flock_late)
    with staged(tmp_path / "x") as path:
        path.write_text("whole")
    assert len(removed) == 1
    assert _names(tmp_path) == ["x"]


def test_many_writers_of_one_target_leave_one_whole_result(tmp_path: Path) -> None:
    errors: list[BaseException] = []

    def write(number: int) -> None:
        try:
            with staged(tmp_path / "x", force=True) as path:
                path.write_text(str(number) * 1000)
        except BaseException as error:  # noqa: BLE001 - reported below
            errors.append(error)

    threads = [threading.Thread(target=write, args=(number,)) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert errors == []
    assert len(set((tmp_path / "x").read_text())) == 1
    assert _names(tmp_path) == ["x"]


@pytest.mark.parametrize("name", ["lock", "old", "x" * 200])
def test_any_name_will_do(tmp_path: Path, name: str) -> None:
    for content in ("first", "second"):
        with staged(tmp_path / name, force=True) as path:
            path.mkdir()
            (path / content).touch()
    assert _names(tmp_path) == [name]
    assert _names(tmp_path / name) == ["second"]


def test_an_interrupt_while_a_folder_is_replaced_keeps_the_old_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "x" / "old").mkdir(parents=True)
    rename = Path.rename

    def interrupted(self: Path, target: Path) -> Path:
        if target == tmp_path / "x" and self.name == "x":
            raise KeyboardInterrupt
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", interrupted)
    with pytest.raises(KeyboardInterrupt), staged(tmp_path / "x", force=True) as path:
        path.mkdir()
    assert _names(tmp_path / "x") == ["old"]


def test_a_folder_is_not_replaced_by_a_file(tmp_path: Path) -> None:
    (tmp_path / "x" / "y").mkdir(parents=True)
    with pytest.raises(UsageError, match="this is a folder"), staged_file(tmp_path / "x", force=True) as path:
        path.write_text("whole")
    assert (tmp_path / "x" / "y").is_dir()
    (tmp_path / "x" / "y").rmdir()
    (tmp_path / "x").rmdir()
    with pytest.raises(UsageError, match="this is a folder"), staged_file(tmp_path / "x", force=True) as path:
        path.write_text("whole")
        (tmp_path / "x").mkdir()  # by somebody else, meanwhile
    assert (tmp_path / "x").is_dir()
    assert _names(tmp_path) == ["x"]


def test_a_file_where_a_folder_is_needed_is_named(tmp_path: Path) -> None:
    (tmp_path / "a").touch()
    for target in (tmp_path / "a" / "x", tmp_path / "a" / "b" / "x"):
        with pytest.raises(OutputError, match="this is no folder") as caught, staged(target) as path:
            path.touch()
        assert caught.value.path == str(tmp_path / "a")
