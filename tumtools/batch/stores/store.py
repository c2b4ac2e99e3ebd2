# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What a store must do."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from collections.abc import Iterator
    from contextlib import AbstractContextManager
    from pathlib import Path

    from tumtools.batch.tree import Measure


class Store(Protocol):
    """Records of a few kB that are read and written as a whole, and outputs.

    Names are relative, their parts separated by `/`.
    """

    def check(self) -> None:
        """See that the store can be written to.

        Raises:
            OutputError: It cannot.

        """

    def read(self, name: str) -> bytes | None:
        """Return a record, or None.

        Raises:
            InputError: It cannot be read.

        """

    def write(self, name: str, data: bytes) -> None:
        """Write a record, durably, in place of an older one.

        Raises:
            OutputError: It cannot be written.

        """

    def create(self, name: str, data: bytes) -> bool:
        """Write a record if there is none; return whether there was none. Of several, one wins."""

    def replace(self, name: str, old: bytes, new: bytes | None) -> bool:
        """Write a record, or with None remove it, if it is still the old one; return whether it was."""

    def names(self, prefix: str) -> Iterator[str]:
        """Yield the names of the records below a prefix that ends with `/`."""

    def measure(self, name: str) -> Measure | None:
        """Look at an output without reading it; None if there is none."""

    def sha256(self, name: str) -> str:
        """Hash an output (`tree.sha256_of`).

        Raises:
            InputError: It cannot be read.

        """

    def output(self, name: str) -> AbstractContextManager[Path]:
        """Give the path to write an output to; when the block ends well, it is in the store.

        The path is complete as soon as it exists, and may exist before: it is to be replaced.
        """
