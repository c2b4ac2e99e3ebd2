# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""TUM001 to TUM006: the files of a sequence and their text."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.errors import MissingInputError
from tumtools.model.sequence import IMAGE_STREAMS
from tumtools.model.text import TITLES
from tumtools.printable import shortened
from tumtools.validate.finding import NOWHERE, Place, Severity
from tumtools.validate.rule import Found, rule
from tumtools.validate.subject import ProblemKind

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from tumtools.validate.rule import Limits
    from tumtools.validate.subject import Subject, TextFile

_BOM: Final = "\ufeff"
_HEADER_LINES: Final = 3
_LIST_FIELDS: Final = 2


@rule(
    "TUM001",
    "missing-file",
    Severity.ERROR,
    title="A list file, an image that a list names, or everything is missing.",
    why="A reader that goes by the lists fails in the middle of a run, or skips frames without a word.",
    how=(
        "Every file name of the image lists is looked up in the folder or archive; a folder of "
        "images needs its list. A recording needs one stream of a sequence, a rawlog the files that it names."
    ),
    mend="Get the sequence again, or take the rows without a file out of the list (`validate --fix`).",
    fixable=True,
)
def missing_file(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Compare the lists with what is there."""
    del limits
    for error in subject.damage:
        if isinstance(error, MissingInputError):
            yield Found(error.message, NOWHERE, error.hint or "")
    if subject.info is not None and not subject.damage and not subject.all_stamps:
        yield Found("there are no images, no ground truth and no accelerations", NOWHERE)
    for stream, missing in subject.missing.items():
        severity = Severity.WARNING if subject.salvage else None
        for row, stamp, name in missing:
            place = Place(stream=stream, row=row, stamp=stamp)
            yield Found(f"the external file {shortened(name)} is missing", place, severity=severity)
    if subject.sizes is None:
        return
    for stream, names in subject.names.items():
        for row, name in enumerate(names):
            if name not in subject.sizes:
                yield Found(f"the image {name} is missing", subject.place(stream, row))
    yield from _missing_lists(subject, subject.sizes)


def _missing_lists(subject: Subject, sizes: Mapping[str, int]) -> Iterator[Found]:
    for stream in IMAGE_STREAMS:
        images = sum(name.startswith(f"{stream}/") for name in sizes)
        if images and stream not in subject.texts:
            yield Found(f"{stream}.txt is missing, {stream}/ has {images} files", Place(f"{stream}.txt"))
    if subject.names and "rgb" not in subject.texts and not _has_folder(subject, "rgb"):
        yield Found("rgb.txt is missing: the sequence has no colour images", Place("rgb.txt"))


def _has_folder(subject: Subject, stream: str) -> bool:
    return any(name.startswith(f"{stream}/") for name in subject.sizes or ())


@rule(
    "TUM002",
    "unlisted-image",
    Severity.WARNING,
    title="An image lies in an image folder and no list names it.",
    why="Readers that go by the lists and readers that go by the folder see different sequences.",
    how="The files of rgb/, depth/ and ir/ are compared with the lists.",
    mend="Add the image to the list, or remove the file.",
)
def unlisted_image(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Compare what is there with the lists."""
    del limits
    for stream, names in subject.names.items():
        if not subject.texts[stream].is_sound:
            continue  # the rows that could not be read may name it
        folders = {name.rpartition("/")[0] for name in names} | {stream}
        listed = set(names)
        for name in sorted(subject.sizes or ()):
            if name.rpartition("/")[0] in folders - {""} and name not in listed:
                yield Found(
                    f"no row of {subject.texts[stream].name} names this file", Place(name, stream=stream)
                )


@rule(
    "TUM003",
    "unreadable-text",
    Severity.ERROR,
    title="A line of a text file cannot be parsed.",
    why="Most readers stop there, or worse, read a shifted column.",
    how=(
        "Lines that begin with # are comments; every other line needs a number of seconds and the columns of "
        "its file, separated by blanks, tabs or commas. A header line that lost its # is named as such."
    ),
    mend="Correct the line; put # before a header line; save the file as UTF-8.",
)
def unreadable_text(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Report what the parser could not read, but for what other rules explain."""
    del limits
    for stream, text in subject.texts.items():
        if text.damage is not None:
            yield Found(text.damage.message, Place(text.name, 1, stream), text.damage.hint or "")
        for problem in text.problems(ProblemKind.HEADER, ProblemKind.OTHER):
            hint = "put # before it" if problem.is_header else ""
            yield Found(problem.message, Place(text.name, problem.line, stream), hint)


@rule(
    "TUM004",
    "header-style",
    Severity.INFO,
    title="The header lines differ from the three published ones.",
    why="Programs that skip a fixed number of lines lose a row or stumble over the header.",
    how="The lines before the first row are compared with: title, file, column names.",
    mend="Write the three lines of the published files.",
)
def header_style(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Compare the header with the published one."""
    del limits
    for stream, text in subject.texts.items():
        if text.damage is not None or subject.is_estimate or not text.is_sound:
            continue
        lines = text.table.layout.head.removeprefix(_BOM).splitlines()
        title, columns = TITLES[stream]
        fits = len(lines) == _HEADER_LINES and (lines[0], lines[2]) == (title, columns)
        if not fits or not lines[1].startswith("# file: '"):
            place = Place(text.name, 1, stream)
            found = f"{len(lines)} header lines" if len(lines) != _HEADER_LINES else "other header lines"
            yield Found(f"{found} instead of the published three ({title}, # file, {columns})", place)


@rule(
    "TUM005",
    "empty-stream",
    Severity.ERROR,
    title="A stream is there and has no rows.",
    why="A list without rows is most often a recording that failed.",
    how=(
        "Rows are counted, but not those of a damaged recording, which TUM701 reports. An accelerometer file "
        "with nothing but its header is as published for the third camera."
    ),
    mend="Record again, or remove the file.",
)
def empty_stream(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Count rows."""
    del limits
    if subject.damage:
        return
    for stream, stamps in subject.all_stamps.items():
        text = subject.texts.get(stream)
        if len(stamps) or (text is not None and not text.is_sound):
            continue
        published = stream == "accelerometer"
        yield Found(
            f"the stream {stream} has no rows"
            + (" (as published for the third camera)" if published else ""),
            subject.stream_place(stream),
            severity=Severity.INFO if published else None,
        )


@rule(
    "TUM006",
    "encoding-or-eol",
    Severity.WARNING,
    title="A text file has another encoding, separator or line end than the published ones.",
    why="Readers that split at single blanks, or compare names with the line end attached, fail.",
    how=(
        "Byte-order mark, carriage returns, tabs, commas, backslashes in file names, more fields in a list "
        "than a stamp and a name, and the end of the last line are looked for."
    ),
    mend="Save as UTF-8 with single blanks and line feeds (`validate --fix`).",
    fixable=True,
)
def encoding_or_eol(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Look at how the text is written down."""
    del limits
    for stream, text in subject.texts.items():
        for line, what in _oddities(text):
            yield Found(what, Place(text.name, line, stream))
        if stream in IMAGE_STREAMS:
            for line, what in _odd_names(text):
                yield Found(what, Place(text.name, line, stream))


def _oddities(text: TextFile) -> Iterator[tuple[int, str]]:
    layout, table = text.table.layout, text.table
    rows = layout.overrides
    first = int(table.lines[0]) if len(table.lines) else 1
    if layout.head.startswith(_BOM):
        yield 1, "a byte-order mark at the beginning"
    returns = sum(row.endswith("\r") for row in rows.values())
    if layout.newline == "\r\n" or "\r" in layout.head:
        yield 1, "lines end with carriage return and line feed (CRLF)"
    elif returns:
        line = int(table.lines[next(row for row, line in rows.items() if line.endswith("\r"))])
        yield line, f"{returns} lines end with carriage return and line feed (CRLF)"
    for separator, name in (("\t", "tabs"), (",", "commas")):
        if separator in layout.separator:
            yield first, f"fields are separated by {name}"
        else:
            odd = [row for row, line in rows.items() if separator in line.rsplit("\n", 1)[-1]]
            if odd:
                yield int(table.lines[odd[0]]), f"fields of {len(odd)} rows are separated by {name}"
    if len(table.lines) and not layout.final_newline and not layout.tail:
        yield int(np.max(table.lines)), "the last line has no line end"


def _odd_names(text: TextFile) -> Iterator[tuple[int, str]]:
    """Look for names and fields that other readers of lists stumble over."""
    table = text.table
    rows = {row: line.rsplit("\n", 1)[-1] for row, line in table.layout.overrides.items()}
    backslashes = [row for row, line in rows.items() if "\\" in line]
    longer = [row for row, line in rows.items() if len(line.replace(",", " ").split()) > _LIST_FIELDS]
    for found, what in (
        (backslashes, "backslashes in the file names of {}"),
        (longer, "more than a stamp and a name in {}; the rest is not read"),
    ):
        if found:
            count = "1 row" if len(found) == 1 else f"{len(found)} rows"
            yield int(table.lines[found[0]]), what.format(count)


RULES = (missing_file, unlisted_image, unreadable_text, header_style, empty_stream, encoding_or_eol)
