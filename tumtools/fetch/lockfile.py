# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools.lock`: what was got for files whose checksum nobody publishes. To be committed."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from tumtools.catalogue.entry import as_table
from tumtools.catalogue.table import build
from tumtools.errors import InputError, IntegrityError, OutputError
from tumtools.fetch.atomic import exclusive, write_text

LOCK_NAME: Final = "tumtools.lock"
LOCK_VARIABLE: Final = "TUMTOOLS_LOCK"
SCHEMA_VERSION: Final = 1


@dataclass(frozen=True, slots=True)
class Pin:
    """What a file had when it was first got.

    Attributes:
        name: Official name of the sequence.
        url: Where it came from.
        bytes: Its size.
        sha256: Its checksum.
        last_modified: Date of the server's file, ISO 8601, where the server told.

    """

    name: str
    url: str
    bytes: int
    sha256: str
    last_modified: str | None = None


def find_lock(folder: Path | None = None) -> Path:
    """Return the lock file to use.

    `TUMTOOLS_LOCK`, or the `tumtools.lock` in the current folder or the nearest folder above it; if there is
    none, it will be made in the current folder.
    """
    named = os.environ.get(LOCK_VARIABLE)
    if named:
        return Path(named)
    start = (folder or Path.cwd()).resolve()
    for candidate in (start, *start.parents):
        if (candidate / LOCK_NAME).is_file():
            return candidate / LOCK_NAME
    return start / LOCK_NAME


class LockFile:
    """A lock file; pins by the name of the downloaded file.

    Attributes:
        path: Where it is or will be.

    """

    def __init__(self, path: Path) -> None:
        self.path = path

    def get(self, file_name: str) -> Pin | None:
        """Return what is known of a file.

        Raises:
            InputError: The lock file is damaged: it is not ignored, since it is what is trusted.

        """
        return self._load().get(file_name)

    def add(self, file_name: str, pin: Pin) -> None:
        """Note a file that is trusted from now on; other processes' pins are kept.

        Raises:
            IntegrityError: Another process has noted another file meanwhile.
            OutputError: It cannot be written.

        """
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OutputError(f"cannot be made: {error.strerror}", path=self.path.parent) from error
        with exclusive(self.path.parent):
            pins = self._load()
            before = pins.get(file_name)
            if before is not None and before.sha256 != pin.sha256:
                raise IntegrityError(
                    f"{file_name} was noted with sha256 {before.sha256} meanwhile, this one has {pin.sha256}",
                    path=self.path,
                )
            pins[file_name] = pin
            files = {key: as_table(pins[key]) for key in sorted(pins)}
            document = {"schema_version": SCHEMA_VERSION, "files": files}
            write_text(self.path, json.dumps(document, indent=2) + "\n")

    def _load(self) -> dict[str, Pin]:
        hint = "restore it from version control, or delete it to trust anew what the servers send"
        try:
            document = json.loads(self.path.read_text("utf-8"))
        except FileNotFoundError:
            return {}
        except (OSError, ValueError) as error:
            raise InputError(f"cannot be read: {error}", path=self.path, hint=hint) from error
        if not isinstance(document, dict) or not isinstance(document.get("files"), dict):
            raise InputError("expected a table 'files'", path=self.path, hint=hint)
        if document.get("schema_version") != SCHEMA_VERSION:
            raise InputError(
                f"expected schema_version {SCHEMA_VERSION}, got {document.get('schema_version')!r}",
                path=self.path,
                hint="a newer tumtools wrote it; update",
            )
        return {
            key: build(Pin, value, str(self.path), f"files.{key}") for key, value in document["files"].items()
        }
