# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Scans that are compared with the one before say what they say when they are read field by field."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.formats.rawlog import made
from tests.formats.rawlog.test_runs import one_by_one as surveyed_one_by_one
from tumtools.errors import InputError
from tumtools.formats.rawlog.archive import Record
from tumtools.formats.rawlog.classes import CODEC
from tumtools.formats.rawlog.objects import Objects
from tumtools.formats.rawlog.survey import Survey, survey

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

MOVED = replace(made.pose(), fields={"values": np.arange(12.0)})
NAMES = [
    "",
    "1.5_rgb.png",
    "2.5_rgb.png",
    "1.5_depth.bin",
    "2.5_depth.bin",
    "a\udcff.png",
    "CAM",
    "aaaa",
    "a",
]


def image(name: str, version: int = 8) -> Record:
    """An external image."""
    return Record("CImage", version, {"external": 1, "file": name})


def scan(ticks: int, image_file: str, depth_file: str, **changes: object) -> Record:
    """A scan whose images are files."""
    fields: dict[str, object] = {
        "has_intensity": 1,
        "intensity": image(image_file),
        "has_range": 1,
        "rows": 0,
        "columns": 0,
        "range": np.empty(0, "<u2"),
        "range_external": 1,
        "range_file": depth_file,
    }
    return made.scan(ticks, **fields | changes)


def shown(records: Iterable[object]) -> list[object]:
    """Return what records say and where they are, their images too; an error as it is told."""
    found: list[object] = []
    try:
        for record in records:
            assert isinstance(record, Record)
            child = record.child("intensity")
            found.append((record.offset, child and child.offset, CODEC.encode(record), list(record.fields)))
    except InputError as error:
        found.append(str(error))
    return found


def told(found: Survey) -> list[object]:
    """Return what a survey says of scans; pictures are compared by what tells them apart."""
    pictures = [(place.key, place.nbytes, place.picture) for place in found.places]
    shown_pictures = [
        (key, nbytes, one.stream, one.ticks, one.label, one.file, one.name, one.beside)
        for key, nbytes, one in pictures
    ]
    counted = (found.not_carried, found.nameless, found.euclidean, found.cameras_changed, found.classes)
    return [*counted, found.sensors, found.cameras, shown_pictures, str(found.damage), found.count]


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_what_is_compared_is_what_is_read(data: st.DataObject, tmp_path: Path) -> None:
    names = st.sampled_from(NAMES)
    scans = st.builds(
        scan,
        st.sampled_from([0, 1, made.TICKS, made.TICKS + 1, 2**64 - 1]),
        names,
        names,
        label=st.sampled_from(["CAM", "CAB"]),
        points_file=st.sampled_from(["", "1.5_rgb.png"]),
        sensor_pose=st.sampled_from([made.pose(), made.pose(), MOVED]),
        range_is_depth=st.sampled_from([1, 1, 0]),
    )
    others = st.sampled_from([made.scan(), made.imu(), scan(made.TICKS, "a", "b", has_intensity=0)])
    records = data.draw(st.lists(scans | others, min_size=1, max_size=20))
    encoded = bytearray(b"".join(map(CODEC.encode, records)))
    if data.draw(st.booleans()):
        place = data.draw(st.integers(0, len(encoded) - 1))
        encoded[place] ^= data.draw(st.integers(1, 255))
    path = tmp_path / "a.rawlog"
    path.write_bytes(encoded)
    one_by_one = shown(Objects(path))
    with patch("tumtools.formats.rawlog.objects.read_run", return_value=None):
        assert shown(Objects(path).in_runs()) == one_by_one
    assert told(survey(path)) == told(surveyed_one_by_one(path))


def test_scans_that_differ_in_time_and_names_alone_are_not_read_field_by_field(tmp_path: Path) -> None:
    records = [scan(made.TICKS + row, f"{row:03}_rgb.png", f"{row:03}_depth.bin") for row in range(100)]
    path = made.save(tmp_path / "a.rawlog", *records)
    with patch.object(CODEC, "read_body", wraps=CODEC.read_body) as read_body:
        found = [record for record in Objects(path).in_runs() if isinstance(record, Record)]
    top_level = [call for call in read_body.call_args_list if call.args[1].name == records[0].name]
    # Every further one that the latest piece of the file holds in full.
    assert len(top_level) < 10
    assert [record.text("range_file") for record in found] == [f"{row:03}_depth.bin" for row in range(100)]
    assert [record.integer("time") for record in found] == [made.TICKS + row for row in range(100)]


@pytest.mark.parametrize("same", ["1.5_rgb.png", "aaa"])
def test_a_name_that_stands_in_a_scan_twice_is_no_place_to_compare(same: str, tmp_path: Path) -> None:
    """Else the name of the depth file would be read where that of the points is."""
    one = scan(made.TICKS, "x.png", same, points_file=same)
    other = replace(one, fields={**one.fields, "points_file": same[::-1]})
    path = made.save(tmp_path / "a.rawlog", one, other, one)
    found = [record for record in Objects(path).in_runs() if isinstance(record, Record)]
    assert [record.text("range_file") for record in found] == [same] * 3
    assert [record.text("points_file") for record in found] == [same, same[::-1], same]
