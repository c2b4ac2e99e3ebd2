# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The errors of tumtools.

Each is also the matching builtin, says what is wrong, where, and what to do about it, and carries
the exit code that the command line ends with.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

if TYPE_CHECKING:
    import os


class TumtoolsError(Exception):
    """Base of all errors that tumtools raises on purpose.

    Args:
        message: What is wrong, as a sentence without a full stop; names what was expected.
        path: The file or folder concerned.
        location: Where in it: ``line 7``, ``offset 1234``, ``member rgb/1.png``.
        hint: What the user can do about it.

    """

    exit_code: ClassVar[int] = 70

    def __init__(
        self,
        message: str,
        *,
        path: str | os.PathLike[str] | None = None,
        location: str | None = None,
        hint: str | None = None,
    ) -> None:
        super().__init__(message)
        self.message = message
        self.path = None if path is None else str(path)
        self.location = location
        self.hint = hint

    def __str__(self) -> str:
        where = ", ".join(part for part in (self.path, self.location) if part)
        text = f"{where}: {self.message}" if where else self.message
        return f"{text}\n  hint: {self.hint}" if self.hint else text


class UsageError(TumtoolsError, ValueError):
    """The request makes no sense: an option that the format does not have, a bad value."""

    exit_code = 2


class LossRefusedError(TumtoolsError, ValueError):
    """``--strict`` was asked for and something would be lost. Nothing has been written."""

    exit_code = 3


class InputError(TumtoolsError, ValueError):
    """An input cannot be read: damaged, truncated, or not what it claims to be."""

    exit_code = 4


class MissingInputError(InputError, FileNotFoundError):
    """A file that was named does not exist."""


class UnsupportedInputError(InputError, NotImplementedError):
    """A well-formed input uses something that tumtools does not read."""


class OutputError(TumtoolsError, OSError):
    """The result cannot be written: no space, no permission, the target exists."""

    exit_code = 4


class FetchError(TumtoolsError, OSError):
    """A download failed, or what came is not what was asked for."""

    exit_code = 5


class IntegrityError(FetchError):
    """A checksum or a size differs from what is known."""


class InternalError(TumtoolsError, RuntimeError):
    """A bug of tumtools: a promise of ours does not hold."""

    exit_code = 70
