# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Rows of an accelerometer that are read many at a time say what they say one by one."""

from __future__ import annotations

import gzip
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.formats.rawlog import made
from tumtools.errors import InputError
from tumtools.formats.rawlog.archive import Record
from tumtools.formats.rawlog.classes import CODEC
from tumtools.formats.rawlog.objects import Objects
from tumtools.formats.rawlog.runs import TICKS, Run
from tumtools.formats.rawlog.survey import Survey, survey
from tumtools.model.time import ticks_to_stamp

if TYPE_CHECKING:
    from pathlib import Path

CHANNELS = {0: 15, 1: 15, 2: 15, 3: 21, 4: 31}


def imu(version: int, ticks: int, label: str, channels: int, seed: int) -> Record:
    """An inertial observation that has its first channels."""
    count = CHANNELS[version]
    values = np.random.default_rng(seed).normal(0, 9.81, count)
    return Record(
        "CObservationIMU" if version < 4 else "mrpt::obs::CObservationIMU",
        version,
        {
            "sensor_pose": made.pose(),
            "present": (np.arange(count) < channels).astype(np.uint8),
            "time": ticks,
            "values": values.astype("<f4" if version == 0 else "<f8"),
            "label": label,
        },
    )


@st.composite
def rawlogs(draw: st.DrawFn) -> list[Record]:
    """Draw runs of observations that are alike, a scan now and then, and times that are none."""
    records: list[Record] = []
    for number in range(draw(st.integers(1, 4))):
        version, channels = draw(st.sampled_from(sorted(CHANNELS))), draw(st.sampled_from([0, 2, 3, 5]))
        label = draw(st.sampled_from(["ACC", "A\udcff", "ä"]))
        for row in range(draw(st.sampled_from([1, 2, 31, 32, 33, 70]))):
            ticks = made.TICKS + 1000 * (100 * number + row)
            records.append(imu(version, draw(st.sampled_from([ticks] * 30 + [0])), label, channels, row))
        if draw(st.booleans()):
            records.append(made.scan(made.TICKS))
    return records


def one_by_one(path: Path) -> Survey:
    """Survey a rawlog without runs."""
    objects = Objects(path)
    found = Survey(objects)
    try:
        for number, record in enumerate(objects):
            found.add(number, record)
            found.count = number + 1
    except InputError as error:
        found.damage = error
    return found


def contents(found: Survey) -> dict[str, object]:
    """Return all that a survey says, to be compared."""
    return {
        "count": (found.count, found.objects.progress),
        "classes": found.classes,
        "sensors": found.sensors,
        "rows": {
            label: (rows.ticks.tobytes(), rows.values.tobytes())
            for label, rows in found.accelerations.items()
        },
        "not carried": found.not_carried,
        "damage": str(found.damage),
    }


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(records=rawlogs())
def test_runs_say_what_their_objects_say(records: list[Record], tmp_path: Path) -> None:
    path = tmp_path / "a.rawlog"
    path.write_bytes(gzip.compress(b"".join(map(CODEC.encode, records)), 1))
    assert contents(survey(path)) == contents(one_by_one(path))


@pytest.mark.parametrize("version", sorted(CHANNELS))
def test_observations_that_are_alike_are_read_together(version: int, tmp_path: Path) -> None:
    path = tmp_path / "a.rawlog"
    records = [imu(version, made.TICKS + row, "ACC", 3, row) for row in range(100)]
    path.write_bytes(b"".join(map(CODEC.encode, records)))
    first, run = Objects(path).in_runs()
    assert isinstance(first, Record)
    assert isinstance(run, Run)
    assert run.ticks.tolist() == [made.TICKS + row for row in range(1, 100)]
    assert np.array_equal(run.values, [record.array("values") for record in records[1:]])


@pytest.mark.parametrize("place", ["values", "between", "end"])
def test_damage_in_a_run_is_found_where_it_is(place: str, tmp_path: Path) -> None:
    objects = [CODEC.encode(imu(4, made.TICKS + row, "ACC", 3, row)) for row in range(50)]
    if place == "end":
        data = b"".join(objects)[:-5]
    else:
        data = b"".join([*objects[:30], b"\xff" * (7 if place == "between" else 449), *objects[30:]])
    path = tmp_path / "a.rawlog"
    path.write_bytes(data)
    found = survey(path)
    assert found.damage is not None
    assert found.count == (49 if place == "end" else 30)
    assert contents(found) == contents(one_by_one(path))


def test_times_that_can_be_a_stamp_are_in_range() -> None:
    limit = 2**63
    assert -limit < ticks_to_stamp(TICKS.start) < -limit + 200
    assert limit - 200 < ticks_to_stamp(TICKS.stop - 1) < limit
