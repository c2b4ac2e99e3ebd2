# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Where outputs and the ledger are kept: a small interface, local folders and object stores behind it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tumtools.batch.places import is_remote
from tumtools.batch.stores.local import LocalStore

if TYPE_CHECKING:
    from pathlib import Path

    from tumtools.batch.stores.store import Store


def open_store(place: str, scratch: Path | None = None) -> Store:
    """Open a store.

    Args:
        place: An absolute folder, or a URL.
        scratch: Folder for files on their way; None for the system's.

    Raises:
        UsageError: The extra that it needs is not installed.

    """
    if not is_remote(place):
        return LocalStore(place)
    from tumtools.batch.stores.remote import RemoteStore  # noqa: PLC0415 - an extra

    return RemoteStore(place, scratch)
