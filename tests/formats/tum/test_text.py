# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Text files are parsed to columns and rendered to the same bytes, however awkward they are."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from tumtools.errors import InputError
from tumtools.formats.tum.text import Table, fit_layout, parse, render
from tumtools.model.text import TextLayout, default_layout
from tumtools.model.time import parse_stamp

PUBLISHED = (
    b"# ground truth trajectory\n# file: 'rgbd_dataset_freiburg1_xyz.bag'\n# timestamp tx ty tz qx qy qz qw\n"
    b"1305031098.6659 1.3563 0.6305 1.6380 0.6132 0.5962 -0.3311 -0.3986\n"
    b"1305031098.6758 1.3543 0.6306 1.6360 0.6129 0.5966 -0.3316 -0.3980\n"
)


def _again(table: Table, stream: str) -> bytes:
    return render(table.layout, stream, table.stamps, table.values)


def _ends_lines_with_cr(data: bytes) -> bool:
    """Tell whether a file is refused for its line ends, see below."""
    return b"\n" not in data and b"\r" in data.rstrip(b"\r")


STAMPS = st.one_of(
    st.integers(0, 2 * 10**15).map(lambda n: f"{n // 10**6}.{n % 10**6:06d}"),
    st.integers(0, 2 * 10**18).map(lambda n: f"{n // 10**9}.{n % 10**9:09d}"),
    st.integers(-(10**9), 2 * 10**9).map(str),
    st.from_regex(r"\A-?[0-9]{1,9}\.[0-9]{0,14}\Z"),
    st.floats(1e-12, 2e9).map(lambda x: f"{x:.15e}"),
)
VALUES = st.one_of(
    st.floats().map(repr),
    st.floats(-100, 100).map(lambda x: f"{x:.4f}"),
    st.floats(-100, 100).map(lambda x: f"{x:.6e}"),
    st.sampled_from(["NaN", "nan", "-0.0000", "-0", "+1", "1.", ".5", "007", "1E5", "inf", "-Infinity"]),
    st.integers(1, 400).map(lambda n: "0." + "1" * n),
)
SEPARATORS = st.one_of(st.just(" "), st.sampled_from(["\t", ",", ", ", "  ", " ,\t", "\x0b"]))
COMMENTS = st.one_of(
    st.sampled_from(
        [b"", b"#", b"# comment", b"  # indented", b"   ", b"\t", b"#\xff\xfe\x80 not UTF-8", b"#\r"]
    ),
    st.binary(max_size=8).map(lambda data: b"#" + data.replace(b"\n", b"").replace(b"\0", b"")),
)
NEWLINES = st.sampled_from([b"\n", b"\n", b"\n", b"\r\n"])


@st.composite
def text_files(draw: st.DrawFn, columns: int) -> tuple[bytes, int]:
    """Make up a file and the number of its rows."""
    separator = draw(SEPARATORS)
    newline = draw(NEWLINES)
    mixed = draw(st.booleans())
    lines = draw(st.lists(COMMENTS, max_size=3))
    rows = draw(st.integers(0, 4))
    for row in range(rows):
        fields = [draw(STAMPS), *(draw(VALUES) for _ in range(columns))]
        if not columns:
            fields.append(draw(st.sampled_from([f"rgb/{fields[0]}.png", "rgb/a.png", f"x/{row}.png"])))
        lines.append((draw(SEPARATORS) if mixed else separator).join(fields).encode())
        lines += draw(st.lists(COMMENTS, max_size=2)) if mixed else []
    data = b"".join(line + (draw(NEWLINES) if mixed else newline) for line in lines)
    if lines and draw(st.booleans()):
        data = data.removesuffix(b"\n")
    if draw(st.booleans()):
        data = b"\xef\xbb\xbf" + data
    return data, rows


@given(text_files(7))
@example((PUBLISHED, 2))
@example((b"\xef\xbb\xbf\n1 1 2 3 4 5 6 7\n", 1))
@example((b"1 1 2 3 4 5 6 7\r\n2 1 2 3 4 5 6 7\n3 1 2 3 4 5 6 7\r\n", 3))
@example((b"1 1 2 3 4 5 6 7\r\n2 1 2 3 4 5 6 7", 2))
def test_a_trajectory_is_rendered_to_the_same_bytes(file: tuple[bytes, int]) -> None:
    data, rows = file
    assume(not _ends_lines_with_cr(data))
    table = parse(data, "groundtruth", "x.txt")
    assert len(table.stamps) == len(table.lines) == rows
    assert _again(table, "groundtruth") == data


