# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The catalogue: the benchmark's sequences from the package, and those of a user's own files."""

from __future__ import annotations

import difflib
import json
import os
import re
import tomllib
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Final

from tumtools.catalogue.entry import SUFFIXES, Entry, parse_entry
from tumtools.errors import InputError, MissingInputError, UsageError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

SCHEMA_VERSION: Final = 1
CATALOGUE_VARIABLE: Final = "TUMTOOLS_CATALOGUE"
"""Environment variable: user's catalogue files, separated like PATH."""
USER_FILES: Final = ("catalogue.toml", "catalogue.json")
"""User's catalogue files that are read from the configuration folder where they exist."""

_OFFICIAL_PREFIX = "rgbd_dataset_"


class UnknownNameError(UsageError):
    """No sequence has this name."""


@dataclass(frozen=True)  # no slots: the table of names is made once
class Catalogue:
    """Sequences by name.

    Attributes:
        entries: In the order of the files that they come from.
        source_kinds: What the values of `Entry.sources` mean.
        hosts: The benchmark's hosts: `canonical`, `redirect_target`, `old` (folder URLs).

    """

    entries: tuple[Entry, ...]
    source_kinds: Mapping[str, str] = field(default_factory=dict)
    hosts: Mapping[str, str] = field(default_factory=dict)

    def __iter__(self) -> Iterator[Entry]:
        return iter(self.entries)

    def find(self, name: str) -> Entry | None:
        """Return the sequence of an official, short, page or paper name in any spelling, or None."""
        return self._by_key.get(_key(name))

    def get(self, name: str) -> Entry:
        """Return the sequence of a name.

        Raises:
            UnknownNameError: There is none; the hint suggests what might have been meant.

        """
        entry = self.find(name)
        if entry is not None:
            return entry
        near = self.suggest(name)
        raise UnknownNameError(
            f"no sequence is called {name!r}",
            hint=f"did you mean {' or '.join(near)}?"
            if near
            else "`tumtools list` shows all names; --catalogue FILE adds your own",
        )

    def suggest(self, name: str) -> tuple[str, ...]:
        """Return up to three labels that are close to a name."""
        wanted = _key(name)
        inside = [
            entry.label
            for entry in sorted(self.entries, key=lambda entry: len(entry.name))
            if wanted and (_key(entry.label).startswith(wanted) or _key(entry.label).endswith(f"_{wanted}"))
        ]
        labels = {key: entry.label for key, entry in self._by_key.items()}
        close = [labels[key] for key in difflib.get_close_matches(wanted, labels, 6, cutoff=0.75)]
        return tuple(dict.fromkeys(inside + close))[:3]

    def filter(
        self, camera: str | None = None, category: str | None = None, kind: str | None = None
    ) -> tuple[Entry, ...]:
        """Return the sequences of a camera, a category (part of its name, any case) and a kind."""
        return tuple(
            entry
            for entry in self.entries
            if (camera is None or entry.camera == camera)
            and (category is None or category.lower() in (entry.category or "").lower())
            and (kind is None or entry.kind == kind)
        )

    def with_file(self, path: str | os.PathLike[str]) -> Catalogue:
        """Return this catalogue with the sequences of a user's file added.

        Raises:
            MissingInputError: There is no such file.
            InputError: It is not a catalogue, or a name is taken.

        """
        added = _read(Path(path))
        taken = self._by_key
        for entry in added.entries:
            clash = next((taken[key] for key in _keys(entry) if key in taken), None)
            if clash is not None:
                raise InputError(
                    f"the name {entry.label!r} is taken by {clash.name}",
                    path=path,
                    hint="give it another name; `tumtools fetch --mirror URL` fetches a known sequence "
                    "from another place",
                )
        return replace(self, entries=self.entries + added.entries)

    @cached_property
    def _by_key(self) -> dict[str, Entry]:
        return {key: entry for entry in self.entries for key in _keys(entry)}


def _key(name: str) -> str:
    """Bring a name into one spelling: `fr1 desk`, `freiburg1_desk.tgz` and `FR1/desk` are `fr1_desk`."""
    text = name.strip().strip("/").lower()
    for suffix in sorted(SUFFIXES.values(), key=len, reverse=True):
        text = text.removesuffix(suffix)
    text = re.sub(r"[\s/\-]+", "_", text).removeprefix(_OFFICIAL_PREFIX)
    return re.sub(r"^freiburg(?=\d_)", "fr", text)


def _keys(entry: Entry) -> tuple[str, ...]:
    return tuple(dict.fromkeys(_key(name) for name in (entry.name, entry.label, *entry.aliases)))


def _read(path: Path) -> Catalogue:
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        raise MissingInputError("there is no such catalogue file", path=path) from None
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", path=path) from error
    return _parse(data, str(path), toml=path.suffix.lower() == ".toml")


def _parse(data: bytes, path: str, *, toml: bool) -> Catalogue:
    try:
        text = data.decode("utf-8")
        document: object = tomllib.loads(text) if toml else json.loads(text)
    except (ValueError, RecursionError) as error:
        kind = "TOML" if toml else "JSON"
        raise InputError(
            f"not {kind}: {error}", path=path, hint="a catalogue file is JSON, or TOML if it ends with .toml"
        ) from error
    if not isinstance(document, dict) or not isinstance(document.get("sequences"), list):
        raise InputError(
            "expected a list 'sequences'", path=path, hint="the format is in docs/reference/catalogue.md"
        )
    version = document.get("schema_version", SCHEMA_VERSION)
    if version != SCHEMA_VERSION:
        raise InputError(f"expected schema_version {SCHEMA_VERSION}, got {version!r}", path=path)
    known = ("schema_version", "sequences", "source_kinds", "hosts")
    unknown = [key for key in document if key not in known]
    if unknown:
        raise InputError(f"unknown key {unknown[0]!r}", path=path, hint=f"known keys: {', '.join(known)}")
    entries = [
        parse_entry(value, path, f"sequences[{index}]") for index, value in enumerate(document["sequences"])
    ]
    seen: dict[str, str] = {}
    for entry in entries:
        for key in _keys(entry):
            if key in seen:
                raise InputError(f"{entry.name} and {seen[key]} share the name {key!r}", path=path)
            seen[key] = entry.name
    return Catalogue(tuple(entries), document.get("source_kinds", {}), document.get("hosts", {}))


@cache
def packaged_catalogue() -> Catalogue:
    """Return the benchmark's sequences as the package knows them."""
    data = resources.files("tumtools.catalogue").joinpath("sequences.json").read_bytes()
    return _parse(data, "tumtools/catalogue/sequences.json", toml=False)


def load_catalogue(path: str | os.PathLike[str] | None = None) -> Catalogue:
    """Return the benchmark's sequences and those of the user.

    Args:
        path: A user's catalogue file. Those that `TUMTOOLS_CATALOGUE` names and those in the configuration
            folder are added too.

    Raises:
        InputError: A user's file is not a catalogue.

    """
    paths = [Path(part) for part in os.environ.get(CATALOGUE_VARIABLE, "").split(os.pathsep) if part]
    paths += [file for name in USER_FILES if (file := user_folder() / name).is_file()]
    if path is not None:
        paths.insert(0, Path(path))
    catalogue = packaged_catalogue()
    for file in dict.fromkeys(file.resolve() for file in paths):
        catalogue = catalogue.with_file(file)
    return catalogue


def user_folder() -> Path:
    """Return the user's configuration folder of tumtools."""
    from platformdirs import user_config_path  # noqa: PLC0415 - only needed once the catalogue is

    return user_config_path("tumtools")
