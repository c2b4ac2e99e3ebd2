# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Compare an unpacked sequence with its own lists and with the catalogue."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from tumtools.catalogue import Entry

_IMAGES: Final = ("rgb", "depth", "ir")
_LISTS: Final = {stream: f"{stream}.txt" for stream in (*_IMAGES, "groundtruth")}


def differences(
    entry: Entry, root: Path, files: Mapping[str, tuple[int, str]]
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Compare an unpacked sequence with its own lists and with the catalogue.

    Args:
        entry: What the catalogue knows.
        root: Folder of the sequence.
        files: Its files: relative name -> (bytes, sha256).

    Returns:
        What differs from its own lists, and what differs from the catalogue, one sentence each.

    """
    from tumtools.formats.tum.text import parse  # noqa: PLC0415 - brings numpy, which downloads do without

    own: list[str] = []
    found: list[str] = []
    for stream, list_name in _LISTS.items():
        if list_name not in files:
            if stream in entry.streams:
                found.append(f"{list_name} is missing, the catalogue says that there is a stream {stream}")
        elif stream in _IMAGES:
            path = root / list_name
            names = parse(path.read_bytes(), stream, str(path), tolerant=True).names
            counted = f"{list_name} names {len(names)} images"
            missing = [name for name in names if name not in files]
            if missing:
                own.append(f"{counted}, {len(missing)} of them are not there (first: {missing[0]})")
            expected = entry.frames.get(stream, len(names))
            if expected != len(names):
                found.append(f"{counted}, the catalogue counts {expected}")
    return tuple(own), (*found, *_other_bytes(entry, files))


def _other_bytes(entry: Entry, files: Mapping[str, tuple[int, str]]) -> Iterator[str]:
    known = {name: (fact.bytes, fact.sha256) for name, fact in entry.inner_files.items()}
    if entry.groundtruth is not None:
        known["groundtruth.txt"] = (entry.groundtruth.bytes, entry.groundtruth.sha256)
    for name in sorted(known.keys() & files.keys()):
        (nbytes, sha256), there = known[name], files[name]
        if nbytes is not None and nbytes != there[0]:
            yield f"{name} has {there[0]} bytes, the catalogue's has {nbytes}"
        elif sha256 is not None and sha256 != there[1]:
            yield f"{name} has another sha256 than the catalogue's"
