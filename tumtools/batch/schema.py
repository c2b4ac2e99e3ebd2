# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The keys of a manifest and what their values must be, as tables; documented in docs/reference/batch.md."""

from __future__ import annotations

import difflib
import json
import string
from collections.abc import Callable, Mapping
from typing import Final

from tumtools.formats import registry
from tumtools.formats.options import WriteOptions
from tumtools.model.sequence import STREAMS
from tumtools.model.time import parse_stamp

Rule = tuple[Callable[[object], bool], str]
"""Whether a value fits, and what was expected."""

VERSION: Final = 1
_MOST_JOBS: Final = 256
_LONGEST_TEXT: Final = 60
_RELATIVE_NS: Final = 10**17
"""What is less is counted from the first stamp; see `transform.parse_selection`."""
TEMPLATE_FIELDS: Final = ("name", "parent", "ext", "format", "target", "camera")
WRITE_KEYS: Final = tuple(
    name for name in WriteOptions.__dataclass_fields__ if name not in {"jobs", "cameras"}
)


def _is_text(value: object) -> bool:
    return isinstance(value, str) and bool(value)


def _is_texts(value: object) -> bool:
    return isinstance(value, list) and bool(value) and all(_is_text(item) for item in value)


def _is_streams(value: object) -> bool:
    return isinstance(value, list) and bool(value) and all(item in STREAMS for item in value)


def _is_pairs(value: object) -> bool:
    return isinstance(value, dict) and all(key in STREAMS and _is_text(text) for key, text in value.items())


def _is_stamp(value: object) -> bool:
    try:
        return isinstance(value, str) and parse_stamp(value) is not None
    except ValueError:
        return False


def _is_tables(value: object) -> bool:
    return isinstance(value, list) and bool(value)


def _choice(*values: str) -> Rule:
    return (lambda value: isinstance(value, str) and value in values), f"one of {', '.join(values)}"


_TEXT: Final[Rule] = (_is_text, "a text")
_FLAG: Final[Rule] = ((lambda value: isinstance(value, bool)), "true or false")
_COUNT: Final[Rule] = ((lambda value: type(value) is int and value >= 1), "a whole number, 1 or more")
_TEXTS: Final[Rule] = (_is_texts, "a list of texts")
_PAIRS: Final[Rule] = (_is_pairs, f"a table of streams ({', '.join(STREAMS)}) and texts")
_STAMP: Final[Rule] = (_is_stamp, 'seconds as a text, so that no digit is lost, such as "1.5"')

ROOT: Final[Mapping[str, Rule]] = {
    "schema_version": ((lambda value: type(value) is int and value == VERSION), str(VERSION)),
    "destination": _TEXT,
    "template": _TEXT,
    "estimate": _choice("auto", "open", "size", "off"),
    "validate": _choice("quick", "full", "off"),
    "on_findings": _choice("warn", "skip", "fail"),
    "fail_on": _choice("error", "warning"),
    "digest": _FLAG,
    "jobs": ((lambda value: type(value) is int and 1 <= value <= _MOST_JOBS), f"1 to {_MOST_JOBS}"),
    "source": (_is_tables, "one or more tables [[source]]"),
    "target": (_is_tables, "one or more tables [[target]]"),
}
SOURCE: Final[Mapping[str, Rule]] = {
    "path": _TEXT,
    "name": ((lambda value: _is_text(value) or _is_texts(value)), "a text or a list of texts"),
    "camera": _TEXT,
    "category": _TEXT,
    "kind": _choice("sequence", "validation", "calibration"),
    "exclude": _TEXTS,
    "label": _TEXT,
    "fetch": _FLAG,
    "topics": _PAIRS,
    "salvage": _FLAG,
}
TARGET: Final[Mapping[str, Rule]] = {
    "to": _choice(*registry.FORMATS),
    "label": _TEXT,
    "ext": _TEXT,
    "start": _STAMP,
    "end": _STAMP,
    "every": _COUNT,
    "streams": (_is_streams, f"a list of {', '.join(STREAMS)}"),
    "strict": _FLAG,
    "verify": _FLAG,
    **{
        name: {"archive": _FLAG, "frame_ids": _PAIRS, "topics": _PAIRS}.get(name, _TEXT)
        for name in WRITE_KEYS
    },
}


def words(value: object) -> str:
    """Show a wrong value as a manifest has it, without what may be a secret."""
    if isinstance(value, str):
        shown = value.partition("?")[0] if "://" in value else value
        shown = shown.rpartition("@")[2] if "://" in value else shown
        return json.dumps(shown[:_LONGEST_TEXT], ensure_ascii=False)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return str(value)[:_LONGEST_TEXT]
    if isinstance(value, list | dict):
        return "a list" if isinstance(value, list) else "a table"
    return "a date or time"


def ends_before_it_starts(start: str, end: str) -> bool:
    """Whether a selection is empty whatever the recording: both are counted from its first stamp, or none."""
    first, last = parse_stamp(start), parse_stamp(end)
    return last < first and (abs(first) < _RELATIVE_NS) == (abs(last) < _RELATIVE_NS)


def suggest(key: str, table: Mapping[str, Rule]) -> str:
    """Return what an unknown key might have been."""
    near = difflib.get_close_matches(key, table, 1)
    return f"did you mean {near[0]}?" if near else f"known keys: {', '.join(table)}"


def template_problem(template: str) -> str | None:
    """Return what is wrong with a template, or None."""
    try:
        names = [name for _, name, spec, conversion in string.Formatter().parse(template) if name is not None]
        plain = all(
            not spec and not conversion for _, _, spec, conversion in string.Formatter().parse(template)
        )
    except ValueError:
        return "template: its braces do not pair; {{ and }} stand for braces of a name"
    unknown = [name for name in names if name not in TEMPLATE_FIELDS]
    if unknown or not plain:
        return f"template: unknown field {{{unknown[0]}}}" if unknown else "template: only plain {fields}"
    if "name" not in names:
        return "template: without {name} all outputs would have one name"
    return None
