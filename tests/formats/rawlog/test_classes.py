# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Every class and version: what is written is read back equal, and written again the same."""

from __future__ import annotations

import struct
from contextlib import closing
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.formats.rawlog.memory import records_of
from tumtools.errors import InputError, UnsupportedInputError
from tumtools.formats.rawlog import archive, fields
from tumtools.formats.rawlog.archive import Record
from tumtools.formats.rawlog.classes import CLASSES, CODEC
from tumtools.formats.rawlog.compression import Pieces

if TYPE_CHECKING:
    from pathlib import Path

    from tumtools.formats.rawlog.archive import Array, Fields, Value

VERSIONS = [(name, version) for name, entry in CLASSES.items() for version in entry.versions]
SIZES = {
    "rows", "columns", "width", "height", "byte_count", "point_count", "count", "label_rows", "label_columns",
}  # fmt: skip
_LEAVES = ["CPose2D", "CPoint3D", "CMatrixF", "CPose3DQuat"]


def _number(draw: st.DrawFn, item: fields.Field, code: str) -> int | float:
    if item.name in SIZES:
        # Only raw colour images have negative sizes.
        low = -3 if code == "i" and item.name in {"width", "height"} else 0
        return int(draw(st.integers(low, 4)))
    if code in "fd":
        return float(draw(st.floats(width=32 if code == "f" else 64, allow_nan=False)))
    bits = 8 * struct.calcsize("<" + code)
    low, high = (0, 2**bits - 1) if code.isupper() else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    return int(draw(st.integers(low, high)))


def _numbers(draw: st.DrawFn, dtype: str, count: int) -> Array:
    size = np.dtype(dtype).itemsize * count
    return np.frombuffer(draw(st.binary(min_size=size, max_size=size)), dtype)


def _value(draw: st.DrawFn, item: fields.Field, before: Fields, depth: int) -> Value:
    match item.kind:
        case fields.Number(code):
            return _number(draw, item, code)
        case fields.Text():
            return draw(st.binary(max_size=6)).decode("utf-8", "surrogateescape")
        case fields.Block() as kind:
            return _numbers(draw, str(fields._dtype(kind, before)), fields._count(kind, before))
        case fields.Vector(dtype):
            return _numbers(draw, dtype, draw(st.integers(0, 5)))
        case fields.Child():
            return draw(_records(depth + 1))
        case fields.Children():
            return draw(st.lists(_records(depth + 1), max_size=2))
        case fields.Groups(inner):
            count = draw(st.integers(0, 2))
            return [_fields(draw, inner, 0, depth) for _ in range(count)]
        case fields.Names():
            return draw(st.dictionaries(st.integers(0, 63), st.text(max_size=5), max_size=3))


def _fields(draw: st.DrawFn, table: tuple[fields.Field, ...], version: int, depth: int) -> Fields:
    values: Fields = {}
    for item in table:
        if item.since <= version <= item.until and (item.when is None or item.when(values)):
            values[item.name] = _value(draw, item, values, depth)
    return values


@st.composite
def _records(draw: st.DrawFn, depth: int = 0, name: str | None = None, version: int = 0) -> Record:
    """Random objects; those inside of others are small ones, null pointers or empty variants."""
    if name is None:
        name = draw(st.sampled_from([*_LEAVES, archive.NULL, archive.EMPTY]))
        if name in {archive.NULL, archive.EMPTY}:
            return Record(name, 0)
        version = draw(st.sampled_from(CLASSES[name].versions))
    prefix = draw(st.sampled_from(["", "mrpt::obs::"]))
    values = _fields(draw, CLASSES[name].fields, version, depth)
    return Record(prefix + name, version, values, old_framing=depth == 0 and draw(st.booleans()))


def _same(one: object, other: object) -> bool:
    if isinstance(one, Record):
        return (one.name, one.version, one.old_framing) == (
            other.name,
            other.version,
            other.old_framing,
        ) and (_same(one.fields, other.fields))
    if isinstance(one, dict):
        return list(one) == list(other) and all(_same(one[key], other[key]) for key in one)
    if isinstance(one, list):
        return len(one) == len(other) and all(map(_same, one, other))
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and one.tobytes() == other.tobytes()
    return bool(one == other)


@pytest.mark.parametrize(("name", "version"), VERSIONS)
@settings(max_examples=15, deadline=None, suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_any_object_comes_back_equal_and_is_written_the_same_again(
    name: str, version: int, data: st.DataObject
) -> None:
    record = data.draw(_records(name=name, version=version))
    encoded = CODEC.encode(record)
    (back,) = records_of(encoded, flat=False)
    assert _same(record, back)
    assert CODEC.encode(back) == encoded


def test_aliases_and_namespaces_mean_the_same_class() -> None:
    assert {archive.class_of(name) for name in ("CMatrix", "mrpt::math::CMatrixF", "CMatrixF")} == {
        "CMatrixF"
    }
    assert archive.class_of("CMRPTImage") == "CImage"
    assert archive.class_of("CSensorialFrame") == "CSensoryFrame"


def test_flags_keep_the_byte_that_was_there() -> None:
    record = Record("CImage", 9, {"external": 0x5A, "file": "a.png"})
    (back,) = records_of(CODEC.encode(record))
    assert back.fields == record.fields


def test_an_unknown_class_is_named_with_its_object_and_offset() -> None:
    known = CODEC.encode(Record("CObservationComment", 0, {"text": "hi", "time": 0}))
    records = records_of(known + b"\x8fCObservationGPS\x08" + bytes(50))
    assert next(records).text("text") == "hi"
    with pytest.raises(
        UnsupportedInputError, match=r"object 1, offset 36: CObservationGPS version 8"
    ) as caught:
        next(records)
    assert len(known) == 36
    assert "--salvage" in str(caught.value)


def test_an_unknown_version_says_which_are_known() -> None:
    with pytest.raises(UnsupportedInputError, match=r"CObservationIMU version 9.*known: 0 to 4"):
        list(records_of(b"\x8fCObservationIMU\x09" + bytes(300)))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"\xfc" + b"a" * 124, "124 letters"),
        (b"\x80", "0 letters"),
        (b"\x84C\x00Ab\x00", "no class name"),
        (b"\x93CObservationComment\x00\x02\x00\x00\x00hi" + bytes(8) + b"\x87", "0x88, found 0x87"),
        (b"\x93CObservationComment\x00\xff\xff\xff\xff", "4294967295 bytes"),
        (b"", "empty"),
    ],
)
def test_what_is_no_object_is_refused_in_words(data: bytes, message: str) -> None:
    with pytest.raises(InputError, match=message):
        list(records_of(data))


def test_objects_nested_without_end_are_refused() -> None:
    with pytest.raises(InputError, match="nested"):
        list(records_of(b"\x8dCSensoryFrame\x02\x01\x00\x00\x00" * 100))


def test_a_value_that_does_not_fit_the_table_is_not_written() -> None:
    with pytest.raises(ValueError, match=r"values: 3 of float64 expected, not 2"):
        CODEC.encode(Record("CPose2D", 1, {"values": np.zeros(2)}))


@pytest.mark.real
def test_every_reference_file_is_read_to_its_last_byte_and_written_again(real_data: Path) -> None:
    files = sorted((real_data / "rawlog").rglob("*.rawlog"))
    assert len(files) >= 13
    for path in files:
        with closing(Pieces(path)) as pieces:
            data = b"".join(iter(pieces.next, b""))
        assert b"".join(map(CODEC.encode, records_of(data, flat=False))) == data, path.name
