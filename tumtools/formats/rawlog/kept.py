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
        if len(remarks) != 1:
            return None
        remark = remarks[0]
        try:
            return parse(remark.text)
        except (InputError, ValueError) as error:
            reason = error.message if isinstance(error, InputError) else str(error)
            message = f"a comment of tumtools cannot be read ({reason})"
            if not salvage:
                hint = "the file is damaged; get it again, or read it without that with --salvage"
                kind = type(error) if isinstance(error, InputError) else InputError
                raise kind(message, path=path, location=remark.place, hint=hint) from error
            warnings.append(f"{path}, {remark.place}: {message}; this is left out")
            losses.append(Loss("comment", LEFT_OUT, 1, f"{remark.place}: {message}"))
            return None

    notes = read(found.notes, comment.parse)
    digest = read(found.digests, comment.parse_digest)
    if len(found.notes) > 1:
        warnings.append(
            f"{path}: {len(found.notes)} rawlogs of tumtools have been put together in it; header lines, "
            "decimals and the order of rows, which each has its own of, are left out"
        )
        why = "each is about a part of the rawlog only"
        losses.append(Loss("comment", "comment of tumtools", len(found.notes), why))
    if found.comments:
        losses.append(Loss("comment", "comment text", len(found.comments), "a sequence has no stream for it"))
    return Kept(notes, digest, tuple(losses), tuple(warnings))
