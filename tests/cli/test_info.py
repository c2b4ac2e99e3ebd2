# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools info` on what is there, what is incomplete and what is no sequence."""

from __future__ import annotations

import gzip
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.formats.rawlog import made as rawlog
from tests.formats.tum.archives import file, tar
from tumtools.cli.main import run

FIXTURES = Path(__file__).parents[2] / "fixtures"


def _document(capsys: pytest.CaptureFixture[str], source: Path) -> dict:
    assert run(["info", "--json", str(source)]) == 0
    return json.loads(capsys.readouterr().out)


def test_streams_times_and_cameras_are_told(capsys: pytest.CaptureFixture[str]) -> None:
    document = _document(capsys, FIXTURES / "full")
    assert (document["format"], document["camera"], document["warnings"]) == ("tum", "fr1", [])
    rgb = document["streams"]["rgb"]
    assert (rgb["count"], rgb["encoding"], rgb["width"], rgb["height"]) == (4, "rgb8", 64, 48)
    assert int(rgb["first"]) < int(rgb["last"])
    assert rgb["duration_s"] == (int(rgb["last"]) - int(rgb["first"])) / 1e9
    assert document["streams"]["depth"]["depth_units_per_metre"] == 5000
    assert document["streams"]["groundtruth"]["median_rate_hz"] == pytest.approx(100)


