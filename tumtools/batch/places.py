# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Places: local paths, and URLs of stores. A URL never carries credentials."""

from __future__ import annotations

import os
import re
from typing import Final
from urllib.parse import urlsplit

STORE_SCHEMES: Final = ("s3", "gs", "az")
WEB_SCHEMES: Final = ("http", "https")
PATTERN_CHARACTERS: Final = "*?["
_QUERY: Final = re.compile(r"\?[^/]*=")


def is_remote(place: str) -> bool:
    """Whether this is the URL of a store or of a file on the web."""
    scheme, colon, _ = place.partition("://")
    return bool(colon) and scheme.lower() in STORE_SCHEMES + WEB_SCHEMES


def is_pattern(place: str) -> bool:
    """Whether this stands for several places."""
    return any(character in place for character in PATTERN_CHARACTERS)


def check_place(place: str, *, pattern: bool = False) -> str | None:
    """Return what is wrong with a place, or None; what it says never repeats a secret.

    Args:
        place: A path or URL.
        pattern: Whether it may be a pattern.

    """
    if "\0" in place:
        return "a name with a NUL character, which no system takes"
    scheme, colon, _ = place.partition("://")
    if not colon:
        return None
    if not is_remote(place):
        known = ", ".join(f"{name}://" for name in STORE_SCHEMES + WEB_SCHEMES)
        return f"no store has the scheme {scheme}:// (known: {known})"
    try:
        parts = urlsplit(place)
    except ValueError:
        return "a URL with a bucket or host that cannot be one"
    if parts.username is not None or parts.password is not None:
        return "a URL with a user or a password; credentials come from the environment only"
    # In a pattern of a store a question mark stands for a character, unless something is set behind it.
    may_be_pattern = pattern and scheme.lower() in STORE_SCHEMES
    if _QUERY.search(place) if may_be_pattern else "?" in place:
        return "a URL with a query, which may hold a signature; credentials come from the environment only"
    if not parts.netloc:
        return "a URL without a bucket or host"
    return None


def clean_place(place: str) -> str:
    """Return a URL as it is written everywhere."""
    scheme, _, rest = place.partition("://")
    return f"{scheme.lower()}://{rest.rstrip('/')}"


def real_place(place: str) -> str:
    """Return the one name of a place; links are followed, since a place may have several names."""
    return place.rstrip("/") if is_remote(place) else os.path.realpath(place)


def is_around(place: str, other: str) -> bool:
    """Whether a place is another one, or a folder around it."""
    return f"{real_place(other)}/".startswith(f"{real_place(place)}/")


def last_name(place: str) -> str:
    """Return the last part of a path or URL."""
    return place.rstrip("/").rpartition("/")[2]


def parent_name(place: str) -> str:
    """Return the last part but one."""
    return last_name(place.rstrip("/").rpartition("/")[0])


def stem(name: str) -> str:
    """Return the name of a recording without the suffix of its format."""
    for suffix in (".tar.gz", ".tar.zst", ".tgz", ".tar", ".zip", ".mcap", ".bag", ".rawlog", ".db3"):
        if name.lower().endswith(suffix) and len(name) > len(suffix):
            return name[: -len(suffix)]
    return name
