# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What observations hold that the model has no place for is counted, and nothing else is."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from tests.formats.rawlog import made
from tumtools.formats.rawlog.archive import Record
from tumtools.formats.rawlog.observations import not_carried

if TYPE_CHECKING:
    from pathlib import Path

POSE = np.array([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1], "<f8")
MOVED, TURNED = POSE.copy(), np.array([0, 0, 0, 0, 1, 0, -1, 0, 0, 0, 0, 1], "<f8")
MOVED[1] = 0.05
LABELS = {
    "has_labels": 1,
    "label_version": 1,
    "label_bytes": 1,
    "label_rows": 1,
    "label_columns": 1,
    "labels": np.ones(1, np.uint8),
    "label_names": {},
}
LAYER = {"name": "second return", "columns": 2, "rows": 1, "values": np.ones(2, "<u2")}


def _pose(values: np.ndarray) -> Record:
    return Record("mrpt::poses::CPose3D", 3, {"values": values})


KINDS: dict[str, dict[str, Any]] = {
    "pose of the sensor on the robot": {"sensor_pose": _pose(MOVED)},
    "point cloud": {"has_points": 1, "points_external": 1, "points_file": "a_3D.bin"},
    "pixel labels": LABELS,
    "extra range layers": {"layers": [LAYER]},
    "position of the colour camera in the depth camera": {"intensity_pose": _pose(MOVED)},
}


@pytest.mark.parametrize("what", KINDS)
def test_each_thing_beside_the_images_is_named(what: str) -> None:
    assert list(not_carried(made.scan(**KINDS[what]))) == [what]


def test_a_sensor_that_is_turned_has_a_pose_and_the_turn_between_cameras_is_none() -> None:
    assert list(not_carried(made.scan(sensor_pose=_pose(TURNED)))) == ["pose of the sensor on the robot"]
    assert list(not_carried(made.scan(intensity_pose=_pose(TURNED)))) == []


def test_an_ordinary_scan_has_nothing_beside_its_images() -> None:
    assert list(not_carried(made.scan())) == []


def test_images_of_a_sensor_that_was_not_chosen_are_counted(tmp_path: Path) -> None:
    depth = made.with_depth(np.ones((2, 2), np.uint16))
    scans = [made.scan(made.TICKS + 10_000 * n, label, **depth) for n, label in enumerate("AAB")]
    path = made.save(tmp_path / "a.rawlog", *scans)
    for topics, label, count in (({"depth": "A"}, "B", 1), ({"depth": "B"}, "A", 2)):
        with made.opened(path, topics=topics) as sequence:
            (loss,) = sequence.info.not_carried
            assert (loss.stream, loss.what, loss.count) == (label, "depth image", count)