@given(text_files(0))
@example((b"1.000000 rgb/1.000000.png\r\n", 1))
@example((b"0.000000 rgb/0.000000.png\r\n0.000000 rgb/0.000000.png\r", 2))
@example((b"1.000000 rgb/1.000000.png\r\n2.000000 rgb/2.000000.png", 2))
def test_a_list_of_images_is_rendered_to_the_same_bytes(file: tuple[bytes, int]) -> None:
    data, rows = file
    assume(not _ends_lines_with_cr(data))
    table = parse(data, "rgb", "rgb.txt")
    assert len(table.names) == len(table.stamps) == rows
    assert _again(table, "rgb") == data


@given(text_files(3))
@example((b"1.000000 0.0 0.0 0.0\r\n2.000000 0.0 0.0 0.0\r", 2))
@example((b"0.000000 0.0 0.0 0.0\n0.000000001 0.0 0.0 0.0\n", 2))
def test_a_fitted_layout_prints_the_same_bytes(file: tuple[bytes, int]) -> None:
    data, _ = file
    assume(not _ends_lines_with_cr(data))
    table = parse(data, "accelerometer", "x.txt")
    fitted = fit_layout(table.layout, table.stamps, table.values)
    assert render(fitted, "accelerometer", table.stamps, table.values) == data


@given(
    st.lists(st.tuples(st.integers(-(2**62), 2**62), st.tuples(*[st.floats()] * 3)), max_size=5),
    st.sampled_from(["%.4f", "%.2e", "%r"]),
    st.integers(0, 9),
)
def test_a_fitted_layout_prints_any_values_exactly(
    rows: list[tuple[int, tuple[float, float, float]]], value_format: str, decimals: int
) -> None:
    stamps = np.array([stamp for stamp, _ in rows], np.int64)
    values = np.array([numbers for _, numbers in rows], np.float64).reshape(len(rows), 3)
    layout = fit_layout(TextLayout(stamp_decimals=decimals, value_format=value_format), stamps, values)
    table = parse(render(layout, "accelerometer", stamps, values), "accelerometer", "x.txt")
    assert table.stamps.tolist() == stamps.tolist()
    assert np.array_equal(table.values, values, equal_nan=True)
    assert (np.signbit(table.values) == np.signbit(values))[~np.isnan(values)].all()


def test_the_published_layout_needs_no_overrides() -> None:
    table = parse(PUBLISHED, "groundtruth", "x.txt")
    assert table.layout == default_layout("groundtruth", "rgbd_dataset_freiburg1_xyz")
    assert table.stamps[0] == 1305031098665900000
    assert table.values[1].tolist() == [1.3543, 0.6306, 1.6360, 0.6129, 0.5966, -0.3316, -0.3980]
    assert table.lines.tolist() == [4, 5]


def test_stamps_before_1970_and_below_a_nanosecond() -> None:
    data = b"-1.5 1 2 3\n0.1234567891234 4 5 6\n"
    table = parse(data, "accelerometer", "x.txt")
    assert table.stamps.tolist() == [-1_500_000_000, 123_456_789]
    assert _again(table, "accelerometer") == data


def test_a_negative_zero_and_nan_keep_their_values() -> None:
    table = parse(b"1.000000 -0.0000 NaN nan\n", "accelerometer", "x.txt")
    assert math.copysign(1, table.values[0, 0]) == -1
    assert np.isnan(table.values[0, 1:]).all()


def test_line_numbers_count_comments_and_blank_lines() -> None:
    table = parse(b"# a\n\n1 1 2 3\n# b\n2 1 2 3\n", "accelerometer", "x.txt")
    assert table.lines.tolist() == [3, 5]


def test_a_header_without_its_hash_is_kept_and_named() -> None:
    data = b"timestamp ax ay az\n1 1 2 3\n"
    table = parse(data, "accelerometer", "x.txt")
    assert [(problem.line, problem.is_header) for problem in table.problems] == [(1, True)]
    assert _again(table, "accelerometer") == data


