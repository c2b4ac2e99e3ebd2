# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Where the sequence of a name is on this machine."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tumtools.catalogue import load_catalogue
from tumtools.errors import MissingInputError
from tumtools.fetch.cache import Cache

if TYPE_CHECKING:
    from pathlib import Path


def locate_name(name: str, cache: Cache | None = None) -> Path:
    """Return the folder, archive or recording of a sequence in the cache.

    Args:
        name: Any name of the catalogue, of a user's catalogue, or of what is in the cache.
        cache: Where to look; None for the user's cache.

    Raises:
        MissingInputError: It has not been fetched, or there is no such name.

    """
    cache = cache if cache is not None else Cache()
    cached = cache.catalogue().find(name)
    record = cache.record(cached.name) if cached else None
    path = cache.present(record) if record else None
    if path is not None:
        return path
    catalogue = load_catalogue()
    entry = catalogue.find(name)
    if entry is not None:
        raise MissingInputError(
            f"the sequence is not in the cache ({cache.root})",
            path=entry.label,
            hint=f"`tumtools fetch {entry.label}` gets it",
        )
    near = catalogue.suggest(name)
    raise MissingInputError(
        "no such file or folder, and no sequence of that name",
        path=name,
        hint=f"did you mean {' or '.join(near)}?" if near else "`tumtools list` shows the names",
    )
