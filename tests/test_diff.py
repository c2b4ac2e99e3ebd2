# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Two sequences are compared by content, and tolerances say what still counts as the same."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.memory import START, Memory, groundtruth
from tumtools.cli.main import run
from tumtools.convert import convert
from tumtools.diff import Comparison, Tolerances, diff
from tumtools.formats.options import WriteOptions
from tumtools.images import png
from tumtools.model.camera import calibration
from tumtools.model.text import default_layout
from tumtools.sources import open_source

FIXTURE = Path(__file__).parents[1] / "fixtures" / "full"


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    return shutil.copytree(FIXTURE, tmp_path / "copy")


def _compare(other: Path, tolerances: Tolerances | None = None) -> Comparison:
    with open_source(FIXTURE) as a, open_source(other) as b:
        return diff(a, b, tolerances)


def _replace(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


def test_a_copy_is_the_same_and_everything_was_compared(copy: Path) -> None:
    result = _compare(copy)
    assert result.same
    assert result.pixels == result.images * 64 * 48
    assert result.rows


def test_a_pixel_is_found_with_its_size_and_place(copy: Path) -> None:
    path = min((copy / "depth").iterdir())
    pixels = png.decode(path.read_bytes()).copy()
    pixels[3, 5] += 10
    path.write_bytes(png.encode(pixels))
    (one,) = _compare(copy).differences
    assert (one.stream, one.what, one.count) == ("depth", "pixels", 1)
    assert one.largest == pytest.approx(10 / 5000, abs=1e-6)
    assert "(1 pixels)" in one.first
    assert _compare(copy, Tolerances(depth=10 / 5000)).same


def test_the_loss_that_a_conversion_reports_is_within_the_tolerance_of_that_size(tmp_path: Path) -> None:
    with open_source(FIXTURE) as sequence:
        report = convert(sequence, tmp_path / "x.mcap", "mcap", WriteOptions(depth_encoding="16UC1"))
    (loss,) = report.losses
    assert loss.largest_error is not None
    assert not _compare(tmp_path / "x.mcap").same
    assert _compare(tmp_path / "x.mcap", Tolerances(depth=loss.largest_error)).same


def test_a_tolerance_for_colour_is_none_for_depth(copy: Path) -> None:
    path = min((copy / "depth").iterdir())
    path.write_bytes(png.encode(png.decode(path.read_bytes()) + np.uint16(1)))
    assert not _compare(copy, Tolerances(colour=255)).same


def test_a_value_and_its_text_are_found(copy: Path) -> None:
    first = next(line for line in (copy / "groundtruth.txt").read_text().splitlines() if line[0] != "#")
    fields = first.split()
    changed = " ".join([fields[0], f"{float(fields[1]) + 0.25:.4f}", *fields[2:]])
    _replace(copy / "groundtruth.txt", first, changed)
    values, text = _compare(copy).differences
    assert (values.stream, values.what, values.count, values.unit) == ("groundtruth", "values", 1, "m")
    assert values.largest == pytest.approx(0.25)
    assert (text.what, text.count) == ("text", 1)


def test_a_stream_that_only_one_has_and_a_count_are_found(copy: Path) -> None:
    (copy / "accelerometer.txt").unlink()
    lines = (copy / "groundtruth.txt").read_text().splitlines(keepends=True)
    (copy / "groundtruth.txt").write_text("".join(lines[:-2]))
    found = {(one.stream, one.what): one for one in _compare(copy).differences}
    assert found["accelerometer", "stream"].first == "only in the first"
    assert found["groundtruth", "count"].count == 2


@pytest.mark.parametrize("option", ["--stamp-tolerance", "--value-tolerance", "--depth-tolerance"])
@pytest.mark.parametrize("value", ["inf", "nan"])
def test_a_tolerance_is_a_finite_number(option: str, value: str) -> None:
    assert run(["diff", str(FIXTURE), str(FIXTURE), option, value]) == 2


def test_exit_codes(copy: Path) -> None:
    assert run(["diff", str(FIXTURE), str(copy)]) == 0
    (copy / "accelerometer.txt").unlink()
    assert run(["diff", str(FIXTURE), str(copy)]) == 1


def test_two_files_without_text_are_the_same_under_any_names() -> None:
    """As three bags of one recording, which differ in nothing but their compression."""
    first, second = (Memory({}, groundtruth=groundtruth(START), name=name) for name in ("a", "a-bz2"))
    assert diff(first, second).same


def test_a_header_that_is_there_is_compared() -> None:
    layout = default_layout("groundtruth", "other")
    first = Memory({}, groundtruth=groundtruth(START), name="a")
    second = Memory({}, groundtruth=groundtruth(START), name="a", text={"groundtruth": layout})
    assert [one.what for one in diff(first, second).differences] == ["text"]


def test_nothing_on_both_sides_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "rgb.txt").touch()
    assert run(["diff", str(tmp_path / "a"), str(tmp_path / "b")]) == 0
    assert "nothing was compared" in capsys.readouterr().err


def test_what_is_beside_the_data_is_compared() -> None:
    plain = Memory({"rgb": [START]}, groundtruth=groundtruth(START))
    for what, other in (
        ("frame id", Memory({"rgb": [START]}, groundtruth=groundtruth(START), frame_ids={"rgb": "head"})),
        ("licence", Memory({"rgb": [START]}, groundtruth=groundtruth(START), licence="MIT")),
        ("citation", Memory({"rgb": [START]}, groundtruth=groundtruth(START), citation="Somebody")),
        ("camera", Memory({"rgb": [START]}, groundtruth=groundtruth(START), camera="fr3")),
    ):
        assert [one.what for one in diff(plain, other).differences] == [what]


def test_a_calibration_that_is_told_and_one_that_follows_are_the_same() -> None:
    one, other = Memory({"rgb": [START]}), Memory({"rgb": [START]})
    one.cameras = {"rgb": calibration("fr1", "rgb", 8, 6)}
    assert diff(one, other).same
    one.cameras = {"rgb": replace(one.cameras["rgb"], d=(0.5,) * 5)}
    (difference,) = diff(one, other).differences
    assert (difference.what, difference.first.split(" and ")[0]) == ("calibration", "d 0.5 0.5 0.5 0.5 0.5")


def test_the_sign_of_zero_is_a_difference_unless_there_is_a_tolerance() -> None:
    one, other = (Memory({}, groundtruth=groundtruth(START)) for _ in range(2))
    assert one.groundtruth is not None
    assert other.groundtruth is not None
    one.groundtruth.positions[0, 1], other.groundtruth.positions[0, 1] = 0.0, -0.0
    assert [found.what for found in diff(one, other).differences] == ["values", "text"]
    assert [found.what for found in diff(one, other, Tolerances(value=1e-9)).differences] == ["text"]


def test_stamps_may_be_centuries_apart() -> None:
    one, other = Memory({"rgb": [-9 * 10**18]}), Memory({"rgb": [9 * 10**18]})
    found = next(found for found in diff(one, other).differences if found.what == "stamps")
    assert found.largest == pytest.approx(18e9)


def test_infinite_differences_are_valid_json(capsys: pytest.CaptureFixture[str], copy: Path) -> None:
    text = (copy / "groundtruth.txt").read_text().splitlines()
    text[3] = " ".join([text[3].split()[0], "inf", *text[3].split()[2:]])
    (copy / "groundtruth.txt").write_text("\n".join(text) + "\n")
    assert run(["diff", str(FIXTURE), str(copy), "--json"]) == 1
    document = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    assert document["differences"][0]["largest"] is None
