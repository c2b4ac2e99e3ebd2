# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Get sequences: downloads that survive interruptions, checksums, the cache, safe unpacking.

The names below are imported when they are used: looking into the cache needs no HTTP library.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from tumtools.fetch.cache import Cache
    from tumtools.fetch.job import fetch
    from tumtools.fetch.locate import locate_name
    from tumtools.fetch.options import Event, Fetched, FetchOptions, Patience
    from tumtools.fetch.parallel import Outcome, fetch_all

__all__ = [
    "Cache",
    "Event",
    "FetchOptions",
    "Fetched",
    "Outcome",
    "Patience",
    "fetch",
    "fetch_all",
    "locate_name",
]

_MODULES: Final = {
    "Cache": "cache",
    "Event": "options",
    "FetchOptions": "options",
    "Fetched": "options",
    "Outcome": "parallel",
    "Patience": "options",
    "fetch": "job",
    "fetch_all": "parallel",
    "locate_name": "locate",
}


def __getattr__(name: str) -> object:
    if name not in _MODULES:
        msg = f"module {__name__!r} has no attribute {name!r}"
        raise AttributeError(msg)
    return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
