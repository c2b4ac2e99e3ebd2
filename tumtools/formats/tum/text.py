# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The text files of the benchmark: parse to columns and a layout, render back to the same bytes.

A file that looks like one written by a program is parsed and rendered in a few C calls, and the rendering
compared with the file; that comparison is the proof that the layout reproduces it. Whatever differs goes
through a line by line parser, which keeps literally what the layout does not reproduce.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from itertools import chain
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.errors import InputError
from tumtools.model.text import SHORTEST, TextLayout
from tumtools.model.time import MAX_DECIMALS, decimals_needed, format_stamp, parse_stamp, parse_stamps

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    import numpy.typing as npt

VALUES_PER_ROW: Final = {"groundtruth": 7, "accelerometer": 3}
"""Numbers after the stamp; files of other streams are image lists."""
COLUMNS: Final = {
    "groundtruth": "timestamp tx ty tz qx qy qz qw",
    "accelerometer": "timestamp ax ay az",
    "list": "timestamp filename",
}

_SEPARATORS = re.compile(r"[,\s]+", re.ASCII)
_BEFORE_ROW = re.compile(r"^[\s\ufeff]+")
_FIXED = re.compile(r"[+-]?\d+\.(\d+)", re.ASCII)
_SCIENTIFIC = re.compile(r"[+-]?\d\.(\d+)e[+-]\d\d", re.ASCII)
_MAX_VALUE_DECIMALS: Final = 30
"""More are never printed on purpose; such a value is kept literally."""
_UTF16_MARKS = (b"\xff\xfe", b"\xfe\xff")
_BOM = "\ufeff"
_NAME_IN_HEADER: Final = re.compile(r"# file: '([\w.+-]+)\.bag'\s*")


@dataclass(frozen=True, slots=True)
class Problem:
    """A line that could not be read as a row.

    Attributes:
        line: Line number, 1 = first.
        message: What is wrong with it and what was expected.
        is_header: It is a header line that lost its `#`; harmless, and kept.
        text: The line.

    """

    line: int
    message: str
    is_header: bool = False
    text: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """A parsed text file.

    Attributes:
        stamps: Nanoseconds, int64, shape [n], in file order.
        values: float64, shape [n, k]; k = 0 for image lists.
        names: File names of an image list, n of them; empty for the others.
        lines: Line number of each row, int64, shape [n].
        layout: How to render the rows to the same bytes.
        problems: Lines that are no rows.

    """

    stamps: npt.NDArray[np.int64]
    values: npt.NDArray[np.float64]
    names: tuple[str, ...]
    lines: npt.NDArray[np.int64]
    layout: TextLayout
    problems: tuple[Problem, ...] = ()


def parse(data: bytes, stream: str, path: str, *, tolerant: bool = False) -> Table:
    """Parse the text file of a stream.

    Fields are separated by blanks, tabs or commas; lines that begin with `#` and blank lines are no rows.

    Args:
        data: The file.
        stream: Name of the stream; decides the columns.
        path: For messages.
        tolerant: Collect lines that cannot be read in `Table.problems` instead of failing.

    Raises:
        InputError: With the line, what was found and what was expected.

    """
    if data.startswith(_UTF16_MARKS) or b"\0" in data[:512]:
        raise InputError(
            "this is not UTF-8 text (UTF-16 or binary)", path=path, location="line 1", hint="save it as UTF-8"
        )
    if b"\n" not in data and b"\r" in data.rstrip(b"\r"):
        raise InputError(
            "the lines end with CR alone", path=path, location="line 1", hint="save it with LF line ends"
        )
    table = _parse_uniform(data, stream) or _parse_lines(data, stream)
    for problem in table.problems:
        if not problem.is_header and not tolerant:
            raise InputError(problem.message, path=path, location=f"line {problem.line}")
    return table


