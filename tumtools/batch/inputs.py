# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Sources as files of this machine: found, fetched, or staged from a store."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass
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


@dataclass(frozen=True, slots=True)
class StagedSource:
    """A source as a file or folder of this machine.

    Attributes:
        path: Where.
        measure: Of the source's own place, as `measure_source` gives it: of a store, not of the copy.

    """

    path: Path
    measure: Measure


@contextmanager
def staged_source(source: Source, scratch: Path | None) -> Iterator[StagedSource]:
    """Give a source as files; what was staged for it is removed afterwards.

    Args:
        source: The recording.
        scratch: Folder for what is staged; None for the system's.

    Raises:
        InputError: It is missing.
        FetchError: It cannot be downloaded.
        OutputError: It cannot be written to the scratch folder.

    """
    if is_remote(source.uri):
        from tumtools.batch.stores.remote import download  # noqa: PLC0415 - an extra

        with download(source.uri, scratch) as (path, found):
            yield StagedSource(path, found)
    elif source.uri.startswith(CATALOGUE):
        yield _existing(_catalogue_path(source))
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


def sha256_of_source(source: Source, scratch: Path | None = None) -> str:
    """Hash a source (`tree.sha256_of`); arguments and errors are those of `staged_source`."""
    with staged_source(source, scratch) as staged:
        return sha256_of(staged.path)


def _existing(path: Path) -> StagedSource:
    found = measure(path)
    if found is None:
        raise MissingInputError("there is no such file or folder", path=path)
    return StagedSource(path, found)


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
