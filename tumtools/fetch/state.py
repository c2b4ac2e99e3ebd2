# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A download in progress: the `.part` file and, beside it, which version of the server's file it is of."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from tumtools.catalogue.table import build
from tumtools.errors import InputError
from tumtools.fetch.atomic import write_text
from tumtools.staging import fsync

if TYPE_CHECKING:
    from collections.abc import Mapping


@dataclass(frozen=True, slots=True)
class Version:
    """Which version of which file: what a resume must match.

    Attributes:
        url: Where it was asked for, before redirects, without credentials.
        etag: Its ETag, quotes included.
        last_modified: Its Last-Modified, as the server wrote it.
        length: Size of the whole file.

    """

    url: str
    etag: str | None = None
    last_modified: str | None = None
    length: int | None = None

    @classmethod
    def of_response(cls, url: str, headers: Mapping[str, str], length: int | None) -> Version:
        """Read from the headers of a response."""
        return cls(url, headers.get("ETag"), headers.get("Last-Modified"), length)

    @property
    def validator(self) -> str | None:
        """What `If-Range` takes: a strong ETag, or else the date (RFC 9110, section 13.1.5)."""
        if self.etag is not None and not self.etag.startswith("W/"):
            return self.etag
        return self.last_modified

    def differs_from(self, other: Version) -> bool:
        """Tell whether the two are surely not the same bytes; mirrors may have ETags of their own."""
        pairs: list[tuple[object, object]] = [(self.length, other.length)]
        if self.url == other.url:
            pairs.append((self.etag, other.etag))
        return any(a is not None and b is not None and a != b for a, b in pairs)


class Part:
    """The `.part` file of a download and its state file.

    Attributes:
        path: The `.part` file.
        version: What it is of; None if nothing is there.

    """

    def __init__(self, target: Path) -> None:
        self.path = Path(f"{target}.part")
        self._state = Path(f"{target}.part.json")
        self.version = self._load()
        if self.version is None:
            self.discard()

    @property
    def size(self) -> int:
        """Bytes that are there."""
        try:
            return self.path.stat().st_size
        except FileNotFoundError:
            return 0

    def begin(self, version: Version) -> None:
        """Empty the file and note what will be written to it."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with self.path.open("wb"):
            pass
        write_text(self._state, json.dumps(asdict(version), indent=1) + "\n")
        self.version = version

    def discard(self) -> None:
        """Remove both files."""
        self.path.unlink(missing_ok=True)
        self._state.unlink(missing_ok=True)
        self.version = None

    def commit(self, target: Path) -> None:
        """Give the complete file its final name."""
        fsync(self.path)
        self.path.replace(target)
        self._state.unlink(missing_ok=True)

    def _load(self) -> Version | None:
        try:
            return build(Version, json.loads(self._state.read_text("utf-8")), str(self._state), "state")
        except (OSError, ValueError, InputError):
            return None  # unreadable means unknown, and the download starts over
