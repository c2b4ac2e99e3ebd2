# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Damaged files give an error of ours or what is left of them: no traceback, no hang, no memory for lies."""

from __future__ import annotations

import gzip
import resource
import signal
import struct
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np
import pytest

from tests.formats.rawlog import made
from tests.formats.rawlog.made import COLLECTION, image_record, imu, scan, with_depth
from tumtools.errors import TumtoolsError
from tumtools.formats.rawlog.archive import Record
from tumtools.formats.rawlog.classes import CODEC
from tumtools.formats.rawlog.describe import describe
from tumtools.images.codec import pixels_of

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

PLACES = 1000
LIMIT_BYTES = 300 * 2**20
_PIXELS = np.arange(144, dtype=np.uint8).reshape(6, 8, 3)
_POINTS = {name: np.zeros(3, "<f4") for name in "xyz"} | {
    name: np.zeros(3, "<u2") for name in ("pixel_column", "pixel_row")
}
_LABELS = {"label_version": 1, "label_bytes": 1, "label_rows": 2, "label_columns": 2}


def _rich() -> bytes:
    """Objects with every kind of field."""
    counts = np.arange(48, dtype="<u2").reshape(6, 8)
    layer = {"name": "last", "columns": 2, "rows": 1, "values": np.zeros(2, "<u2")}
    labels = {**_LABELS, "labels": np.zeros(4, np.uint8), "label_names": {1: "floor"}}
    full = scan(
        has_points=1, point_count=3, **_POINTS, **with_depth(counts),
        has_intensity=1, intensity=image_record(_PIXELS),
        has_labels=1, **labels, layers=[layer],
    )  # fmt: skip
    old = imu()
    old.version = 3
    records = [
        Record("CObservationComment", 0, {"text": '{"rawlog":{"counts":{}}}', "time": 1}),
        full,
        old,
        Record("CSensoryFrame", 2, {"objects": [imu(), Record(COLLECTION, 0, {"objects": []})]}),
        Record("CRawlog", 1, {"objects": [imu()], "comment": Record("nullptr", 0)}),
    ]
    return b"".join(map(CODEC.encode, records))


def _read(path: Path) -> str | None:
    """Use all of a file; return the message of the error if it is one of ours."""
    describe(path)
    try:
        with made.opened(path, salvage=True) as sequence:
            for frame in sequence.images():
                pixels_of(frame.load())
    except TumtoolsError as error:
        return str(error)
    return None


@contextmanager
def _at_most(seconds: int) -> Iterator[None]:
    """Fail instead of hanging."""

    def stop(*_: object) -> None:
        pytest.fail(f"took more than {seconds} s")

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def test_undamaged_it_is_read_to_its_end(tmp_path: Path) -> None:
    path = tmp_path / "a.rawlog"
    path.write_bytes(_rich())
    assert _read(path) is None
    found = describe(path)
    assert (found.stopped, found.objects, found.inflated_bytes) == (None, 6, len(_rich()))
    assert found.images == {"rgb": 1, "depth": 1}


@pytest.mark.parametrize("packed", [False, True])
def test_truncated_anywhere(packed: bool, tmp_path: Path) -> None:
    data = gzip.compress(_rich(), 1, mtime=0) if packed else _rich()
    path = tmp_path / "a.rawlog"
    with _at_most(60):
        for end in np.linspace(0, len(data) - 1, PLACES, dtype=int).tolist():
            path.write_bytes(data[:end])
            assert _read(path) is None or end < 100, end
            assert describe(path).stopped or not packed


@pytest.mark.parametrize("packed", [False, True])
def test_one_bit_wrong_anywhere(packed: bool, tmp_path: Path) -> None:
    data = bytearray(gzip.compress(_rich(), 1, mtime=0) if packed else _rich())
    path = tmp_path / "a.rawlog"
    stopped = 0
    with _at_most(60):
        for bit in np.random.default_rng(0).integers(0, 8 * len(data), PLACES).tolist():
            data[bit // 8] ^= 1 << bit % 8
            path.write_bytes(data)
            _read(path)
            stopped += describe(path).stopped is not None
            data[bit // 8] ^= 1 << bit % 8
    assert stopped > 50


def test_counts_that_lie_take_no_memory(tmp_path: Path) -> None:
    data = _rich()
    path = tmp_path / "a.rawlog"
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with _at_most(60):
        for offset in range(len(data) - 4):
            for packed in (False, True) if offset % 10 == 0 else (False,):
                wrong = data[:offset] + struct.pack("<I", 2**32 - 1) + data[offset + 4 :]
                path.write_bytes(gzip.compress(wrong + bytes(10**5), 1) if packed else wrong)
                _read(path)
    after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert (after - before) * 1024 < LIMIT_BYTES


def test_a_count_that_only_a_bomb_can_fill_stops_at_the_limit_of_a_field(tmp_path: Path) -> None:
    path = tmp_path / "a.rawlog"
    start = b"\x93CObservationComment\x00" + struct.pack("<I", 2**30)
    path.write_bytes(gzip.compress(start, 1) + gzip.compress(bytes(2**26), 1) * 18)
    stopped = describe(path).stopped
    assert stopped is not None
    assert "a field of 1073741824 bytes" in stopped


def test_external_files_that_are_damaged_name_themselves(tmp_path: Path) -> None:
    path = made.written(made.typical(1), tmp_path)
    generator = np.random.default_rng(0)
    for file in sorted((path.parent / "made_Images").iterdir()):
        data = file.read_bytes()
        for _ in range(100):
            broken = bytearray(data)
            place = int(generator.integers(len(data)))
            broken[place] ^= 1 << int(generator.integers(8))
            file.write_bytes(broken if place % 2 else broken[:place])
            message = _read(path)
            assert message is None or file.name in message
        file.write_bytes(data)
    assert _read(path) is None
