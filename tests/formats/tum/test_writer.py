# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What is written is what was read, byte for byte; what has no place is told."""

from __future__ import annotations

import shutil
import tarfile
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from tests.formats.tum.archives import files_of
from tests.made import made
from tumtools.convert import ConvertOptions, convert
from tumtools.digest import digest
from tumtools.errors import OutputError
from tumtools.formats.options import WriteOptions
from tumtools.images import png
from tumtools.images.codec import image_of_pixels, image_of_png
from tumtools.model.camera import calibration
from tumtools.model.sequence import ImageStreamInfo
from tumtools.model.text import default_layout
from tumtools.sources import open_source

if TYPE_CHECKING:
    from tumtools.convert import Report

FIXTURES = Path(__file__).parents[3] / "fixtures"
NAMES = sorted(path.name for path in FIXTURES.iterdir() if path.is_dir() and (path / "rgb.txt").exists())


def _convert(source: Path, target: Path) -> Report:
    with open_source(source) as sequence:
        return convert(sequence, target, "tum")


@pytest.mark.parametrize("name", NAMES)
def test_every_fixture_is_written_byte_for_byte(tmp_path: Path, name: str) -> None:
    report = _convert(FIXTURES / name, tmp_path / "out")
    expected = files_of(FIXTURES / name)
    if "imu.txt" in expected:
        expected["accelerometer.txt"] = expected.pop("imu.txt")
    assert files_of(tmp_path / "out") == expected
    assert report.losses == ()
    assert report.nbytes == sum(map(len, expected.values()))


@pytest.mark.parametrize("name", ["full", "foreign"])
def test_the_way_through_an_archive_gives_the_same_files(tmp_path: Path, name: str) -> None:
    _convert(FIXTURES / name, tmp_path / "x.tgz")
    _convert(tmp_path / "x.tgz", tmp_path / "out")
    assert files_of(tmp_path / "out") == files_of(FIXTURES / name)


