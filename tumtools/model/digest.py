# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The digest that a file carries of its own content (docs/reference/digest.md, "Kept in files")."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, cast

if TYPE_CHECKING:
    from collections.abc import Mapping

Kind = Literal["pixels", "files", "rows"]

VERSION: Final = "1"
_ENTRY: Final = re.compile(r"(\d{1,18}) (pixels|files|rows) ([0-9a-f]{64})")


@dataclass(frozen=True, slots=True)
class KeptDigest:
    """Digest of one stream as it is kept in a file.

    Attributes:
        count: Images or rows.
        of: What was hashed: canonical `pixels`, PNG `files`, or `rows` of a signal.
        value: SHA-256 in hexadecimal.

    """

    count: int
    of: Kind
    value: str


def to_strings(streams: Mapping[str, KeptDigest]) -> dict[str, str]:
    """Return the digest as strings, which every container can hold."""
    lines = {name: f"{one.count} {one.of} {one.value}" for name, one in sorted(streams.items())}
    return {"version": VERSION, **lines}


def from_strings(strings: Mapping[str, str]) -> dict[str, KeptDigest] | None:
    """Read what `to_strings` wrote; None if it is of another version or damaged, and so proves nothing."""
    if strings.get("version") != VERSION:
        return None
    found = {}
    for name, text in strings.items():
        match = _ENTRY.fullmatch(text)
        if match is not None:
            found[name] = KeptDigest(int(match[1]), cast("Kind", match[2]), match[3])
        elif name != "version":
            return None
    return found
