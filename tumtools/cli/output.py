# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Printing: results on stdout, everything else on stderr."""

from __future__ import annotations

import math
import os
import sys
import traceback as _traceback
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

import click

from tumtools.errors import TumtoolsError
from tumtools.printable import json_text, printable

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from tumtools.formats.options import Progress

SCHEMA_VERSION: Final = 1
_INDENT: Final = "\n  "
_WIDEST: Final = 300
"""Letters of a cell of a table; names in recordings may have a million."""

verbosity = 0
"""-1 with --quiet, 1 and 2 with -v and -vv."""


def style(text: str, *, bold: bool = False, color: str | None = None) -> str:
    """Return the text as it looks on a terminal; as it is where NO_COLOR is set."""
    shown = printable(text)
    return shown if os.environ.get("NO_COLOR") else click.style(shown, bold=bold or None, fg=color)


def lines(text: str) -> str:
    """Return a text of several lines as it may be printed: of all that is not printed, line ends only."""
    return text if text.isprintable() else "\n".join(map(printable, text.split("\n")))


def echo(text: str) -> None:
    """Print one line of a result on stdout; a line end in it is one of the data, and is shown as such."""
    click.echo(printable(text))


def print_json(document: Mapping[str, object]) -> None:
    """Print one document, with the version of its schema; stamps are given as strings by the caller."""
    whole = _finite({"schema_version": SCHEMA_VERSION, **document})
    click.echo(json_text(whole))


def _finite(value: object) -> object:
    """Put null for numbers that JSON does not have: infinite ones and NaN."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def print_table(rows: Sequence[Sequence[str]], head: Sequence[str] | None = None) -> None:
    """Print columns, numbers to the right."""
    rows = [[_cell(text) for text in row] for row in rows]
    everything = [*([head] if head else []), *rows]
    if not everything:
        return
    widths = [max(len(row[column]) for row in everything) for column in range(len(everything[0]))]
    numeric = [
        bool(rows)
        and all(_is_number(row[column]) for row in rows)
        and any(row[column] != "-" for row in rows)
        for column in range(len(widths))
    ]
    for number, row in enumerate(everything):
        cells = [
            text.rjust(width) if right else text.ljust(width)
            for text, width, right in zip(row, widths, numeric, strict=True)
        ]
        line = "  ".join(cells).rstrip()
        click.echo(style(line, bold=True) if head and number == 0 else line)


def _cell(text: str) -> str:
    shown = printable(text)
    return shown if len(shown) <= _WIDEST else f"{shown[:_WIDEST]}..."


def _said(text: str) -> str:
    """Return a message: one line, and what belongs to it on indented ones."""
    return _INDENT.join(map(printable, text.split(_INDENT)))


def _is_number(text: str) -> bool:
    return text == "-" or text.replace(".", "").replace(",", "").strip("-").isdigit()


def message(text: str) -> None:
    """Say something on stderr, but not with --quiet."""
    if verbosity >= 0:
        click.echo(_said(text), err=True)


def warning(text: str) -> None:
    """Warn on stderr."""
    if verbosity >= 0:
        click.echo(style("warning: ", color="yellow") + _said(text), err=True)


@contextmanager
def warnings(texts: Sequence[str]) -> Iterator[None]:
    """Warn when the block has ended, but not of what it fails for."""
    try:
        yield
    except TumtoolsError as failure:
        texts = [text for text in texts if text not in str(failure)]
        raise
    finally:
        for text in texts:
            warning(text)


def said(text: str) -> None:
    """Say on stdout what was done, but not with --quiet."""
    if verbosity >= 0:
        click.echo(_said(text))


def error(text: str) -> None:
    """Print an error on stderr."""
    click.echo(style("error: ", color="red", bold=True) + _said(text), err=True)


def traceback() -> None:
    """Print where the current exception arose."""
    click.echo(_traceback.format_exc(), err=True)


def size(nbytes: float) -> str:
    """Return a size for people."""
    for unit in ("B", "kB", "MB", "GB"):
        if nbytes < 1000 or unit == "GB":  # noqa: PLR2004 - decimal units
            return f"{nbytes:.0f} {unit}" if unit == "B" else f"{nbytes:.1f} {unit}"
        nbytes /= 1000
    raise AssertionError


@contextmanager
def progress_bar(title: str, frames: int) -> Iterator[Progress]:
    """Show frames and bytes per second while stderr is a terminal."""
    if verbosity < 0 or not sys.stderr.isatty() or not frames:
        from tumtools.formats.options import no_progress

        yield no_progress
        return
    from tqdm import tqdm

    total = 0
    with tqdm(total=frames, desc=title, unit=" frames", leave=False, dynamic_ncols=True) as bar:

        def advance(done: int, nbytes: int) -> None:
            nonlocal total
            total += nbytes
            elapsed = bar.format_dict["elapsed"]
            bar.set_postfix_str(f"{size(total / elapsed)}/s" if elapsed else "", refresh=False)
            bar.update(done)

        yield advance
