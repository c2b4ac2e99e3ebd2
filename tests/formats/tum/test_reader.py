# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A sequence in the benchmark's layout is read as it is, with all its oddities."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import numpy as np
import pytest

from tumtools.errors import InputError, MissingInputError
from tumtools.images import png
from tumtools.images.codec import pixels_of, png_of
from tumtools.sources import open_source

FIXTURES = Path(__file__).parents[3] / "fixtures"
NAME = "synthetic_freiburg1_room"
"""In the headers of the fixtures."""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return shutil.copytree(FIXTURES / "full", tmp_path / "full")


def _edit(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


def _rows(path: Path) -> list[list[str]]:
    return [line.split() for line in path.read_text().splitlines() if not line.startswith("#")]


@pytest.mark.parametrize(
    ("name", "images", "signals"),
    [
        ("full", ["rgb", "depth"], ["accelerometer", "groundtruth"]),
        ("validation", ["rgb", "depth"], ["accelerometer"]),
        ("ir_calibration", ["rgb", "ir"], ["accelerometer"]),
        ("no_depth", ["rgb"], ["groundtruth"]),
        ("no_accelerometer", ["rgb", "depth"], ["groundtruth"]),
        ("early", ["rgb", "depth"], ["accelerometer", "groundtruth"]),
        ("foreign", ["rgb", "depth"], ["groundtruth"]),
        ("trajectory", [], ["groundtruth"]),
    ],
)
def test_streams_that_are_there_are_found(name: str, images: list[str], signals: list[str]) -> None:
    with open_source(FIXTURES / name) as sequence:
        assert list(sequence.info.images) == images
        found = [
            signal for signal in ("accelerometer", "groundtruth") if getattr(sequence, signal) is not None
        ]
        assert found == signals


def test_a_header_only_accelerometer_has_no_rows_but_is_there() -> None:
    with open_source(FIXTURES / "fr3") as sequence:
        assert sequence.accelerometer is not None
        assert len(sequence.accelerometer) == 0
        assert sequence.info.text["accelerometer"].head.startswith("# accelerometer data\n")


def test_the_papers_imu_txt_is_the_accelerometer_and_the_new_name_is_told() -> None:
    with open_source(FIXTURES / "early") as sequence:
        assert sequence.accelerometer is not None
        assert any("imu.txt" in text and "accelerometer.txt" in text for text in sequence.info.warnings)


def test_accelerometer_txt_is_preferred_and_imu_txt_is_not_carried(folder: Path) -> None:
    shutil.copy(folder / "accelerometer.txt", folder / "imu.txt")
    with open_source(folder) as sequence:
        assert [loss.stream for loss in sequence.info.not_carried] == ["imu.txt"]
        assert sequence.info.warnings == ()


def test_infrared_is_no_depth() -> None:
    with open_source(FIXTURES / "ir_calibration") as sequence:
        image = next(frame for frame in sequence.images(["ir"])).load()
        assert image.depth_units_per_metre is None
        assert sequence.info.images["ir"].depth_units_per_metre is None


def test_images_come_in_order_of_time_and_with_the_row_of_their_list() -> None:
    with open_source(FIXTURES / "full") as sequence:
        frames = list(sequence.images())
    assert [frame.stamp for frame in frames] == sorted(frame.stamp for frame in frames)
    assert [frame.stream for frame in frames] == ["rgb", "depth"] * 4
    assert [frame.row for frame in frames if frame.stream == "rgb"] == [0, 1, 2, 3]


def test_a_list_out_of_order_keeps_its_order_and_its_images(folder: Path) -> None:
    lines = (folder / "rgb.txt").read_text().splitlines()
    (folder / "rgb.txt").write_text("\n".join([*lines[:3], *lines[:2:-1]]) + "\n")
    with open_source(folder) as sequence, open_source(FIXTURES / "full") as original:
        assert sequence.image_stamps("rgb").tolist() == original.image_stamps("rgb")[::-1].tolist()
        pairs = list(zip(sequence.images(["rgb"]), original.images(["rgb"]), strict=True))
        assert [(one.row, one.stamp) for one, _ in pairs] == [
            (3 - other.row, other.stamp) for _, other in pairs
        ]
        assert all(one.load().png == other.load().png for one, other in pairs)


def test_a_part_of_the_time_is_read_with_both_ends() -> None:
    with open_source(FIXTURES / "full") as sequence:
        stamps = sequence.image_stamps("rgb")
        frames = list(sequence.images(["rgb"], int(stamps[1]), int(stamps[2])))
        assert [frame.stamp for frame in frames] == stamps[1:3].tolist()
        assert list(sequence.images(["rgb"], int(stamps[3]) + 1)) == []


def test_a_missing_image_is_named_with_the_line_of_its_list(folder: Path) -> None:
    name = sorted((folder / "rgb").iterdir())[2].name
    (folder / "rgb" / name).unlink()
    with open_source(folder) as sequence:
        assert sequence.info.images["rgb"].count == 4
        with pytest.raises(
            MissingInputError, match=f"there is no image rgb/{name}; 1 of 4 are missing"
        ) as caught:
            next(sequence.images())
        assert (caught.value.path, caught.value.location) == (f"{folder}/rgb.txt", "line 6")
        assert any(f"rgb/{name}" in text for text in sequence.info.warnings)


def test_of_several_lists_the_image_that_is_missing_first_is_named(folder: Path) -> None:
    for stream, number in (("rgb", 3), ("depth", 1)):
        (folder / _rows(folder / f"{stream}.txt")[number][1]).unlink()
    with (
        open_source(folder) as sequence,
        pytest.raises(MissingInputError, match="there is no image depth/"),
    ):
        sequence.images()


def test_a_missing_image_outside_of_the_time_wanted_does_not_matter(folder: Path) -> None:
    gone = sorted((folder / "rgb").iterdir())[3]
    gone.unlink()
    with open_source(folder) as sequence:
        assert len(list(sequence.images(["rgb"], None, int(sequence.image_stamps("rgb")[2])))) == 3


@pytest.mark.parametrize("name", ["../../../etc/passwd", "/etc/passwd", "rgb/../../x.png"])
def test_a_list_cannot_name_files_elsewhere(folder: Path, name: str) -> None:
    _edit(folder / "rgb.txt", _rows(folder / "rgb.txt")[0][1], name)
    with pytest.raises(InputError, match="leads outside of the sequence's folder") as caught:
        open_source(folder)
    assert caught.value.path == str(folder / "rgb.txt")
    assert str(caught.value.location).startswith("line ")
    assert "archive" not in str(caught.value) + str(caught.value.hint)


@pytest.mark.parametrize("name", ["imu.txt", "./groundtruth.txt", "rgb.txt"])
def test_a_text_file_of_the_sequence_is_no_image(folder: Path, name: str) -> None:
    _edit(folder / "rgb.txt", _rows(folder / "rgb.txt")[0][1], name)
    with pytest.raises(InputError, match="as an image, which is the name of a text file"):
        open_source(folder)


def test_a_damaged_image_is_named_and_the_sequence_can_be_opened(folder: Path) -> None:
    path = min((folder / "rgb").iterdir())
    data = bytearray(path.read_bytes())
    data[60] ^= 1
    path.write_bytes(data)
    with open_source(folder) as sequence:
        image = next(sequence.images()).load()
        for use in (pixels_of, png_of):
            with pytest.raises(InputError, match="CRC") as caught:
                use(image)
            assert caught.value.path == str(path)
            assert caught.value.location == "offset 33"


def test_colour_in_the_depth_list_is_refused(folder: Path) -> None:
    shutil.copy(min((folder / "rgb").iterdir()), max((folder / "depth").iterdir()))
    with open_source(folder) as sequence, pytest.raises(InputError, match="16-bit grey") as caught:
        [frame.load() for frame in sequence.images(["depth"])]
    assert caught.value.path == str(max((folder / "depth").iterdir()))


def test_an_image_with_transparency_is_announced_as_it_is_delivered(folder: Path) -> None:
    from tests.images.made import make

    for path in (folder / "rgb").iterdir():
        samples = np.zeros((48, 64, 3), np.uint16)
        path.write_bytes(make(samples, 2, 8, transparency=bytes(6)))
    with open_source(folder) as sequence:
        assert sequence.info.images["rgb"].encoding == "rgba8"
        assert next(sequence.images(["rgb"])).load().encoding == "rgba8"


def test_repeated_stamps_are_all_there(folder: Path) -> None:
    rows = _rows(folder / "groundtruth.txt")
    _edit(folder / "groundtruth.txt", f"\n{rows[1][0]} ", f"\n{rows[0][0]} ")
    with open_source(folder) as sequence:
        assert sequence.groundtruth is not None
        assert len(sequence.groundtruth) == len(rows)
        assert sequence.groundtruth.stamps[0] == sequence.groundtruth.stamps[1]


def test_a_header_without_its_hash_is_a_warning_with_its_line(folder: Path) -> None:
    _edit(folder / "rgb.txt", "# timestamp filename", "timestamp filename")
    with open_source(folder) as sequence:
        (warning,) = sequence.info.warnings
        assert warning.startswith(f"{folder}/rgb.txt, line 3: a header line without '#'")
        assert len(list(sequence.images(["rgb"]))) == 4


def test_other_files_are_named_one_by_one_and_other_folders_with_a_count(folder: Path) -> None:
    (folder / "notes.md").write_text("hello")
    (folder / "masks").mkdir()
    for number in range(3):
        (folder / "masks" / f"{number}.png").write_bytes(b"x")
    with open_source(folder) as sequence:
        lost = [(loss.stream, loss.count) for loss in sequence.info.not_carried]
    assert sorted(lost) == [("masks/", 3), ("notes.md", 1)]


def test_the_official_name_comes_from_the_header_not_the_folder(folder: Path) -> None:
    for path in folder.glob("*.txt"):
        _edit(path, NAME, "rgbd_dataset_freiburg1_desk")
    with open_source(folder) as sequence:
        assert sequence.info.name == "rgbd_dataset_freiburg1_desk"
        assert sequence.info.licence == "CC BY 4.0"


@pytest.mark.parametrize("name", ["../../evil", "a/b", "x\\y", "", "a b"])
def test_a_name_in_the_header_that_is_no_file_name_is_not_used(folder: Path, name: str) -> None:
    for path in folder.glob("*.txt"):
        _edit(path, NAME, name)
    with open_source(folder) as sequence:
        assert sequence.info.name == "full"


def test_images_in_deeper_folders_are_found(folder: Path) -> None:
    (folder / "rgb").rename(folder / "data")
    (folder / "rgb").mkdir()
    (folder / "data").rename(folder / "rgb" / "data")
    _edit(folder / "rgb.txt", " rgb/", " rgb/data/")
    with open_source(folder) as sequence:
        assert len([frame.load() for frame in sequence.images(["rgb"])]) == 4
        assert sequence.info.images["rgb"].source == "rgb/data"


def _not_carried(folder: Path) -> list[tuple[str, int, str]]:
    with open_source(folder) as sequence:
        assert len(list(sequence.images())) == 8
        return [(loss.stream, loss.count, loss.why) for loss in sequence.info.not_carried]


@pytest.mark.parametrize("depth", [4, 5, 200])
def test_files_are_found_however_deep_they_lie(folder: Path, depth: int) -> None:
    below = "/".join("d" * depth)
    (folder / below).mkdir(parents=True)
    (folder / "rgb").rename(folder / below / "rgb")
    _edit(folder / "rgb.txt", " rgb/", f" {below}/rgb/")
    (folder / below / "notes.md").write_text("hello")
    assert _not_carried(folder) == [(f"{below}/", 1, "no list of the sequence names it")]


def test_folders_that_link_to_each_other_come_to_an_end_and_all_ways_to_an_image_count(folder: Path) -> None:
    for name in "ab":
        (folder / name).mkdir()
    (folder / "a" / "b").symlink_to(folder / "b")
    (folder / "b" / "a").symlink_to(folder / "a")
    (folder / "rgb").rename(folder / "b" / "rgb")
    _edit(folder / "rgb.txt", " rgb/", " a/b/rgb/")
    lies_in, unnamed = "a link to a folder that it lies in", "no list of the sequence names it"
    assert _not_carried(folder) == [("a/b/", 1, lies_in), ("b/a/", 1, lies_in), ("b/rgb/", 4, unnamed)]


def test_links_to_nowhere_pipes_and_sockets_are_told_and_not_read(folder: Path) -> None:
    (folder / "gone.txt").symlink_to("nowhere")
    (folder / "self").symlink_to("self")
    (folder / "calib").mkdir()
    for name in ("x", "y"):
        (folder / "calib" / name).symlink_to("nowhere")
    os.mkfifo(folder / "pipe")
    (folder / "to_pipe").symlink_to("pipe")
    nowhere, neither = "a link that leads nowhere", "neither a file nor a folder"
    assert _not_carried(folder) == [
        ("gone.txt", 1, nowhere),
        ("pipe", 1, neither),
        ("self", 1, nowhere),
        ("to_pipe", 1, neither),
        ("calib/", 2, nowhere),
    ]


def test_links_to_images_are_followed_and_links_to_nowhere_are_missing(folder: Path) -> None:
    first, second = sorted((folder / "rgb").iterdir())[:2]
    first.rename(folder.parent / "elsewhere.png")
    first.symlink_to(folder.parent / "elsewhere.png")
    with open_source(folder) as sequence:
        assert len(list(sequence.images())) == 8
    second.unlink()
    second.symlink_to("nowhere")
    with open_source(folder) as sequence, pytest.raises(MissingInputError, match=second.name):
        next(sequence.images())


def test_a_folder_that_links_to_itself_comes_to_an_end(folder: Path) -> None:
    (folder / "loop").symlink_to(folder)
    assert _not_carried(folder) == [("loop", 1, "a link to a folder that it lies in")]


def test_a_pipe_among_the_files_is_not_waited_for(folder: Path) -> None:
    path = min((folder / "rgb").iterdir())
    path.unlink()
    os.mkfifo(path)
    with open_source(folder) as sequence, pytest.raises(MissingInputError):
        next(sequence.images())


def test_a_folder_that_cannot_be_read_is_named(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scandir = os.scandir

    def refuse(path: Path) -> object:
        if Path(path).name == "rgb":
            raise PermissionError(13, "Permission denied", str(path))
        return scandir(path)

    monkeypatch.setattr(os, "scandir", refuse)
    with pytest.raises(InputError, match="cannot read this folder: Permission denied") as caught:
        open_source(folder)
    assert caught.value.path == f"{folder}/rgb"


def test_a_file_that_cannot_be_read_is_named(folder: Path) -> None:
    if os.geteuid() == 0:
        pytest.skip("the superuser may read everything")
    (folder / "rgb.txt").chmod(0)
    with pytest.raises(InputError, match="Permission denied") as caught:
        open_source(folder)
    assert caught.value.path == f"{folder}/rgb.txt"


def test_file_names_that_are_not_utf8_are_kept(tmp_path: Path) -> None:
    folder = tmp_path / os.fsdecode(b"caf\xe9")
    (folder / "rgb").mkdir(parents=True)
    (folder / "rgb" / os.fsdecode(b"\xff.png")).write_bytes(png.encode(np.zeros((2, 2, 3), np.uint8)))
    (folder / "rgb.txt").write_bytes(b"1.5 rgb/\xff.png\n")
    with open_source(folder) as sequence:
        assert len([frame.load() for frame in sequence.images()]) == 1
        assert sequence.info.name.isprintable()


@pytest.mark.parametrize("name", ["trajectory.txt", "trajectory.csv", "trajectory", "x.tgz"])
def test_a_trajectory_file_is_a_sequence_whatever_its_name(tmp_path: Path, name: str) -> None:
    shutil.copy(FIXTURES / "full" / "groundtruth.txt", tmp_path / name)
    with open_source(tmp_path / name) as sequence:
        assert sequence.groundtruth is not None
        assert sequence.info.images == {}
        assert list(sequence.images()) == []
        assert len(sequence.image_stamps("rgb")) == 0


def test_a_list_given_as_a_sequence_says_what_was_expected() -> None:
    with pytest.raises(InputError, match="expected 'timestamp tx ty tz qx qy qz qw'"):
        open_source(FIXTURES / "full" / "rgb.txt")


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda path: path.mkdir(), "no sequence in this folder"),
        (lambda path: path.write_bytes(b""), "the file is empty"),
        (lambda path: path.write_bytes(b"\x7fELF"), "no format of tumtools begins with"),
        (os.mkfifo, "a pipe or a device"),
        (lambda path: path.symlink_to("nowhere"), "no such file"),
    ],
    ids=["folder", "empty", "program", "pipe", "link"],
)
def test_what_is_no_sequence_says_so(tmp_path: Path, make, said: str) -> None:  # noqa: ANN001
    path = tmp_path / "x.mcap"
    make(path)
    with pytest.raises(InputError, match=said) as caught:
        open_source(path)
    assert caught.value.path == str(path)


