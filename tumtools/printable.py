# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Text of other people's files as it may be shown on a terminal."""

from __future__ import annotations


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
