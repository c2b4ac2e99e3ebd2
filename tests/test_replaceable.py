# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`--force` replaces older results, and nothing that somebody else has put there."""

from __future__ import annotations

from pathlib import Path

import pytest

from tumtools.convert import ConvertOptions, convert
from tumtools.errors import UsageError
from tumtools.formats.options import WriteOptions
from tumtools.sources import open_source

FULL = Path(__file__).parents[1] / "fixtures" / "full"
FORCE = ConvertOptions(force=True, verify=False)
FOLDERS = [
    ("tum", WriteOptions()),
    ("rosbag2", WriteOptions()),
    ("rosbag2", WriteOptions(storage="mcap")),
    ("rawlog", WriteOptions()),
    ("rawlog", WriteOptions(dialect="converter")),
]


def _convert(target: Path, to: str, options: WriteOptions | None = None) -> None:
    with open_source(FULL) as sequence:
        convert(sequence, target, to, options, FORCE)


@pytest.mark.parametrize(("to", "options"), FOLDERS)
def test_an_older_result_is_replaced(tmp_path: Path, to: str, options: WriteOptions) -> None:
    target = tmp_path / "x"
    _convert(target, to, options)
    for other, settings in (*FOLDERS, (to, options)):
        _convert(target, other, settings)
    assert [path.name for path in tmp_path.iterdir()] == ["x"]


@pytest.mark.parametrize(
    "name", ["my_thesis.tex", "sub/deep/er/and/deeper", ".hidden", "a.mcap", "x_Images/b.png"]
)
@pytest.mark.parametrize(("to", "options"), FOLDERS)
def test_a_folder_with_a_file_of_somebody_else_is_not(
    tmp_path: Path, to: str, options: WriteOptions, name: str
) -> None:
    target = tmp_path / "x"
    _convert(target, to, options)
    foreign = target / name
    foreign.parent.mkdir(parents=True, exist_ok=True)
    foreign.write_text("years of work")
    for other in ("tum", "rosbag2", "rawlog"):
        with pytest.raises(UsageError, match=f"holds {name}, which is no part of its sequence") as caught:
            _convert(target, other)
        assert caught.value.path == str(target)
    assert foreign.read_text() == "years of work"


@pytest.mark.parametrize("to", ["tum", "rosbag2", "rawlog"])
def test_a_link_in_the_folder_is_somebody_elses_too(tmp_path: Path, to: str) -> None:
    _convert(tmp_path / "x", to)
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "x" / "link").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(UsageError, match="holds link, which"):
        _convert(tmp_path / "x", to)


@pytest.mark.parametrize(("name", "to"), [("x.mcap", "mcap"), ("x.bag", "rosbag1"), ("x.tgz", "tum")])
@pytest.mark.parametrize("holds", ["nothing", "a sequence"])
def test_a_folder_is_not_replaced_by_a_file(tmp_path: Path, name: str, to: str, holds: str) -> None:
    target = tmp_path / name
    target.mkdir()
    if holds == "a sequence":
        (target / "rgb.txt").write_text("")
    with pytest.raises(UsageError, match="is a folder, and a file is to be written"):
        _convert(target, to)
    assert target.is_dir()


@pytest.mark.parametrize("to", ["tum", "rosbag2", "rawlog"])
def test_a_file_is_not_replaced_by_a_folder(tmp_path: Path, to: str) -> None:
    target = tmp_path / "x"
    target.write_text("years of work")
    with pytest.raises(UsageError, match="is a file, and a folder is to be written"):
        _convert(target, to)
    assert target.read_text() == "years of work"


def test_a_damaged_folder_is_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "x").mkdir()
    (tmp_path / "x" / "metadata.yaml").write_text("years: of work")
    with pytest.raises(UsageError, match="holds no sequence, or a damaged one"):
        _convert(tmp_path / "x", "rosbag2")