@pytest.mark.real
def test_the_published_sequence(real_sequence: Path) -> None:
    with open_source(real_sequence) as sequence:
        assert {name: info.count for name, info in sequence.info.images.items()} == {"rgb": 90, "depth": 90}
        assert sequence.info.name == "rgbd_dataset_freiburg1_rpy"
        assert sequence.info.camera == "fr1"
        for stream in ("rgb", "depth"):
            texts = [row[0] for row in _rows(real_sequence / f"{stream}.txt")]
            stamps = [int(text.replace(".", "")) * 1000 for text in texts]
            assert sequence.image_stamps(stream).tolist() == stamps


@pytest.mark.real
def test_published_trajectories_are_rendered_to_the_same_bytes(real_data: Path) -> None:
    from tumtools.formats.tum.text import parse, render

    paths = sorted((real_data / "groundtruth").rglob("*.txt"))[:6]
    assert paths
    for path in paths:
        table = parse(path.read_bytes(), "groundtruth", str(path))
        assert table.layout.overrides == {}
        assert render(table.layout, "groundtruth", table.stamps, table.values) == path.read_bytes()


@pytest.mark.real
def test_a_header_without_hash_of_a_published_copy_is_read(real_data: Path) -> None:
    source = real_data / "malformed" / "header_without_hash" / "groundtruth.txt"
    with open_source(source) as sequence:
        assert sequence.groundtruth is not None
        assert len(sequence.groundtruth) > 0
        assert any("line " in text for text in sequence.info.warnings)
