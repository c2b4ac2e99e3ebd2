# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The comment that a rawlog of ours begins with is believed only if it is whole."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from tests.formats.rawlog import made
from tests.formats.rawlog.made import FIRST, names_of, opened, save, written
from tumtools.convert import convert
from tumtools.errors import InputError
from tumtools.formats.metadata import Metadata
from tumtools.formats.rawlog.comment import Notes, dump, is_notes, parse
from tumtools.formats.rawlog.objects import Objects
from tumtools.model.camera import calibration
from tumtools.model.sequence import LEFT_OUT
from tumtools.model.text import TextLayout

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from tumtools.formats.rawlog.archive import Record

CAMERA = calibration("fr1", "rgb")
NOTES = Notes(
    Metadata("x", text={"rgb": TextLayout()}),
    "modern",
    counts={"rgb": 2},
    frame_ids={"rgb": "camera"},
    accelerometer_remainders_ns=(0, 99),
    cameras={"rgb": CAMERA},
)


def _without_crc(text: str) -> str:
    """As the first files had it, and as somebody writes who changes it."""
    document = json.loads(text)
    del document["rawlog"]["crc32"]
    return json.dumps(document, separators=(",", ":"), sort_keys=True)


def test_what_is_dumped_is_parsed() -> None:
    assert parse(dump(NOTES)) == NOTES
    assert parse(_without_crc(dump(NOTES))) == NOTES
    assert not is_notes("somebody's")


def test_a_camera_may_have_numbers_that_are_none() -> None:
    camera = replace(CAMERA, d=(float("nan"), float("inf")))
    assert parse(dump(replace(NOTES, cameras={"rgb": camera}))) == replace(NOTES, cameras={"rgb": camera})


@pytest.mark.parametrize("checked", [True, False])
@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("%.6f", "%n"),
        ('"version":"1"', '"version":"2"'),
        ('"counts"', '"accounts"'),
        ('"width":640', '"width":{}'),
        ('"width":640', '"width":Infinity'),
        ('"width":640', '"width":-1'),
        ('"width":640', '"width":' + "9" * 40),
        ('"k":[', '"k":[1,'),
        ('"k":[', '"k":[true,'),
        ('"p":[', '"p":["1",'),
        ('"d":[', '"d":[' + "0," * 99),
        ('"tumtools":{', '"tumtools":[{'),
        ('"counts":{"rgb":2}', '"counts":{"rgb":-2}'),
        ('"counts":{"rgb":2}', '"counts":{"rgb":2.5}'),
        ('"counts":{"rgb":2}', '"counts":{"bogus":2}'),
        ("[0,99]", "[0,100]"),
        ("[0,99]", "[0,-1]"),
        ("[0,99]", "[0,1e400]"),
        ("[0,99]", '{"0":99}'),
        ("[0,99]", "[0,1" + "0" * 60 + "]"),
        ('{"rgb":"camera"}', '["rgb"]'),
    ],
)
def test_damage_is_told(old: str, new: str, checked: bool) -> None:
    text = dump(NOTES) if checked else _without_crc(dump(NOTES))
    assert old in text
    with pytest.raises(ValueError, match=r"."):
        parse(text.replace(old, new))


@pytest.mark.parametrize("text", ['{"rawlog":', '{"rawlog":[]}', '{"rawlog":' + "[" * 100_000])
def test_what_is_no_document_is_damage(text: str) -> None:
    with pytest.raises(ValueError, match=r"."):
        parse(text)


def test_a_change_that_makes_sense_is_found_by_the_checksum() -> None:
    with pytest.raises(ValueError, match="CRC is wrong"):
        parse(dump(NOTES).replace("[0,99]", "[0,98]"))


def _change(path: Path, change: Callable[[str], str]) -> None:
    records = list(Objects(path))
    records[0].fields["text"] = change(records[0].text("text"))
    save(path, *records)


def test_a_damaged_comment_is_an_error_with_its_place_or_passed_over(tmp_path: Path) -> None:
    source = made.typical()
    source.accelerometer = made.accelerometer(FIRST + 2_000_037 * np.arange(9, dtype=np.int64))
    path = written(source, tmp_path)
    _change(path, lambda text: text.replace('"modern"', '"modem"'))
    with pytest.raises(InputError, match=r"object 0, offset 0: a comment of tumtools cannot(?s:.*)--salvage"):
        opened(path)
    with opened(path, salvage=True) as sequence:
        assert names_of(sequence) == names_of(source)
        assert "a comment of tumtools cannot be read (its CRC is wrong)" in sequence.info.warnings[0]
        assert [loss.what for loss in sequence.info.not_carried] == [LEFT_OUT]


def _joined(tmp_path: Path) -> list[Record]:
    one, other = made.typical(2), made.typical(2)
    rows = {stream: [(t + 10**9, image) for t, image in rows] for stream, rows in other._images.items()}
    other = made.Made(rows, made.accelerometer([FIRST + 10**9]))
    paths = [written(source, tmp_path / name) for source, name in ((one, "a"), (other, "b"))]
    for file in (paths[1].parent / "made_Images").iterdir():
        file.rename(paths[0].parent / "made_Images" / file.name)
    return [record for path in paths for record in Objects(path)]


def test_rawlogs_that_were_put_together_are_read_with_a_warning(tmp_path: Path) -> None:
    records = _joined(tmp_path)
    with opened(save(tmp_path / "a" / "made" / "made.rawlog", *records)) as sequence:
        assert len(sequence.image_stamps("depth")) == 4
        assert "2 rawlogs of tumtools have been put together" in sequence.info.warnings[0]
        assert sequence.info.digest is None
        assert convert(sequence, tmp_path / "back", "tum").verified
