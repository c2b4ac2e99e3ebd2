# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Sources as files of this machine: found, fetched, or staged from a store."""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from tumtools.batch.expand import CATALOGUE
from tumtools.batch.places import is_remote
from tumtools.batch.tree import measure, sha256_of
from tumtools.errors import MissingInputError
from tumtools.sources import locate

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tumtools.batch.expand import Source
    from tumtools.batch.tree import Measure


@contextmanager
def staged_source(source: Source, scratch: Path | None) -> Iterator[Path]:
    """Give the path of a source; what was staged for it is removed afterwards.

    Args:
        source: The recording.
        scratch: Folder for what is staged; None for the system's.

    Raises:
        InputError: It is missing.
        FetchError: It cannot be downloaded.

    """
    if is_remote(source.uri):
        from tumtools.batch.stores.remote import download  # noqa: PLC0415 - an extra

        with download(source.uri, scratch) as path:
            yield path
    elif source.uri.startswith(CATALOGUE):
        yield _catalogue_path(source)
    else:
        yield _existing(Path(source.uri))


def measure_source(source: Source) -> Measure | None:
    """Look at a source without reading it; None if it is not there.

    Raises:
        InputError: It cannot be looked at.

    """
    if is_remote(source.uri):
        from tumtools.batch.stores.remote import measure_url  # noqa: PLC0415 - an extra

        return measure_url(source.uri)
    try:
        return measure(locate(source.uri.removeprefix(CATALOGUE)))
    except MissingInputError:
        return None


def sha256_of_source(source: Source) -> str:
    """Hash a source (`tree.sha256_of`)."""
    with staged_source(source, None) as path:
        return sha256_of(path)


def _existing(path: Path) -> Path:
    if measure(path) is None:
        raise MissingInputError("there is no such file or folder", path=path)
    return path


def _catalogue_path(source: Source) -> Path:
    name = source.uri.removeprefix(CATALOGUE)
    try:
        return locate(name)
    except MissingInputError:
        if not source.fetch:
            raise
    from tumtools.catalogue import load_catalogue  # noqa: PLC0415 - only for what is missing
    from tumtools.fetch import fetch  # noqa: PLC0415

    return fetch(load_catalogue().get(name)).path