@pytest.mark.parametrize(
    ("data", "line", "said"),
    [
        (b"# x\n1 2 3 4\nnonsense\n", 3, "columns"),
        (b"1 2 3\n", 1, "3 columns instead of 4|expected 'timestamp ax ay az'"),
        (b"1 2 3 4 5\n", 1, "columns"),
        (b"1 2 3 4\n2 2 3 x\n", 2, "not a number: 'x'"),
        (b"1 2 3 4\n2 2 3 1_0\n", 2, "not a number: '1_0'"),
        ("1 2 3 ٤\n".encode(), 1, "not a number"),
        (b"yesterday 2 3 4\n", 1, "not a number of seconds: 'yesterday'"),
        (b"1 2 3 4\ntimestamp 2 3 4\n", 2, "not a number of seconds"),
        (b"1305031102175304000 2 3 4\n", 1, "beyond the year 2262"),
        (b"-1305031102175304000 2 3 4\n", 1, "before the year 1678"),
        (b"1305031102175 2 3 4\n", 1, "rather milliseconds: divide by 1e3"),
        (b"1305031102175304 2 3 4\n", 1, "rather microseconds: divide by 1e6"),
        (b"1 2 3 4\n" * 100 + b"2 3 \0 4\n", 101, "not a number"),
    ],
)
def test_a_line_that_is_no_row_is_refused_with_its_number(data: bytes, line: int, said: str) -> None:
    with pytest.raises(InputError, match=said) as caught:
        parse(data, "accelerometer", "dir/accelerometer.txt")
    assert caught.value.path == "dir/accelerometer.txt"
    assert caught.value.location == f"line {line}"
    assert "expected 'timestamp ax ay az'" in str(caught.value)


@pytest.mark.parametrize(
    ("data", "said"),
    [
        ("# x\n1 2 3 4\n".encode("utf-16"), "not UTF-8"),
        ("1 2 3 4\n".encode("utf-16-le"), "not UTF-8"),
        (b"\x89PNG\r\n\x1a\n\0\0\0", "not UTF-8"),
        (b"# x\r1 2 3 4\r", "CR alone"),
    ],
)
def test_what_is_no_text_is_refused(data: bytes, said: str) -> None:
    with pytest.raises(InputError, match=said) as caught:
        parse(data, "accelerometer", "x.txt")
    assert caught.value.hint


def test_a_list_line_without_a_file_name_is_refused() -> None:
    with pytest.raises(InputError, match="a stamp without a file name"):
        parse(b"1.5\n", "rgb", "rgb.txt")


@given(text_files(3), st.data())
def test_a_choice_of_rows_keeps_their_text(file: tuple[bytes, int], data: st.DataObject) -> None:
    text, rows = file
    assume(not _ends_lines_with_cr(text))
    table = parse(text, "accelerometer", "x.txt")
    chosen = data.draw(st.lists(st.integers(0, rows - 1), unique=True).map(sorted)) if rows else []
    layout = table.layout.select(chosen)
    again = parse(
        render(layout, "accelerometer", table.stamps[chosen], table.values[chosen]), "accelerometer", "y"
    )
    assert again.stamps.tolist() == table.stamps[chosen].tolist()
    assert np.array_equal(again.values, table.values[chosen], equal_nan=True)


def test_mixed_separators_and_stamps_are_understood() -> None:
    table = parse(b"1.5,1,2,3\n2.25\t1 2,  3\n", "accelerometer", "x.txt")
    assert table.stamps.tolist() == [parse_stamp("1.5"), parse_stamp("2.25")]
    assert table.values.tolist() == [[1, 2, 3], [1, 2, 3]]


def test_byte_order_marks_before_rows_survive_when_rows_are_taken_out() -> None:
    data = "\ufeff1.5 1 2 3 0 0 0 1\n\ufeff2.5 1 2 3 0 0 0 1\n".encode()
    table = parse(data, "groundtruth", "x")
    assert _again(table, "groundtruth") == data
    rest = render(table.layout.select([1]), "groundtruth", table.stamps[1:], table.values[1:])
    again = parse(rest, "groundtruth", "x")
    assert again.stamps.tolist() == [2_500_000_000]
    assert _again(again, "groundtruth") == rest