def _parse_uniform(data: bytes, stream: str) -> Table | None:
    """Parse a file whose rows all look like its first, or return None."""
    head_end = 0
    while data.startswith(b"#", head_end):
        head_end = data.find(b"\n", head_end) + 1
        if not head_end:
            return None
    body = data[head_end:]
    row_end = body.find(b"\n")
    if row_end < 0:
        return None
    layout = _layout_of_row(body[: row_end + 1].decode("utf-8", "surrogateescape"), stream)
    if layout is None:
        return None
    layout = replace(layout, head=data[:head_end].decode("utf-8", "surrogateescape"))
    width = VALUES_PER_ROW.get(stream, 1) + 1
    tokens = body.replace(layout.separator.encode(), b" ").split()
    rows, rest = divmod(len(tokens), width)
    if rest:
        return None
    try:
        stamps = parse_stamps(np.array(tokens[::width]))
        if stream in VALUES_PER_ROW:
            names: tuple[str, ...] = ()
            numbers = np.fromiter(map(float, tokens), np.float64, len(tokens))
            values = np.ascontiguousarray(numbers.reshape(rows, width)[:, 1:])
        else:
            names = tuple(token.decode() for token in tokens[1::2])
            values = np.empty((rows, 0))
        rendered = render(layout, stream, stamps, values)
    except ValueError:
        return None
    if rendered != data or _finer(layout, stamps).any():
        return None
    first = layout.head.count("\n") + 1
    return Table(stamps, values, names, np.arange(first, first + rows), layout)


def _layout_of_row(row: str, stream: str) -> TextLayout | None:
    """Tell the layout from one row, with its line end; None if it is no row."""
    newline = "\r\n" if row.endswith("\r\n") else "\n"
    text = row.rstrip("\r\n")
    fields = [field for field in _SEPARATORS.split(text) if field]
    gaps = _SEPARATORS.findall(text.strip())
    if len(fields) < 2 or not gaps:  # noqa: PLR2004 - a stamp and something
        return None
    stamp = _FIXED.fullmatch(fields[0])
    decimals = min(len(stamp[1]), MAX_DECIMALS) if stamp else 6
    value_format = _format_of_value(fields[1]) if stream in VALUES_PER_ROW else "%.6f"
    return TextLayout(stamp_decimals=decimals, value_format=value_format, separator=gaps[0], newline=newline)


def _format_of_value(token: str) -> str:
    for pattern, letter in ((_FIXED, "f"), (_SCIENTIFIC, "e")):
        if (match := pattern.fullmatch(token)) and len(match[1]) <= _MAX_VALUE_DECIMALS:
            return f"%.{len(match[1])}{letter}"
    return SHORTEST


def _parse_lines(data: bytes, stream: str) -> Table:
    """Parse line by line, keeping literally what the layout does not reproduce."""
    text = data.decode("utf-8", "surrogateescape")
    lines = text.split("\n")
    final_newline = lines[-1] == ""
    if final_newline:
        lines.pop()
    stamps: list[int] = []
    values: list[list[float]] = []
    names: list[str] = []
    numbers: list[int] = []
    raw: list[str] = []
    problems: list[Problem] = []
    pending: list[str] = []
    head: str | None = None
    layout: TextLayout | None = None
    for number, line in enumerate(lines, 1):
        stripped = _bare(line)
        if stripped and not stripped.startswith("#"):
            try:
                stamp, numbers_of_row, name = parse_row(stripped, stream)
            except ValueError as error:
                problems.append(_problem(number, stripped, stream, str(error), not stamps))
            else:
                if head is None:
                    head = "".join(f"{text}\n" for text in pending)
                    pending = []
                    if line.startswith(_BOM):
                        head += _BOM
                        line = line.removeprefix(_BOM)  # noqa: PLW2901 - the mark belongs to the head
                    layout = _layout_of_row(line + "\n", stream)
                stamps.append(stamp)
                values.append(numbers_of_row)
                names.extend(name)
                numbers.append(number)
                raw.append("\n".join([*pending, line]))
                pending = []
                continue
        pending.append(line)
    if head is None:
        return _table_without_rows(text, stream, tuple(problems))
    width = VALUES_PER_ROW.get(stream, 0)
    columns = np.array(stamps, np.int64), np.array(values, np.float64).reshape(len(stamps), width)
    tail = "\n".join(pending) + ("\n" if pending and final_newline else "")
    layout = replace(
        layout or TextLayout(), head=head, tail=tail, final_newline=final_newline or bool(pending)
    )
    layout = replace(layout, overrides=_overrides(layout, stream, *columns, raw))
    return Table(*columns, tuple(names), np.array(numbers, np.int64), layout, tuple(problems))


