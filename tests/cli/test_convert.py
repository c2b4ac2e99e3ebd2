# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools convert`: its options, its exit codes and its report."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.formats.rawlog.made import TICKS, save, scan, with_depth
from tests.formats.tum.archives import files_of
from tumtools.cli.main import run
from tumtools.sources import open_source

COUNTS = np.arange(1, 49, dtype="<u2").reshape(6, 8)
FULL = Path(__file__).parents[2] / "fixtures" / "full"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return shutil.copytree(FULL, tmp_path / "in" / "full")


def _stamps(path: Path) -> list[int]:
    with open_source(path) as sequence:
        return sequence.image_stamps("rgb").tolist()


@pytest.mark.parametrize("name", ["mcap", "rosbag1", "rosbag2", "rawlog"])
def test_a_salvage_of_a_cut_recording_is_not_lossless(
    name: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = folder.parent / {"mcap": "x.mcap", "rosbag1": "x.bag"}.get(name, "x")
    out = folder.parent / "out"
    assert run(["convert", str(folder), str(path), "--to", name]) == 0
    assert run(["convert", str(path), str(out), "--to", "tum", "--salvage", "--strict"]) == 0
    shutil.rmtree(out)
    (file,) = [path] if path.is_file() else (*path.glob("*.db3"), *path.glob("*.rawlog"))
    file.write_bytes(file.read_bytes()[: file.stat().st_size * 6 // 10])
    for more in ([], ["--dry-run"]):
        assert run(["convert", str(path), str(out), "--to", "tum", "--salvage", "--strict", *more]) == 3
    assert not out.exists()
    capsys.readouterr()
    assert run(["convert", str(path), str(out), "--to", "tum", "--salvage", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["lossless"] is False
    assert sum(loss["count"] for loss in document["losses"]) > 0


def test_the_report_as_json(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "notes.md").write_text("hello")
    target = folder.parent / "full.mcap"
    assert run(["convert", str(folder), "--to", "mcap", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["target"] == str(target)
    assert document["bytes"] == target.stat().st_size
    assert (document["frames"], document["verified"], document["lossless"]) == (8, True, False)
    assert document["losses"][0] | {"stream": "notes.md", "count": 1} == document["losses"][0]


def test_the_report_for_people(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["convert", str(folder), "--to", "mcap"]) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    assert "8 images" in captured.out
    assert captured.out.endswith("nothing lost\n")


def test_losses_are_a_table_on_stdout(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["convert", str(folder), "--to", "mcap", "--depth-encoding", "16UC1"]) == 0
    out = capsys.readouterr().out
    assert "\nlost:\n" in out
    assert "0.0004 m" in out


def test_a_dry_run_tells_on_stdout_and_writes_nothing(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = files_of(folder.parent)
    assert run(["convert", str(folder), "--to", "mcap", "--dry-run"]) == 0
    out = capsys.readouterr().out
    assert out.startswith(f"would write {folder}.mcap: 8 images")
    assert "about" in out
    assert files_of(folder.parent) == before
    assert run(["convert", str(folder), "--to", "mcap", "--dry-run", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["bytes_estimated"] is True


def test_what_was_left_out_as_asked_is_named(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for number, (options, left_out) in enumerate(
        [
            (["--groundtruth", "none"], ["groundtruth"]),
            (["--streams", "rgb,depth,accelerometer"], ["groundtruth"]),
            (["--streams", "rgb", "--groundtruth", "none"], ["depth", "accelerometer", "groundtruth"]),
        ]
    ):
        target = str(folder.parent / f"{number}.mcap")
        assert run(["convert", str(folder), target, "--to", "mcap", *options]) == 0
        lines = capsys.readouterr().out.splitlines()
        assert lines[1:] == [f"left out as asked: {', '.join(left_out)}", "nothing else lost"]
        assert run(["convert", str(folder), target, "--to", "mcap", *options, "--force", "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["left_out"] == left_out


def test_images_and_rows_that_were_left_out_as_asked_are_counted(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = [
        "convert",
        str(folder),
        "--to",
        "mcap",
        "--every",
        "2",
        "--streams",
        "rgb,depth,accelerometer",
    ]
    assert run(arguments) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[1:] == ["left out as asked: groundtruth, 4 images", "nothing else lost"]
    assert run([*arguments, "--force", "--json", "--end", "0.1"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["left_out"], document["left_out_frames"]) == (["groundtruth"], 4)
    assert document["left_out_rows"] + document["rows"] == 567


def test_the_warnings_of_the_source_are_part_of_the_report(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "accelerometer.txt").rename(folder / "imu.txt")
    assert run(["convert", str(folder), "--to", "mcap", "--json"]) == 0
    assert "taken for accelerometer.txt" in json.loads(capsys.readouterr().out)["warnings"][0]


def test_a_missing_image_is_told_once(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    min((folder / "rgb").iterdir()).unlink()
    assert run(["convert", str(folder), "--to", "mcap"]) == 4
    captured = capsys.readouterr()
    assert captured.err.count("there is no image") == 1
    assert captured.err.startswith("error: ")


def test_a_topic_or_frame_for_a_stream_that_is_not_there_is_warned_of(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["convert", str(folder), "--to", "mcap", "--streams", "rgb", "--topic", "rgb=/my/camera"]
    assert run([*arguments, "--topic", "ir=/x", "--frame-id", "depth=lens"]) == 0
    err = capsys.readouterr().err
    assert "--topic ir=/x has no effect: there is no ir to write" in err
    assert "--frame-id depth=lens has no effect" in err
    assert "/my/camera" not in err


def test_an_empty_topic_is_the_sensor_of_a_rawlog_without_a_label_and_nothing_else(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    parent = folder.parent
    path = save(parent / "x.rawlog", *(scan(TICKS + n, "R" * n, **with_depth(COUNTS)) for n in range(2)))
    assert run(["convert", str(path), str(parent / "out"), "--to", "tum", "--topic", "depth="]) == 0
    assert run(["convert", str(folder), str(parent / "x.mcap"), "--to", "mcap"]) == 0
    capsys.readouterr()
    assert run(["convert", str(parent / "x.mcap"), str(parent / "2"), "--to", "tum", "--topic", "rgb="]) == 2
    assert "--topic rgb=: no such topic" in capsys.readouterr().err
    assert run(["convert", str(folder), str(parent / "2.mcap"), "--to", "mcap", "--topic", "rgb="]) == 2
    assert "--topic rgb=: a topic cannot have an empty name" in capsys.readouterr().err
    assert run(["convert", str(folder), str(parent / "2.mcap"), "--to", "mcap", "--frame-id", "rgb="]) == 2
    assert "expected STREAM=VALUE" in capsys.readouterr().err


def test_a_link_has_its_result_beside_it(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    here = folder.parent / "here"
    here.mkdir()
    (here / "link").symlink_to(folder)
    monkeypatch.chdir(here)
    for source in ("link", "link/.", "link/"):
        assert run(["convert", source, "--to", "mcap", "--force"]) == 0
        assert (here / "link.mcap").is_file()
        assert not folder.with_suffix(".mcap").exists()


def test_strict_is_exit_3(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "notes.md").write_text("hello")
    for more in ([], ["--dry-run"]):
        assert run(["convert", str(folder), "--to", "mcap", "--strict", *more]) == 3
        assert "notes.md" in capsys.readouterr().err
    assert not folder.with_suffix(".mcap").exists()


def test_an_existing_target_is_exit_2_and_force_replaces_it(folder: Path) -> None:
    target = folder.parent / "x.mcap"
    target.touch()
    assert run(["convert", str(folder), str(target), "--to", "mcap"]) == 2
    assert target.stat().st_size == 0
    assert run(["convert", str(folder), str(target), "--to", "mcap", "--force"]) == 0
    assert target.stat().st_size > 0


@pytest.mark.parametrize("target", [".", "full"])
def test_the_source_is_never_replaced(folder: Path, target: str, capsys: pytest.CaptureFixture[str]) -> None:
    before = files_of(folder)
    arguments = [
        "convert",
        str(folder),
        str(folder.parent / target),
        "--to",
        "tum",
        "--force",
        "--every",
        "2",
    ]
    assert run(arguments) == 2
    assert "name another one" in capsys.readouterr().err
    assert files_of(folder) == before


def test_a_damaged_source_is_exit_4(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = min((folder / "depth").iterdir())
    path.write_bytes(path.read_bytes()[:-1])
    assert run(["convert", str(folder), "--to", "mcap"]) == 4
    assert str(path) in capsys.readouterr().err
    assert not folder.with_suffix(".mcap").exists()


def test_the_current_folder_is_the_source_unless_told(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    assert run(["convert", "--to", "mcap"]) == 0
    assert folder.with_suffix(".mcap").exists()


@pytest.mark.parametrize(
    ("options", "rows"),
    [
        (["--every", "2"], [0, 2]),
        (["--start", "0.02"], [1, 2, 3]),
        (["--start", "0.02", "--end", "0.08"], [1, 2]),
        (["--end", "0"], [0]),
        (["--start", "{2}"], [2, 3]),
        (["--start", "{1}", "--end", "{2}"], [1, 2]),
        (["--streams", "rgb, groundtruth"], [0, 1, 2, 3]),
    ],
)
def test_a_part_is_chosen_by_time_and_number(
    folder: Path, tmp_path: Path, options: list[str], rows: list[int]
) -> None:
    stamps = _stamps(folder)
    texts = [f"{stamp // 10**9}.{stamp % 10**9:09d}" for stamp in stamps]
    target = tmp_path / "x.mcap"
    options = [option.format(*texts) for option in options]
    assert run(["convert", str(folder), str(target), "--to", "mcap", *options]) == 0
    assert _stamps(target) == [stamps[row] for row in rows]


def test_a_clock_that_starts_near_zero_is_counted_from_the_first_stamp(tmp_path: Path) -> None:
    source = tmp_path / "simulated"
    shutil.copytree(FULL / "rgb", source / "rgb")
    names = sorted(path.name for path in (source / "rgb").iterdir())
    (source / "rgb.txt").write_text("".join(f"{10 + n}.0 rgb/{name}\n" for n, name in enumerate(names)))
    assert run(["convert", str(source), "--to", "mcap", "--start", "2"]) == 0
    assert _stamps(tmp_path / "simulated.mcap") == [12 * 10**9, 13 * 10**9]


@pytest.mark.parametrize(
    "options",
    [
        ["--streams", "colour"],
        ["--streams", ""],
        ["--start", "soon"],
        ["--start", "1e99"],
        ["--start", "100"],
        ["--every", "0"],
        ["--jobs", "0"],
        ["--topic", "rgb"],
        ["--frame-id", "colour=x"],
        ["--dialect", "modern"],
    ],
)
def test_options_that_make_no_sense_are_exit_2(
    folder: Path, options: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["convert", str(folder), "--to", "mcap", *options]) == 2
    assert capsys.readouterr().err
    assert not folder.with_suffix(".mcap").exists()


@pytest.mark.real
def test_the_published_sequence_to_mcap_and_back(real_sequence: Path, tmp_path: Path) -> None:
    target = tmp_path / "x.mcap"
    assert run(["convert", str(real_sequence), str(target), "--to", "mcap", "--archive"]) == 0
    assert run(["convert", str(target), str(tmp_path / "back"), "--to", "tum"]) == 0
    back = files_of(tmp_path / "back")
    expected = files_of(real_sequence)
    assert back == {name: expected[name] for name in back}
    assert {"rgb.txt", "depth.txt", "groundtruth.txt", "accelerometer.txt"} <= back.keys()
    assert len(back) == 184


@pytest.mark.parametrize(("option", "value"), [("--depth-encoding", "16UC1"), ("--color-encoding", "bgr8")])
def test_archive_and_another_encoding_exclude_each_other(tmp_path: Path, option: str, value: str) -> None:
    source = Path(__file__).parents[2] / "fixtures" / "full"
    arguments = ["convert", str(source), str(tmp_path / "x.mcap"), "--to", "mcap", "--archive", option, value]
    assert run(arguments) == 2
    assert not list(tmp_path.iterdir())
