# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Text of other people's files as it may be shown on a terminal."""

from __future__ import annotations

import json
from typing import Final

_LONGEST_NAME: Final = 255
"""No file system has longer names of files."""
_SHOWN: Final = 100


def printable(text: str) -> str:
    r"""Return a text with all that is not printed as escapes: `\x1b`, `\n`, `\u202e`.

    A name in a recording may hold anything, and a terminal obeys what it is sent. What has been through here
    is not changed a second time.
    """
    if text.isprintable():
        return text
    return "".join(
        letter if letter.isprintable() else letter.encode("unicode_escape").decode() for letter in text
    )


def shortened(name: str) -> str:
    """Return the name of a file for a message, cut if it is longer than any file's; it may have thousands."""
    return name if len(name) <= _LONGEST_NAME else f"{name[:_SHOWN]}..."


def json_text(document: object) -> str:
    """Return a JSON document as it may be printed; JSON itself lets most of what a terminal obeys through.

    Raises:
        ValueError: It has a number that JSON does not have.

    """
    text = json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False)
    rows = text.split("\n")
    return "\n".join(row if row.isprintable() else "".join(map(_in_json, row)) for row in rows)


def _in_json(letter: str) -> str:
    return letter if letter.isprintable() else json.dumps(letter)[1:-1]