def _table_without_rows(text: str, stream: str, problems: tuple[Problem, ...]) -> Table:
    none = np.empty(0, np.int64)
    values = np.empty((0, VALUES_PER_ROW.get(stream, 0)))
    return Table(none, values, (), none, TextLayout(head=text), problems)


def _bare(line: str) -> str:
    """Return a line without blanks around it and byte order marks before it, which editors leave behind."""
    return _BEFORE_ROW.sub("", line).rstrip()


def parse_literal(text: str, stream: str) -> tuple[int, list[float], list[str]]:
    """Read a row as `parse` does, before which other lines may stand; see `parse_row`.

    Raises:
        ValueError: It is no such row.

    """
    return parse_row(_bare(text.rsplit("\n", 1)[-1]), stream)


def parse_row(text: str, stream: str) -> tuple[int, list[float], list[str]]:
    """Read one row: stamp, values, and the file name of an image list.

    Raises:
        ValueError: It is no row of such a file.

    """
    fields = [field for field in _SEPARATORS.split(text) if field]
    width = VALUES_PER_ROW.get(stream)
    if width is None:
        if len(fields) < 2:  # noqa: PLR2004 - a stamp and a name
            raise ValueError("a stamp without a file name")
        return parse_stamp(fields[0]), [], [fields[1]]
    if len(fields) != width + 1:
        raise ValueError(f"{len(fields)} columns instead of {width + 1}")
    return parse_stamp(fields[0]), [_parse_value(field) for field in fields[1:]], []


def _parse_value(text: str) -> float:
    # float() also takes `1_000` and the digits of other scripts, which are no numbers to anybody else.
    try:
        if "_" not in text and text.isascii():
            return float(text)
    except ValueError:
        pass
    raise ValueError(f"not a number: {text!r}")


def _problem(number: int, text: str, stream: str, reason: str, before_rows: bool) -> Problem:
    expected = COLUMNS.get(stream, COLUMNS["list"])
    shown = text if len(text) <= 60 else text[:57] + "..."  # noqa: PLR2004 - what fits into a message
    if before_rows and text[0].isalpha() and text.lower().startswith(("time", "stamp")):
        return Problem(number, f"a header line without '#': {shown!r}", is_header=True, text=text)
    return Problem(number, f"{reason}: {shown!r}; expected '{expected}'", text=text)


def _overrides(
    layout: TextLayout,
    stream: str,
    stamps: npt.NDArray[np.int64],
    values: npt.NDArray[np.float64],
    raw: Sequence[str],
) -> dict[int, str]:
    """Return the rows that the layout does not reproduce, with the lines that stand before them."""
    rows = [row + layout.newline[:-1] for row in render_rows(layout, stream, stamps, values)]
    if not layout.final_newline:
        rows[-1] = rows[-1].removesuffix(layout.newline[:-1])
    # Rows with more decimals than the first are literal, so that they do not decide how all are printed.
    finer = _finer(layout, stamps).tolist()
    return {
        number: text
        for number, (row, text, fine) in enumerate(zip(rows, raw, finer, strict=True))
        if fine or row != text
    }


