# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What MRPT's rawlog-edit makes of our rawlogs is read with the stamps that are still known, or a warning."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tests.formats.rawlog import made
from tests.formats.rawlog.made import FIRST, image_record, names_of, opened, save, written
from tumtools.convert import convert
from tumtools.formats.rawlog.objects import Objects
from tumtools.model.text import TextLayout
from tumtools.model.time import format_stamp

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from tumtools.formats.rawlog.archive import Record

TICKS_LATER = 1_000_000_000
NS_LATER = 100 * TICKS_LATER


def _edit(path: Path, change: Callable[[Record], object]) -> Path:
    """Rewrite a rawlog, each of its observations changed; without those for which False is returned."""
    records = list(Objects(path))
    return save(path, *(record for record in records if change(record) is not False))


def _later(record: Record) -> None:
    """--remap-timestamps: all times, and nothing else."""
    if record.type != "CObservationComment":
        record.fields["time"] = record.integer("time") + TICKS_LATER


def _embed(record: Record) -> None:
    """--de-externalize: the name of the depth file stays, that of the colour file does not."""
    if record.type == "CObservation3DRangeScan":
        counts = np.arange(48, dtype="<u2")
        record.fields |= {"range_external": 0, "has_range": 1, "rows": 6, "columns": 8, "range": counts}
        record.fields["intensity"] = image_record(np.zeros((6, 8, 3), np.uint8))


def _no_comment(record: Record) -> bool:
    """--keep-label: comments have none."""
    return record.type != "CObservationComment"


def _warnings(path: Path) -> str:
    with opened(path) as sequence:
        return "\n".join(sequence.info.warnings)


def _stamps(path: Path) -> dict[str, list[int]]:
    with opened(path) as sequence:
        return {stream: [stamp for stamp, _ in rows] for stream, rows in names_of(sequence).items()}


def test_times_that_were_changed_hold_for_images_as_for_accelerations(tmp_path: Path) -> None:
    source = made.typical()
    source.accelerometer = made.accelerometer(FIRST + 2_000_037 * np.arange(50, dtype=np.int64))
    literal = f"{format_stamp(FIRST)} rgb/other.png"
    source.info = replace(source.info, text={"rgb": TextLayout(overrides={0: literal})})
    path = _edit(written(source, tmp_path), _later)
    with opened(path) as sequence:
        colour = sequence.image_stamps("rgb")
        assert colour.tolist() == (source.image_stamps("rgb") + NS_LATER).tolist()
        assert sequence.image_stamps("depth").tolist() == colour.tolist()
        assert sequence.accelerometer is not None
        assert (
            sequence.accelerometer.stamps.tolist()
            == ((source.accelerometer.stamps + NS_LATER) // 100 * 100).tolist()
        )
        assert sequence.info.text["rgb"].overrides == {}
        assert any("the times of 6 of the 6 images are not" in text for text in sequence.info.warnings)
        report = convert(sequence, tmp_path / "back", "tum")
    assert report.verified


def test_a_depth_image_that_was_embedded_keeps_its_own_stamp(tmp_path: Path) -> None:
    path = written(made.typical(), tmp_path)
    before = _stamps(path)
    assert before["rgb"] != before["depth"]
    _edit(path, _embed)
    assert _stamps(path) == before
    assert _warnings(path) == ""


def test_stamps_below_a_tick_are_missed_when_the_name_of_the_file_is_gone(tmp_path: Path) -> None:
    image = made.colour()
    source = made.Made({"rgb": [(FIRST + 37, image)]}, text={"rgb": TextLayout(stamp_decimals=9)})
    path = written(source, tmp_path)
    assert _stamps(path) == {"rgb": [FIRST + 37]}
    _edit(path, lambda record: record.fields.update(intensity=image_record(np.zeros((6, 8, 3), np.uint8))))
    assert _stamps(path) == {"rgb": [FIRST]}
    assert "the stamps of embedded rgb images are known to 100 ns only" in _warnings(path)


def test_without_the_comment_the_names_of_the_files_tell_the_stamps(tmp_path: Path) -> None:
    path = written(made.typical(), tmp_path)
    before = _stamps(path)
    _edit(path, _no_comment)
    assert _stamps(path) == before


def test_without_the_comment_accelerations_at_the_time_of_a_scan_stay_there(tmp_path: Path) -> None:
    source = made.typical()
    source.accelerometer = made.accelerometer(source.image_stamps("rgb"))
    with opened(_edit(written(source, tmp_path), _no_comment)) as sequence:
        assert sequence.accelerometer is not None
        assert sequence.accelerometer.stamps.tolist() == source.image_stamps("rgb").tolist()


def test_the_stamps_of_depth_files_that_were_renamed_are_missed(tmp_path: Path) -> None:
    path = written(made.typical(), tmp_path)

    def rename(record: Record) -> None:
        """--externalize after --de-externalize: names of MRPT's own."""
        if record.type == "CObservation3DRangeScan":
            new = f"3DCAM_KINECT_{record.integer('time')}_RANGES.bin"
            folder = path.parent / "made_Images"
            (folder / record.text("range_file")).rename(folder / new)
            record.fields["range_file"] = new

    _edit(path, rename)
    stamps = _stamps(path)
    assert stamps["depth"] == stamps["rgb"]
    assert "the stamps of 3 depth images are lost" in _warnings(path)


def test_images_that_share_one_file_are_warned_of(tmp_path: Path) -> None:
    path = written(made.typical(), tmp_path)
    first = next(iter((path.parent / "made_Images").glob("*_rgb.png"))).name

    def rename(record: Record) -> None:
        """--rename-externals of MRPT 2.5.8 gives all of them the same name."""
        image = record.child("intensity")
        if image is not None:
            image.fields["file"] = first

    _edit(path, rename)
    assert f"3 rgb images are the one file {first!r}" in _warnings(path)


def test_a_ground_truth_that_was_left_behind_is_warned_of_and_a_loss(tmp_path: Path) -> None:
    path = written(made.typical(), tmp_path)
    (path.parent / "groundtruth.txt").unlink()
    with opened(path) as sequence:
        assert "groundtruth.txt: the file is missing" in sequence.info.warnings[0]
        report = convert(sequence, tmp_path / "back", "tum")
    assert report.verified
    assert [(loss.stream, loss.count) for loss in report.losses] == [("groundtruth", 1)]
    assert not (tmp_path / "back" / "groundtruth.txt").exists()
    source = made.typical()
    source.groundtruth = None
    assert _warnings(written(source, tmp_path / "without")) == ""
