# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Rawlogs whose depth images have different units, or are counts and metres, come out right everywhere."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from tests.formats.rawlog import made
from tests.formats.rawlog.made import TICKS, opened, save, scan, with_depth
from tumtools.convert import ConvertOptions, convert
from tumtools.digest import depth_in_metres
from tumtools.formats.rawlog.archive import Record
from tumtools.sources import open_source

if TYPE_CHECKING:
    from pathlib import Path

FRAME_TICKS = 333_333
MILLIMETRES = np.arange(48, dtype="<u2").reshape(6, 8) * 20


def _counts(number: int, units: int) -> Record:
    fields = with_depth(MILLIMETRES * np.uint16(units // 1000))
    return scan(TICKS + number * FRAME_TICKS, range_units=float(np.float32(1 / units)), **fields)


def _metres(number: int) -> Record:
    values = (MILLIMETRES / 1000).astype("<f4").reshape(-1)
    matrix = Record("CMatrix", 0, {"rows": 6, "columns": 8, "values": values})
    fields = scan(TICKS + number * FRAME_TICKS, has_range=1, range_matrix=matrix).fields
    return Record("CObservation3DRangeScan", 8, {**fields, "camera": _old(), "camera_intensity": _old()})


def _old() -> Record:
    return Record("TCamera", 4, made.camera().fields)


MIXED = {
    "units": [_counts(0, 5000), _counts(1, 1000)],
    "units the other way round": [_counts(0, 1000), _counts(1, 5000)],
    "counts and metres": [_counts(0, 5000), _metres(1)],
    "metres and counts": [_metres(0), _counts(1, 1000)],
}


@pytest.mark.parametrize("name", MIXED)
@pytest.mark.parametrize("to", ["tum", "mcap", "rosbag1", "rosbag2", "rawlog"])
def test_every_image_has_its_own_depth(name: str, to: str, tmp_path: Path) -> None:
    target = tmp_path / {"mcap": "out.mcap", "rosbag1": "out.bag"}.get(to, "out")
    with opened(save(tmp_path / "a.rawlog", *MIXED[name])) as sequence:
        report = convert(sequence, target, to)
        assert report.verified
        dry = convert(sequence, tmp_path / "dry", "tum", options=ConvertOptions(dry_run=True))
    assert not [loss for loss in (*report.losses, *dry.losses) if "pixels" in loss.alters]
    with open_source(target) as result:
        for frame in result.images(["depth"]):
            np.testing.assert_allclose(depth_in_metres(frame.load()), MILLIMETRES / 1000, atol=1e-6)
