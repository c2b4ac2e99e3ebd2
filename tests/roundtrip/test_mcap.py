# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""From the benchmark's layout to MCAP and back: nothing is lost."""

from __future__ import annotations

import shutil
import tarfile
from pathlib import Path

import numpy as np
import pytest

from tests.memory import SECOND, START, Memory, accelerometer, groundtruth
from tumtools.convert import convert
from tumtools.digest import digest
from tumtools.formats.options import WriteOptions
from tumtools.images.codec import pixels_of
from tumtools.sources import open_source

FIXTURES = Path(__file__).parents[2] / "fixtures"
NAMES = sorted(path.name for path in FIXTURES.iterdir() if path.is_dir() and any(path.glob("*.txt")))


def _there_and_back(source: Path, folder: Path, options: WriteOptions, target: str = "back") -> Path:
    with open_source(source) as sequence:
        assert convert(sequence, folder / "x.mcap", "mcap", options).losses == ()
    with open_source(folder / "x.mcap") as sequence:
        assert set(sequence.info.warnings) <= {"the recording has no messages"}
        assert convert(sequence, folder / target, "tum").losses == ()
    return folder / target


def _differences(one: Path, other: Path) -> list[str]:
    """Return the files and folders that `diff -r` would name."""
    names = {str(path.relative_to(folder)) for folder in (one, other) for path in folder.rglob("*")}
    return sorted(name for name in names if _content(one / name) != _content(other / name))


def _content(path: Path) -> bytes | bool | None:
    return path.is_dir() or (path.read_bytes() if path.exists() else None)


def _same_name(source: Path) -> dict[str, str]:
    """Return the names that text files change on the way: `imu.txt` is `accelerometer.txt` today."""
    return {"imu.txt": "accelerometer.txt"} if (source / "imu.txt").exists() else {}


def _check_archive(source: Path, back: Path, tmp_path: Path) -> None:
    expected = tmp_path / "expected"
    shutil.copytree(source, expected, copy_function=shutil.copyfile)
    for old, new in _same_name(source).items():
        (expected / old).rename(expected / new)
    assert _differences(expected, back) == []


def _check_default(source: Path, back: Path) -> None:
    """Text and colour are the same bytes, depth the same pixels."""
    names = _same_name(source)
    for text in source.glob("*.txt"):
        assert (back / names.get(text.name, text.name)).read_bytes() == text.read_bytes()
    for colour in [*source.glob("rgb/*.png"), *source.glob("ir/*.png")]:
        assert (back / colour.relative_to(source)).read_bytes() == colour.read_bytes()
    with open_source(source) as one, open_source(back) as other:
        for first, second in zip(one.images(["depth"]), other.images(["depth"]), strict=True):
            assert first.stamp == second.stamp
            np.testing.assert_array_equal(pixels_of(first.load()), pixels_of(second.load()))
        assert digest(one).value == digest(other).value


@pytest.fixture(params=[*NAMES, pytest.param("real", marks=pytest.mark.real)])
def source(request: pytest.FixtureRequest) -> Path:
    return request.getfixturevalue("real_sequence") if request.param == "real" else FIXTURES / request.param


def test_an_archive_gives_the_same_files(source: Path, tmp_path: Path) -> None:
    _check_archive(source, _there_and_back(source, tmp_path, WriteOptions(archive=True)), tmp_path)


def test_the_default_gives_the_same_texts_colours_and_depths(source: Path, tmp_path: Path) -> None:
    _check_default(source, _there_and_back(source, tmp_path, WriteOptions()))


@pytest.mark.parametrize("archive", [True, False])
def test_the_same_out_of_a_tgz(source: Path, tmp_path: Path, archive: bool) -> None:
    packed = tmp_path / "x.tgz"
    with tarfile.open(packed, "w:gz", compresslevel=1) as file:
        file.add(source, source.name)
    back = _there_and_back(packed, tmp_path, WriteOptions(archive=archive))
    if archive:
        _check_archive(source, back, tmp_path)
    else:
        _check_default(source, back)


RAW = [WriteOptions(color_encoding="rgb8"), WriteOptions(color_encoding="bgr8", compression="lz4")]


@pytest.mark.parametrize("options", RAW)
def test_raw_colour_gives_the_same_pixels(tmp_path: Path, options: WriteOptions) -> None:
    back = _there_and_back(FIXTURES / "full", tmp_path, options)
    with open_source(FIXTURES / "full") as one, open_source(back) as other:
        assert digest(one).value == digest(other).value


TIMES = [START + n * SECOND // 30 for n in range(5)]
AWKWARD = {
    "one frame": Memory({"rgb": [START], "depth": [START]}),
    "no depth": Memory({"rgb": TIMES}, groundtruth=groundtruth(*TIMES)),
    "infrared only": Memory({"ir": TIMES}),
    "no ground truth": Memory({"rgb": TIMES, "depth": TIMES}, accelerometer=accelerometer(*TIMES)),
    "signals only": Memory({}, groundtruth=groundtruth(*TIMES), accelerometer=accelerometer(*TIMES)),
    "zero rows": Memory(
        {"rgb": [], "depth": [], "ir": []}, accelerometer=accelerometer(), groundtruth=groundtruth()
    ),
    "some without rows": Memory({"rgb": TIMES, "depth": []}, accelerometer=accelerometer()),
    "repeated stamps": Memory(
        {"rgb": [START, START, START + 1000], "depth": [START, START]},
        accelerometer=accelerometer(START, START, START),
        groundtruth=groundtruth(START, START),
    ),
    "unsorted rows": Memory(
        {"rgb": TIMES[::-1], "depth": [TIMES[n] for n in (2, 0, 4, 1, 3)]},
        accelerometer=accelerometer(*TIMES[::-1]),
        groundtruth=groundtruth(TIMES[3], TIMES[1], TIMES[2]),
    ),
    "unsorted and repeated": Memory({"rgb": [START + 2000, START, START + 2000, START]}),
    "nine decimals": Memory(
        {"rgb": [START + 1, START + 2], "depth": [START + 3]}, groundtruth=groundtruth(START + 1)
    ),
    "the first second of 1970": Memory({"rgb": [0, 1]}, accelerometer=accelerometer(0)),
}  # fmt: skip


@pytest.mark.parametrize("archive", [True, False])
@pytest.mark.parametrize("name", AWKWARD)
def test_awkward_contents(tmp_path: Path, name: str, archive: bool) -> None:
    """In memory -> folder -> MCAP -> folder; repeated stamps get files of their own where images differ."""
    convert(AWKWARD[name], tmp_path / "source", "tum")
    back = _there_and_back(tmp_path / "source", tmp_path, WriteOptions(archive=archive))
    assert _differences(tmp_path / "source", back) == []
    with open_source(back) as result:
        for stream in AWKWARD[name].info.images:
            assert result.image_stamps(stream).tolist() == AWKWARD[name].image_stamps(stream).tolist()
        assert digest(result).value == digest(AWKWARD[name]).value
