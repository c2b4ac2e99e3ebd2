# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""From the sources of a manifest to single recordings, in a stable order."""

from __future__ import annotations

import glob
import os
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Final

from tumtools.batch.places import WEB_SCHEMES, is_pattern, is_remote, last_name, parent_name, stem
from tumtools.batch.plan_head import is_plan_file
from tumtools.catalogue import load_catalogue
from tumtools.errors import InputError, UsageError

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from tumtools.batch.manifest import Manifest, SourceSpec
    from tumtools.catalogue import Entry

CATALOGUE: Final = "catalogue:"
"""Begins the URI of a sequence of the catalogue."""


@dataclass(frozen=True, slots=True)
class Source:
    """One recording.

    Attributes:
        uri: An absolute path, a URL, or `catalogue:NAME`.
        name: What `{name}` is.
        parent: What `{parent}` is.
        camera: As the catalogue knows it.
        fetch: Whether to download it when it is not in the cache.
        topics: Stream -> topic.
        salvage: Convert what is readable of it.
        listed_bytes: Its size as a store lists it; 0 where it was not listed.

    """

    uri: str
    name: str
    parent: str = ""
    camera: str | None = None
    fetch: bool = False
    topics: Mapping[str, str] = field(default_factory=dict)
    salvage: bool = False
    listed_bytes: int = 0


@dataclass(frozen=True, slots=True)
class Found:
    """A recording, and the line of the manifest that named it first."""

    source: Source
    line: int


def expand(manifest: Manifest) -> list[Found]:
    """Return the recordings, each once; one that is to be read in several ways, once for each.

    Raises:
        InputError: A path or name does not exist, or a pattern matches nothing; with the line.

    """
    seen: dict[tuple[object, ...], Found] = {}
    for spec in manifest.sources:
        try:
            found = [source for source in _sources(spec) if _is_meant(source, spec, manifest)]
        except UsageError as error:
            raise _error(manifest, spec, error.message, error.hint) from error
        if not found:
            raise _error(manifest, spec, "no recording is there", _hint(spec))
        if spec.label is not None and len(found) > 1:
            raise _error(manifest, spec, f"label names one source, here are {len(found)}")
        for source in found:
            # All that decides about the outputs; `fetch` does not, and one that wants it is enough.
            key = (source.uri, source.name, tuple(sorted(source.topics.items())), source.salvage)
            first = seen.setdefault(key, Found(source, spec.line))
            if source.fetch and not first.source.fetch:
                seen[key] = replace(first, source=replace(first.source, fetch=True))
    return list(seen.values())


def _is_meant(source: Source, spec: SourceSpec, manifest: Manifest) -> bool:
    """Whether what a `[[source]]` matches is a recording of it, and not what only lies there."""
    return (
        not _is_excluded(source, spec.exclude)
        and not _is_output(source.uri, spec.path, manifest.destination)
        and not _is_of_batch(source.uri, spec.path, manifest.path)
    )


def _is_of_batch(uri: str, path: str | None, manifest: Path) -> bool:
    """Whether a pattern has matched the manifest itself, or a plan."""
    if path is None or not is_pattern(path) or is_remote(path):
        return False
    if uri == os.path.normpath(manifest.absolute()):
        return True
    try:
        return uri.endswith(".json") and Path(uri).is_file() and is_plan_file(Path(uri))
    except OSError:
        return False  # it is told when it is opened


def _error(manifest: Manifest, spec: SourceSpec, message: str, hint: str | None = None) -> InputError:
    return InputError(message, path=manifest.path, location=f"line {spec.line}", hint=hint)


def _hint(spec: SourceSpec) -> str:
    if spec.path is not None or spec.names:
        return "look at the pattern and at exclude"
    catalogue = load_catalogue()
    cameras = sorted({entry.camera for entry in catalogue if entry.camera})
    categories = sorted({entry.category.partition(" (")[0] for entry in catalogue if entry.category})
    return f"cameras: {', '.join(cameras)}; categories: {', '.join(categories)}"


def _is_output(uri: str, path: str | None, destination: str) -> bool:
    """Whether a pattern has matched the destination, or what is in it, by reaching over it."""
    if path is None or not is_pattern(path):
        return False
    parts = path.split("/")
    root = "/".join(parts[: next(number for number, part in enumerate(parts) if is_pattern(part))])
    return (
        f"{destination}/".startswith(f"{root}/")
        and destination != root
        and (f"{uri}/".startswith(f"{destination}/"))
    )


def _is_excluded(source: Source, patterns: tuple[str, ...]) -> bool:
    return any(
        fnmatchcase(name, pattern) for name in (source.name, last_name(source.uri)) for pattern in patterns
    )


def _sources(spec: SourceSpec) -> Iterator[Source]:
    if spec.path is not None:
        for uri, nbytes in _places(spec.path).items():
            name, parent = spec.label or stem(last_name(uri)), parent_name(uri)
            yield Source(uri, name, parent, None, spec.fetch, spec.topics, spec.salvage, nbytes)
        return
    for entry in _entries(spec):
        uri, name = f"{CATALOGUE}{entry.name}", spec.label or entry.name
        yield Source(uri, name, "", entry.camera, spec.fetch, spec.topics, spec.salvage)


def _entries(spec: SourceSpec) -> Iterable[Entry]:
    catalogue = load_catalogue()
    if spec.names:
        return [catalogue.get(name) for name in spec.names]
    return catalogue.filter(spec.camera, spec.category, spec.kind or "sequence")


def _places(path: str) -> dict[str, int]:
    """Return what a path stands for, and sizes where they are known."""
    if is_remote(path):
        if not is_pattern(path):
            return {path: 0}
        if path.partition("://")[0] in WEB_SCHEMES:
            raise UsageError("the web has no lists, so a pattern matches nothing", hint="name each URL")
        from tumtools.batch.stores.remote import match  # noqa: PLC0415 - an extra

        return match(path)
    if os.path.lexists(path):
        return {path: 0}
    if not is_pattern(path):
        raise UsageError(f"there is no such file or folder: {path}")
    found = glob.glob(path, recursive=True)  # noqa: PTH207 - Path.glob takes no absolute pattern
    return dict.fromkeys(sorted(found), 0)
