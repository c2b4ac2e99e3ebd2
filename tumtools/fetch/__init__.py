# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Get sequences: downloads that survive interruptions, checksums, the cache, safe unpacking."""

from __future__ import annotations

from tumtools.fetch.cache import Cache
from tumtools.fetch.job import fetch
from tumtools.fetch.options import Event, Fetched, FetchOptions, Patience
from tumtools.fetch.parallel import Outcome, fetch_all

__all__ = ["Cache", "Event", "FetchOptions", "Fetched", "Outcome", "Patience", "fetch", "fetch_all"]
