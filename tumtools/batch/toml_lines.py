# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Where in a TOML file a key is: `tomllib` tells the values, not their lines.

A statement of TOML, a header or `key = value`, is itself a document. So the text is cut into the smallest
pieces that parse, and each piece tells its own keys; no second parser of TOML is needed.
"""

from __future__ import annotations

import re
import tomllib
from collections import Counter
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

Key = tuple[str | int, ...]
"""Keys and indices from the root: `("target", 1, "compression")`."""

_MAY_BEGIN_STATEMENT: Final = re.compile(r"""\s*(\[|#|$|[\w"'.\-]+(\s*\.\s*[\w"'.\-]+)*\s*=)""")


def key_lines(text: str) -> dict[Key, int]:
    """Return the line (1 = first) of each table header and each key of a well-formed document."""
    lines: dict[Key, int] = {}
    counts: Counter[Key] = Counter()
    table: Key = ()
    for number, piece in _statements(text):
        parsed: Mapping[str, object] = tomllib.loads(piece)
        if not parsed:
            continue
        if piece.lstrip().startswith("["):
            table = _header(parsed, counts)
            lines.setdefault(table, number)
        else:
            for key in _keys(parsed):
                lines.setdefault(table + key, number)
    return lines


def line_of(lines: Mapping[Key, int], key: Key) -> int:
    """Return the line of a key, or of the closest table around it."""
    while key and key not in lines:
        key = key[:-1]
    return lines.get(key, 1)


def _statements(text: str) -> Iterator[tuple[int, str]]:
    rows = text.split("\n")
    start = 0
    for end in range(1, len(rows) + 1):
        # A piece can only end where the next line could begin a statement; this keeps long arrays cheap.
        if end < len(rows) and not _MAY_BEGIN_STATEMENT.match(rows[end]):
            continue
        piece = "\n".join(rows[start:end])
        try:
            tomllib.loads(piece)
        except tomllib.TOMLDecodeError:
            continue
        yield start + 1, piece
        start = end


def _header(parsed: Mapping[str, object], counts: Counter[Key]) -> Key:
    """Return the key that a header opens, with the index in arrays of tables."""
    key: Key = ()
    value: object = parsed
    while isinstance(value, dict) and value:
        name, value = next(iter(value.items()))
        key += (name,)
        if isinstance(value, list):
            counts[key] += 1
        if counts[key]:
            key += (counts[key] - 1,)
    return key


def _keys(parsed: Mapping[str, object]) -> Iterator[Key]:
    for name, value in parsed.items():
        yield (name,)
        if isinstance(value, dict):
            yield from ((name, *rest) for rest in _keys(value))