@pytest.mark.parametrize("name", sorted(path.name for path in FIXTURES.iterdir() if path.is_dir()))
def test_every_fixture_is_described(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    if not any((FIXTURES / name).glob("*.txt")):
        pytest.skip("another layout")
    streams = _document(capsys, FIXTURES / name)["streams"]
    assert run(["info", str(FIXTURES / name)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert all(any(line.startswith(f"{stream} ") for line in lines) for stream in streams)


def test_an_incomplete_sequence_is_described_with_what_is_missing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = shutil.copytree(FIXTURES / "full", tmp_path / "x")
    shutil.rmtree(folder / "depth")
    (folder / "accelerometer.txt").unlink()
    document = _document(capsys, folder)
    assert document["streams"]["depth"]["count"] == 4
    assert document["streams"]["depth"]["encoding"] is None
    (warning,) = document["warnings"]
    assert warning.startswith(f"{folder}/depth.txt, line 4: there is no image depth/")
    assert warning.endswith("4 of 4 are missing")


@pytest.mark.parametrize(
    ("to", "accelerometer", "groundtruth"),
    [
        ("tum", "accelerometer.txt", "groundtruth.txt"),
        ("mcap", "/imu", "/groundtruth/pose"),
        ("rosbag1", "/imu", "/tf"),
        ("rawlog", "KINECT_ACC", "groundtruth.txt"),
    ],
)
def test_where_the_signals_come_from_is_told(
    to: str, accelerometer: str, groundtruth: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["convert", str(FIXTURES / "full"), str(tmp_path / "x"), "--to", to]) == 0
    capsys.readouterr()
    assert run(["info", str(tmp_path / "x"), "--json"]) == 0
    streams = json.loads(capsys.readouterr().out)["streams"]
    assert streams["accelerometer"]["source"] == accelerometer
    assert streams["groundtruth"]["source"] == groundtruth


def test_what_the_catalogue_knows_of_a_sequence_is_repeated(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "groundtruth.txt"
    text = "# ground truth trajectory\n# file: '{}.bag'\n# timestamp tx ty tz qx qy qz qw\n1 0 0 0 0 0 0 1\n"
    for name, known in (("rgbd_dataset_freiburg2_desk", True), ("my_own", False)):
        path.write_text(text.format(name))
        assert run(["info", str(path)]) == 0
        assert ("note: ground truth" in capsys.readouterr().out) == known
        assert run(["info", str(path), "--json"]) == 0
        assert bool(json.loads(capsys.readouterr().out)["notes"]) == known


def test_lists_without_rows_are_described(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "rgb.txt").write_text("")
    (tmp_path / "groundtruth.txt").write_text("# nothing yet\n")
    streams = _document(capsys, tmp_path)["streams"]
    assert streams["rgb"]["count"] == streams["groundtruth"]["count"] == 0
    assert run(["info", str(tmp_path)]) == 0


@pytest.mark.parametrize("kind", ["folder", "x.mcap folder", "archive", "empty", "picture"])
def test_what_is_no_sequence_is_exit_4_and_names_the_path(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    path = tmp_path / ("x.mcap" if kind == "x.mcap folder" else "x.tgz")
    if "folder" in kind:
        path.mkdir()
    else:
        content = {
            "archive": gzip.compress(tar([file("a/readme.txt", b"hello")])),
            "empty": b"",
            "picture": b"\xff\xd8\xff\xe0 JFIF",
        }
        path.write_bytes(content[kind])
    assert run(["info", str(path)]) == 4
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith(f"error: {path}")


@pytest.mark.parametrize(
    ("inside", "hint"),
    [("x.db3", "name what is in it: x.db3"), ("bag/metadata.yaml", "name what is in it: bag\n")],
)
def test_a_folder_around_recordings_names_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], inside: str, hint: str
) -> None:
    (tmp_path / inside).parent.mkdir(exist_ok=True)
    (tmp_path / inside).write_text("rosbag2_bagfile_information:")
    assert run(["info", str(tmp_path)]) == 4
    assert hint in capsys.readouterr().err


def test_the_description_of_a_recording_names_its_folder(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "metadata.yaml").write_text("rosbag2_bagfile_information:")
    assert run(["info", str(tmp_path / "metadata.yaml")]) == 4
    assert "name the folder that it is in" in capsys.readouterr().err


@pytest.mark.real
def test_the_incomplete_published_sequence(real_data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["info", str(real_data / "malformed" / "incomplete")]) == 0
    assert "are missing" in capsys.readouterr().err


HOSTILE = "\x1b[31mRED\x07\nhint: \x9b2J"


def _hostile(path: Path, label: str = HOSTILE) -> Path:
    counts = np.arange(48, dtype="<u2").reshape(6, 8)
    return rawlog.save(
        path, rawlog.scan(label=label, has_labels=0, **rawlog.with_depth(counts)), rawlog.imu(label=label)
    )


@pytest.mark.parametrize(
    "command",
    [
        ["info"],
        ["info", "--json"],
        ["convert", "--to", "tum", "--dry-run"],
        ["validate"],
        ["digest"],
        ["stats"],
    ],
)
def test_what_names_in_a_recording_hold_does_not_reach_the_terminal(
    command: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = _hostile(tmp_path / "a.rawlog")
    path = path.rename(tmp_path / "\x1b[31m.rawlog")
    assert run([command[0], str(path), *command[1:]]) in {0, 1}
    out = "".join(capsys.readouterr())
    assert not set(out) & {"\x1b", "\x07", "\x9b"}
    assert "\nhint" not in out


def test_a_label_as_long_as_a_book_is_cut_for_people(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = _hostile(tmp_path / "a.rawlog", "x" * 100_000)
    assert run(["info", str(path)]) == 0
    assert len(capsys.readouterr().out) < 10_000
    assert "x" * 100_000 in json.dumps(_document(capsys, path))


def test_a_file_that_is_damaged_from_its_beginning_is_described(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "a.rawlog"
    path.write_bytes(b"\x8fCObservationGPS\x08" + bytes(99))
    assert run(["info", str(path), "--salvage"]) == 0
    shown = capsys.readouterr()
    assert "what is before it (0 objects) is read" in shown.err
    assert "sensors" not in shown.out


def test_the_tables_of_a_rawlog_show_times_in_seconds_and_tell_programs_nanoseconds(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = _hostile(tmp_path / "a.rawlog", "CAM")
    assert _document(capsys, path)["details"]["rawlog"][0]["first"] == "1305031229528748000"
    assert run(["info", str(path)]) == 0
    out = capsys.readouterr().out
    assert "1305031229.528748000" in out
    assert "1305031229528748000" not in out
