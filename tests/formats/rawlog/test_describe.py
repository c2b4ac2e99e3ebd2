# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What `info` tells of a rawlog."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from tests.formats.rawlog import made
from tests.formats.rawlog.made import FIRST, FRAME_NS, imu, opened, save, written
from tumtools.cli import description, info
from tumtools.formats.rawlog.describe import ClassCount, describe

if TYPE_CHECKING:
    from pathlib import Path


def test_classes_versions_labels_counts_rates_and_times(tmp_path: Path) -> None:
    found = describe(written(made.typical(7), tmp_path, dialect="legacy", compression="none"))
    rows = len(made.typical(7).accelerometer or ())
    assert found.classes == (
        ClassCount("CObservation3DRangeScan", 6, 7),
        ClassCount("CObservationComment", 0, 1),
        ClassCount("CObservationIMU", 2, rows),
    )
    scans = next(sensor for sensor in found.sensors if sensor.label == "KINECT")
    assert (scans.count, scans.first, scans.last) == (7, FIRST, FIRST + 6 * FRAME_NS)
    assert scans.rate_hz == pytest.approx(30, rel=0.01)
    assert found.images == {"rgb": 7, "depth": 7}
    assert (found.compression, found.external_folder, found.stopped) == ("none", "made_Images", None)
    assert found.objects == 8 + rows
    assert found.inflated_bytes == found.stored_bytes == found.path.stat().st_size
    assert found.first == FIRST - 5_000_000


def test_a_damaged_file_is_described_up_to_the_damage(tmp_path: Path) -> None:
    path = save(tmp_path / "a.rawlog", imu(), imu())
    path.write_bytes(path.read_bytes()[:-1])
    found = describe(path)
    assert found.objects == 1
    assert found.stopped is not None
    assert "object 1, offset" in found.stopped


def test_info_shows_it_as_tables(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with opened(written(made.typical(), tmp_path)) as sequence:
        document = description.describe("made", sequence)
        info._print(document)
    details = document["details"]
    assert isinstance(details, dict)
    assert list(details) == ["rawlog", "classes", "sensors"]
    assert details["rawlog"][0]["first"] == str(FIRST - 5_000_000)
    shown = capsys.readouterr().out
    assert "mrpt::obs::CObservation3DRangeScan" in shown
    assert "KINECT_ACC" in shown
