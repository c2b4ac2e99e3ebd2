# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What the comments of a rawlog keep of a sequence: our own notes and digest, read and checked."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

from tumtools.errors import InputError
from tumtools.formats.rawlog import comment
from tumtools.model.sequence import LEFT_OUT, Loss

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

    from tumtools.formats.rawlog.comment import Notes
    from tumtools.formats.rawlog.survey import Remark, Survey
    from tumtools.model.digest import KeptDigest

_T = TypeVar("_T")


@dataclass(frozen=True, slots=True)
class Kept:
    """What is kept.

    Attributes:
        notes: None if there are none, as in rawlogs of others.
        digest: None if there is none, or one of another version.
        losses: What of the comments is not carried over.
        warnings: What is damaged and was left out.

    """

    notes: Notes | None
    digest: Mapping[str, KeptDigest] | None
    losses: tuple[Loss, ...]
    warnings: tuple[str, ...]


def read_kept(path: Path, found: Survey, *, salvage: bool) -> Kept:
    """Read notes and digest.

    Args:
        path: The rawlog, for messages.
        found: What is in it.
        salvage: Leave out what is damaged, and tell.

    Raises:
        InputError: One of them is damaged, or of a later version.

    """
    losses: list[Loss] = []
    warnings: list[str] = []

    def read(remarks: list[Remark], parse: Callable[[str], _T]) -> _T | None:
        if not remarks:
            return None
        if len(remarks) > 1:
            why = "a rawlog has one such comment; the others are of rawlogs that were joined with it"
            losses.append(Loss("comment", "comments of tumtools besides the first", len(remarks) - 1, why))
        first = remarks[0]
        try:
            return parse(first.text)
        except ValueError as error:
            message = f"a comment of tumtools cannot be read ({error})"
            if not salvage:
                hint = "the file is damaged; get it again, or read it without that with --salvage"
                raise InputError(message, path=path, location=first.place, hint=hint) from error
            warnings.append(f"{path}, {first.place}: {message}; this is left out")
            losses.append(Loss("comment", LEFT_OUT, 1, f"{first.place}: {message}"))
            return None

    notes = read(found.notes, comment.parse)
    digest = read(found.digests, comment.parse_digest)
    if found.comments:
        losses.append(Loss("comment", "comment text", len(found.comments), "a sequence has no stream for it"))
    return Kept(notes, digest, tuple(losses), tuple(warnings))
