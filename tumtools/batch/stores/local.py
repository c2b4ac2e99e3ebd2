# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A folder as a store."""

from __future__ import annotations

import os
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final

from tumtools.batch.tree import measure, sha256_of
from tumtools.errors import InputError, OutputError
from tumtools.fetch.atomic import exclusive
from tumtools.staging import fsync

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tumtools.batch.tree import Measure

_LOCK: Final = ".tumtools/lock"
_NEW: Final = ".tumtools/new"


class LocalStore:
    """A folder of this machine, or one that several machines share.

    Records are written one at a time, under a lock of the file system: so one name is enough for what is
    not complete yet, and what a killed process leaves there is overwritten by the next.
    """

    def __init__(self, place: str) -> None:
        self._root = Path(place)

    def check(self) -> None:
        """See that the folder can be written to, and make it if need be."""
        try:
            with self._locked(), (self._root / _NEW).open("wb"):
                (self._root / _NEW).unlink()
        except OSError as error:
            raise OutputError(
                f"the destination cannot be written to: {_cause(error)}",
                path=self._root,
                hint="name another one in the manifest and plan again, or give this user the right to write",
            ) from error

    def read(self, name: str) -> bytes | None:
        """Return a record, or None."""
        try:
            return (self._root / name).read_bytes()
        except (FileNotFoundError, NotADirectoryError):
            return None
        except OSError as error:
            raise InputError(f"cannot be read: {error.strerror}", path=self._root / name) from error

    def write(self, name: str, data: bytes) -> None:
        """Write a record."""
        with self._locked():
            self._put(name, data, durable=True)

    def create(self, name: str, data: bytes) -> bool:
        """Write a record if there is none."""
        with self._locked():
            if (self._root / name).exists():
                return False
            self._put(name, data)
            return True

    def replace(self, name: str, old: bytes, new: bytes | None) -> bool:
        """Write or remove a record if it is still the old one."""
        with self._locked():
            if self.read(name) != old:
                return False
            if new is None:
                (self._root / name).unlink()
            else:
                self._put(name, new)
            return True

    def names(self, prefix: str) -> Iterator[str]:
        """Yield the names of the records below a prefix."""
        for path in sorted((self._root / prefix).rglob("*")):
            if path.is_file():
                yield path.relative_to(self._root).as_posix()

    def measure(self, name: str) -> Measure | None:
        """Look at an output."""
        return measure(self._root / name)

    def sha256(self, name: str) -> str:
        """Hash an output."""
        return sha256_of(self._root / name)

    @contextmanager
    def output(self, name: str) -> Iterator[Path]:
        """Give the final path itself; conversions stage beside it."""
        yield self._root / name

    @contextmanager
    def _locked(self) -> Iterator[None]:
        with exclusive(self._root / _LOCK):
            yield

    def _put(self, name: str, data: bytes, *, durable: bool = False) -> None:
        path, new = self._root / name, self._root / _NEW
        try:
            with new.open("wb") as file:
                file.write(data)
                file.flush()
                if durable:
                    os.fsync(file.fileno())
            path.parent.mkdir(parents=True, exist_ok=True)
            new.replace(path)
            if durable:
                fsync(path.parent)
        except BaseException as error:
            with suppress(OSError):
                new.unlink()
            if isinstance(error, OSError):
                raise OutputError(f"cannot be written: {error.strerror}", path=path) from error
            raise


def _cause(error: OSError) -> str:
    """Say what the system said, which an error of ours has as its cause."""
    cause = error.__cause__ if isinstance(error.__cause__, OSError) else error
    return cause.strerror or str(error).partition("\n")[0]