def render_rows(
    layout: TextLayout, stream: str, stamps: npt.NDArray[np.int64], values: npt.NDArray[np.float64]
) -> list[str]:
    """Render rows without overrides and line ends, one by one; stamps get more decimals where needed."""
    rows = []
    for stamp, row in zip(stamps.tolist(), values.tolist(), strict=True):
        try:
            text = format_stamp(stamp, layout.stamp_decimals)
        except ValueError:
            text = format_stamp(stamp, MAX_DECIMALS)
        fields = [layout.value_format % value for value in row] if row else [f"{stream}/{text}.png"]
        rows.append(layout.separator.join([text, *fields]))
    return rows


def render(
    layout: TextLayout, stream: str, stamps: npt.NDArray[np.int64], values: npt.NDArray[np.float64]
) -> bytes:
    """Render a text file: head, rows, tail.

    Args:
        layout: The look.
        stream: Its stream; images of a list are named `<stream>/<stamp>.png`.
        stamps: int64, shape [n], in file order.
        values: float64, shape [n, k]; k = 0 for image lists.

    """
    if layout.overrides or not _plain(layout, stamps):
        rows = [row + layout.newline for row in render_rows(layout, stream, stamps, values)]
        for number, text in layout.overrides.items():
            rows[number] = text + "\n"
        body = "".join(rows)
    else:
        body = _render_uniform(layout, stream, stamps, values)
    if not layout.final_newline and not layout.tail:
        literal = len(stamps) - 1 in layout.overrides
        body = body.removesuffix("\n" if literal else layout.newline)
    return (layout.head + body + layout.tail).encode("utf-8", "surrogateescape")


def _finer(layout: TextLayout, stamps: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
    """Tell which stamps need more decimals than the layout has."""
    finer: npt.NDArray[np.bool_] = stamps % 10 ** (MAX_DECIMALS - layout.stamp_decimals) != 0
    return finer


def _plain(layout: TextLayout, stamps: npt.NDArray[np.int64]) -> bool:
    return not _finer(layout, stamps).any() and not (stamps < 0).any() and layout.stamp_decimals > 0


def _render_uniform(
    layout: TextLayout, stream: str, stamps: npt.NDArray[np.int64], values: npt.NDArray[np.float64]
) -> str:
    """Render all rows in one formatting call."""
    digits = layout.stamp_decimals
    seconds, rest = np.divmod(stamps, 10**MAX_DECIMALS)
    whole, part = seconds.tolist(), (rest // 10 ** (MAX_DECIMALS - digits)).tolist()
    stamp = f"%d.%0{digits}d"
    gap = layout.separator.replace("%", "%%")
    if values.shape[1]:
        row = gap.join([stamp, *[layout.value_format] * values.shape[1]]) + layout.newline
        columns = zip(whole, part, *values.T.tolist(), strict=True)
    else:
        row = f"{stamp}{gap}{stream}/{stamp}.png{layout.newline}"
        columns = zip(whole, part, whole, part, strict=True)
    return (row * len(whole)) % tuple(chain.from_iterable(columns))


def name_in_headers(heads: Iterable[str]) -> str | None:
    """Return the official name from the first published header line `# file: 'NAME.bag'`."""
    for head in heads:
        for line in head.splitlines():
            if found := _NAME_IN_HEADER.fullmatch(line):
                return found[1]
    return None


def fit_layout(
    layout: TextLayout, stamps: npt.NDArray[np.int64], values: npt.NDArray[np.float64]
) -> TextLayout:
    """Return the layout with as many decimals as are needed to print stamps and values exactly.

    Rows with overrides keep them; they are only there when they are known to hold the same values.
    """
    literal = np.zeros(len(stamps), bool)
    literal[list(layout.overrides)] = True
    decimals = decimals_needed(stamps[~literal], layout.stamp_decimals)
    value_format = layout.value_format
    numbers = values[~literal].ravel().tolist()
    if numbers and value_format != SHORTEST:
        texts = (f"{value_format} " * len(numbers) % tuple(numbers)).split()
        if not np.array_equal(
            np.fromiter(map(float, texts), np.float64, len(texts)), numbers, equal_nan=True
        ):
            value_format = SHORTEST
    return replace(layout, stamp_decimals=decimals, value_format=value_format)
