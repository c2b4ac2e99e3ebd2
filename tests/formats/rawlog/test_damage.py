# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Damaged files give an error of ours or what is left of them: no traceback, no hang, no memory for lies."""

from __future__ import annotations

import gzip
import resource
import signal
import struct
import subprocess
import sys
import tracemalloc
import zlib
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


def test_comments_take_no_memory_however_many_and_long_they_are(tmp_path: Path) -> None:
    path = tmp_path / "a.rawlog"
    text = "a" * 2**22
    one = CODEC.encode(Record("CObservationComment", 0, {"text": text, "time": 5, "label": ""}))
    path.write_bytes(gzip.compress(one, 1) * 30)
    tracemalloc.start()
    found = describe(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert found.classes[0].count == 30
    assert found.comment == "a" * 2**20
    assert peak < 40 * 2**20


def test_an_object_of_many_large_fields_stops_at_the_limit_of_an_object(tmp_path: Path) -> None:
    path = tmp_path / "a.rawlog"
    start = CODEC.encode(scan())
    points = 15 * 2**20
    head = start[: start.index(b"\x88", 100) + 1]  # up to the pose of the sensor
    body = struct.pack("<BI", 1, points)
    path.write_bytes(gzip.compress(head + body, 1) + gzip.compress(bytes(2**26), 1) * 3)
    stopped = describe(path).stopped
    assert stopped is not None
    assert "an object of more than 134217728 bytes" in stopped


def _large_depth(side: int) -> bytes:
    packer = zlib.compressobj(1, zlib.DEFLATED, 31)
    row = b"\x10\x27" * side
    parts = [packer.compress(struct.pack("<II", side, side)), *(packer.compress(row) for _ in range(side))]
    return b"".join([*parts, packer.flush()])


def _peak(path: Path, *arguments: str) -> tuple[int, str, int]:
    """Run the program; return its exit code, what it said, and the memory it took in bytes."""
    # Not ru_maxrss, which begins with that of the process that has started this one.
    code = (
        "import sys; from tumtools.cli.main import run; code = run(sys.argv[1:]); "
        "status = open('/proc/self/status').read(); "
        "print('peak', status.split('VmHWM:')[1].split()[0], file=sys.stderr); sys.exit(code)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, arguments[0], str(path), *arguments[1:]],
        capture_output=True, text=True, check=False, timeout=120,
    )  # fmt: skip
    return done.returncode, done.stdout + done.stderr, 1024 * int(done.stderr.rsplit("peak ", 1)[1])


def _six_large(tmp_path: Path, side: int) -> Path:
    folder = tmp_path / "large"
    (folder / "large_Images").mkdir(parents=True)
    data = _large_depth(side)
    names = [f"{number}.bin" for number in range(6)]
    for name in names:
        (folder / "large_Images" / name).write_bytes(data)
    empty = {"has_range": 1, "range_external": 1, "rows": 0, "columns": 0, "range": np.empty(0, "<u2")}
    scans = (scan(made.TICKS + n * 333_333, **empty, range_file=name) for n, name in enumerate(names))
    made.save(folder / "large.rawlog", *scans)
    return folder


def test_images_of_more_pixels_than_any_camera_has_are_refused(tmp_path: Path) -> None:
    folder = _six_large(tmp_path, 8000)
    code, said, peak = _peak(folder, "convert", str(tmp_path / "out"), "--to", "tum")
    assert code == 4
    assert "0.bin: the depth file announces an image of 8000x8000 pixels; images of more than 12 mega" in said
    assert peak < LIMIT_BYTES // 3


def test_as_many_large_images_are_worked_on_as_there_is_room_for(tmp_path: Path) -> None:
    folder = _six_large(tmp_path, 3500)
    for arguments in (["digest"], ["validate"], ["convert", str(tmp_path / "out"), "--to", "tum"]):
        code, said, peak = _peak(folder, *arguments, "--jobs", "4")
        assert code == 0, said
        assert peak < LIMIT_BYTES, arguments


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
