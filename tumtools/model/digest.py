# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The digest that a file carries of its own content (docs/reference/digest.md, "Kept in files")."""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, cast

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    import numpy.typing as npt

Kind = Literal["pixels", "files", "rows"]

VERSION: Final = 2
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


def digest_of_rows(stamps: npt.NDArray[np.int64], values: npt.NDArray[np.float64]) -> str:
    """Return the SHA-256 of rows: each stamp as int64, its values as float64, all NaN the same."""
    table = np.empty((len(stamps), 1 + values.shape[1]), "<i8")
    table[:, 0] = stamps
    table[:, 1:] = np.where(np.isnan(values), np.nan, values).astype("<f8").view("<i8")
    return hashlib.sha256(table.tobytes()).hexdigest()


def digest_of_images(images: Iterable[tuple[int, bytes]]) -> str:
    """Return the SHA-256 of the stamp and the digest of each image, in file order."""
    sha = hashlib.sha256()
    for stamp, value in images:
        sha.update(stamp.to_bytes(8, "little", signed=True) + value)
    return sha.hexdigest()


def to_strings(streams: Mapping[str, KeptDigest]) -> dict[str, str]:
    """Return the digest as strings, which every container can hold."""
    lines = {name: f"{one.count} {one.of} {one.value}" for name, one in sorted(streams.items())}
    return {"version": str(VERSION), **lines}


def from_strings(strings: Mapping[str, str]) -> dict[str, KeptDigest] | None:
    """Read what `to_strings` wrote; None if it is of another version or damaged, and so proves nothing."""
    if strings.get("version") != str(VERSION):
        return None
    found = {}
    for name, text in strings.items():
        match = _ENTRY.fullmatch(text)
        if match is not None:
            found[name] = KeptDigest(int(match[1]), cast("Kind", match[2]), match[3])
        elif name != "version":
            return None
    return found


def is_damaged(strings: Mapping[str, str]) -> bool:
    """Tell whether the strings are neither what `to_strings` writes nor the digest of another version."""
    version = strings.get("version", "")
    of_another = version != str(VERSION) and version.isascii() and version.isdecimal()
    return not of_another and from_strings(strings) is None