def test_an_archive_has_the_same_bytes_on_another_day(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = FIXTURES / "full"
    _convert(source, tmp_path / "a.tgz")
    monkeypatch.setattr("time.time", lambda: 2e9)
    copy = shutil.copytree(source, tmp_path / "full")
    _convert(copy, tmp_path / "b.tgz")
    assert (tmp_path / "a.tgz").read_bytes() == (tmp_path / "b.tgz").read_bytes()


def test_an_archive_has_the_published_shape(tmp_path: Path) -> None:
    _convert(FIXTURES / "full", tmp_path / "x.tgz")
    with tarfile.open(tmp_path / "x.tgz") as archive:
        members = archive.getmembers()
    name = "synthetic_freiburg1_room"
    assert [member.name for member in members if member.isdir()] == [name, f"{name}/rgb", f"{name}/depth"]
    assert {member.name.rpartition("/")[0] for member in members if member.isfile()} == {
        name,
        f"{name}/rgb",
        f"{name}/depth",
    }


@pytest.mark.parametrize("name", ["../evil", "/evil", "a/b", "..", "", "x\ny"])
def test_a_hostile_name_does_not_become_a_path(tmp_path: Path, name: str) -> None:
    sequence = made(name=name)
    convert(sequence, tmp_path / "good.tgz", "tum")
    with tarfile.open(tmp_path / "good.tgz") as archive:
        assert {member.name.split("/")[0] for member in archive} == {"good"}
    with open_source(tmp_path / "good.tgz") as again:
        assert digest(again) == digest(sequence)


def test_a_sequence_without_layouts_gets_the_published_ones(tmp_path: Path) -> None:
    sequence = made(name="rgbd_dataset_freiburg2_made", rgb=[1_500_000_000, 2_000_000_000])
    convert(sequence, tmp_path / "out", "tum")
    assert (tmp_path / "out" / "rgb.txt").read_text() == (
        "# color images\n# file: 'rgbd_dataset_freiburg2_made.bag'\n# timestamp filename\n"
        "1.500000 rgb/1.500000.png\n2.000000 rgb/2.000000.png\n"
    )


def test_stamps_get_as_many_decimals_as_they_need(tmp_path: Path) -> None:
    sequence = made(rgb=[1_000_000_000, 1_000_000_001])
    convert(sequence, tmp_path / "out", "tum")
    assert [path.name for path in sorted((tmp_path / "out" / "rgb").iterdir())] == [
        "1.000000000.png",
        "1.000000001.png",
    ]


def test_values_get_as_many_digits_as_they_need(tmp_path: Path) -> None:
    sequence = made(accelerometer=[(5, (0.1, 1 / 3, -0.0)), (6, (float("nan"), 1e300, 5e-324))])
    convert(sequence, tmp_path / "out", "tum")
    with open_source(tmp_path / "out") as again:
        assert again.accelerometer is not None
        assert sequence.accelerometer is not None
        assert again.accelerometer.values.tobytes() == sequence.accelerometer.values.tobytes()


def test_different_images_with_one_stamp_get_names_of_their_own(tmp_path: Path) -> None:
    sequence = made(rgb=[1_000_000_000] * 3 + [2_000_000_000], colours=[1, 2, 1, 1])
    convert(sequence, tmp_path / "out", "tum")
    rows = (tmp_path / "out" / "rgb.txt").read_text().splitlines()[-4:]
    assert rows == [
        "1.000000 rgb/1.000000.png",
        "1.000000 rgb/1.000000-1.png",
        "1.000000 rgb/1.000000.png",
        "2.000000 rgb/2.000000.png",
    ]
    with open_source(tmp_path / "out") as again:
        assert digest(again) == digest(sequence)
        convert(again, tmp_path / "more.tgz", "tum")
    _convert(tmp_path / "more.tgz", tmp_path / "more")
    assert files_of(tmp_path / "more") == files_of(tmp_path / "out")


def _with_list(folder: Path, rows: list[str], names: list[str]) -> Path:
    """Write a folder with a list of colour images, each different, and one depth image."""
    images = {name: png.encode(np.full((6, 8, 3), number, np.uint8)) for number, name in enumerate(names)}
    images["depth/2.5.png"] = png.encode(np.full((6, 8), 5000, np.uint16))
    for name, data in images.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
    (folder / "rgb.txt").write_text("".join(f"{row}\n" for row in rows), encoding="utf-8")
    (folder / "depth.txt").write_text("2.5 depth/2.5.png\n")
    return folder


@pytest.mark.parametrize("first", ["rgb/x.png", "rgb/1.5-1.png", "rgb/0.5.png"])
def test_a_name_that_a_row_says_itself_stays_at_a_repeated_stamp(tmp_path: Path, first: str) -> None:
    """The row behind has the usual name, which nobody else may take."""
    rows = [f"1.5 {first}", "1.5 rgb/1.5.png", "2.5 rgb/2.5.png"]
    source = _with_list(tmp_path / "in", rows, [first, "rgb/1.5.png", "rgb/2.5.png"])
    for target, to in (("x.mcap", "mcap"), ("out", "tum")):
        with open_source(source) as sequence:
            assert convert(sequence, tmp_path / target, to, WriteOptions()).losses == ()
        source = tmp_path / target
    assert files_of(tmp_path / "out") == files_of(tmp_path / "in")


@pytest.mark.parametrize("name", ["rgb/a\u00a0b.png", "rgb/a\u3000b.png", "rgb/a\x1cb.png", "rgb/a\x85b.png"])
def test_a_name_ends_at_ascii_blanks_only(tmp_path: Path, name: str) -> None:
    source = _with_list(tmp_path / "in", [f"1.5 {name}"], [name])
    assert _convert(source, tmp_path / "out").losses == ()
    assert files_of(tmp_path / "out") == files_of(source)


def test_one_file_in_two_streams_is_kept_as_the_file_it_is_or_refused(tmp_path: Path) -> None:
    source = _with_list(tmp_path / "in", ["1.5 depth/2.5.png"], [])
    for archive in (True, False):
        target = tmp_path / f"{archive}.mcap"
        with open_source(source) as sequence:
            convert(sequence, target, "mcap", WriteOptions(archive=archive))
    assert _convert(tmp_path / "True.mcap", tmp_path / "out").losses == ()
    shutil.rmtree(tmp_path / "out" / "rgb")  # which is there for each stream
    assert files_of(tmp_path / "out") == files_of(source)
    with pytest.raises(OutputError, match=r"rgb and depth name the same file, depth/2\.5\.png"):
        _convert(tmp_path / "False.mcap", tmp_path / "out2")


def test_names_apart_keep_the_line_ends_of_the_list(tmp_path: Path) -> None:
    sequence = made(rgb=[1_000_000_000] * 2, colours=[1, 2])
    sequence.info = replace(sequence.info, text={"rgb": replace(default_layout("rgb", None), newline="\r\n")})
    convert(sequence, tmp_path / "out", "tum", options=ConvertOptions(verify=False))
    assert (
        (tmp_path / "out" / "rgb.txt")
        .read_bytes()
        .endswith(b"rgb/1.000000.png\r\n1.000000 rgb/1.000000-1.png\r\n")
    )


def test_what_the_layout_has_no_place_for_is_told_and_the_data_is_compared_all_the_same(
    tmp_path: Path,
) -> None:
    sequence = made()
    sequence.cameras = {"rgb": calibration("fr1", "rgb")}
    sequence.info = replace(sequence.info, frame_ids={"rgb": "camera"})
    report = convert(sequence, tmp_path / "out", "tum")
    assert [(loss.stream, loss.what, loss.alters) for loss in report.losses] == [
        ("rgb", "calibration", ("calibration",)),
        ("rgb", "frame id camera", ("frame id",)),
    ]
    assert report.verified


def test_depth_in_metres_is_rounded_to_counts_and_the_rounding_told(tmp_path: Path) -> None:
    metres = np.array([[1.0, 1.00005, np.nan, 20.0]], np.float32)
    sequence = made(depth=[1_000_000_000])
    sequence.load_depth = lambda: image_of_pixels(metres, "32FC1", 1.0)
    images = dict(sequence.info.images)
    images["depth"] = ImageStreamInfo(1, "32FC1", 4, 1, 1.0, nbytes=16)
    sequence.info = replace(sequence.info, images=images)
    report = convert(sequence, tmp_path / "out", "tum")
    assert [(loss.what, loss.count) for loss in report.losses] == [
        ("pixels rounded", 1),
        ("pixels out of range, now without a reading", 1),
    ]
    assert report.losses[0].largest_error == pytest.approx(5e-5, rel=0.01)
    assert png.decode((tmp_path / "out" / "depth" / "1.000000.png").read_bytes()).tolist() == [
        [5000, 5000, 0, 0]
    ]


def test_png_files_are_passed_on_and_pixels_are_encoded(tmp_path: Path) -> None:
    sequence = made(rgb=[10**9], colours=[3])
    frame = next(sequence.images())
    data = frame.load().png
    assert data is not None
    pixels = png.decode(data)
    sequence.load_rgb = lambda _: image_of_pixels(pixels[:, :, ::-1], "bgr8")
    convert(sequence, tmp_path / "out", "tum", WriteOptions(jobs=1))
    again = image_of_png((tmp_path / "out" / "rgb" / "1.000000.png").read_bytes())
    assert again.png == png.encode(pixels)


def test_the_same_bytes_with_any_number_of_threads(tmp_path: Path) -> None:
    for jobs in (1, 2, 7):
        with open_source(FIXTURES / "full") as sequence:
            convert(sequence, tmp_path / f"{jobs}.tgz", "tum", WriteOptions(jobs=jobs))
    assert len({path.read_bytes() for path in tmp_path.iterdir()}) == 1


@pytest.mark.real
def test_the_published_sequence_comes_back_byte_for_byte(real_sequence: Path, tmp_path: Path) -> None:
    _convert(real_sequence, tmp_path / "x.tgz")
    report = _convert(tmp_path / "x.tgz", tmp_path / "out")
    assert report.losses == ()
    expected = files_of(real_sequence)
    assert {name: expected[name] for name in files_of(tmp_path / "out")} == files_of(tmp_path / "out")
