# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What a recording keeps of a sequence beside its messages: our own metadata and digest, read and checked."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeVar

import numpy as np

from tumtools.errors import InputError
from tumtools.formats import metadata
from tumtools.model import digest
from tumtools.model.sequence import LEFT_OUT, Loss

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from tumtools.formats.metadata import Metadata
    from tumtools.formats.ros.recording import Recording
    from tumtools.model.digest import KeptDigest
    from tumtools.model.sequence import Sequence
    from tumtools.model.text import TextLayout

_T = TypeVar("_T")

SALVAGE_HINT: Final = "--salvage reads the recording without it"


@dataclass(frozen=True, slots=True)
class Kept:
    """What is kept.

    Attributes:
        metadata: None if there is none, as in recordings of others.
        digest: None if there is none, or one of another version.
        losses: What of it is not carried over.
        warnings: What is damaged and was left out.

    """

    metadata: Metadata | None
    digest: Mapping[str, KeptDigest] | None
    losses: tuple[Loss, ...]
    warnings: tuple[str, ...]


def read_kept(recording: Recording, *, salvage: bool) -> Kept:
    """Read metadata and digest.

    Args:
        recording: Any.
        salvage: Leave out what is damaged, and tell.

    Raises:
        InputError: One of them is damaged, or of a later version.

    """
    errors: list[tuple[str, InputError]] = []

    def read(
        name: str, strings: Mapping[str, str] | None, parse: Callable[[Mapping[str, str]], _T]
    ) -> _T | None:
        try:
            return None if strings is None else parse(strings)
        except InputError as error:
            located = type(error)(error.message, path=recording.path, hint=error.hint)
            if not salvage:
                raise located from error
            errors.append((name, located))
            return None

    return Kept(
        metadata=read("metadata", recording.metadata, metadata.from_strings),
        digest=read("digest", recording.digest, _digest),
        losses=(
            *(left_out(f"{name} of tumtools", error) for name, error in errors),
            *_foreign_entries(recording.metadata or {}),
        ),
        warnings=tuple(f"{error.path}: {error.message}; this is left out" for _, error in errors),
    )


def fitting_layouts(
    kept: Metadata | None, sequence: Sequence, path: str
) -> tuple[dict[str, TextLayout], list[str]]:
    """Return the look of the text files as far as it fits what the messages say, and where it does not.

    Args:
        kept: What the recording keeps, if anything.
        sequence: With its signals and the stamps of its images.
        path: Of the recording.

    """
    layouts, notes = {}, []
    for stream, layout in (kept.text if kept else {}).items():
        signal = {"accelerometer": sequence.accelerometer, "groundtruth": sequence.groundtruth}.get(stream)
        stamps = sequence.image_stamps(stream) if signal is None else signal.stamps
        values = np.empty((len(stamps), 0)) if signal is None else signal.values
        layouts[stream] = metadata.fitting(layout, stream, stamps, values)
        dropped = len(layout.overrides) - len(layouts[stream].overrides)
        if dropped:
            notes.append(
                f"{path}: the text that its metadata keeps for {dropped} rows of {stream} does not say what "
                "the messages say, and is left out"
            )
    return layouts, notes


def left_out(stream: str, error: InputError, count: int = 1) -> Loss:
    """Say that a salvage passes over something."""
    why = f"{error.location}: {error.message}" if error.location else error.message
    return Loss(stream, LEFT_OUT, count, why)


def _digest(strings: Mapping[str, str]) -> Mapping[str, KeptDigest] | None:
    if digest.is_damaged(strings):
        raise InputError("its tumtools digest is damaged", hint=f"get it again; {SALVAGE_HINT}")
    return digest.from_strings(strings)


def _foreign_entries(strings: Mapping[str, str]) -> tuple[Loss, ...]:
    count = len(strings.keys() - metadata.KEYS)
    why = "a sequence has no place for what others note there"
    return (Loss("metadata of tumtools", "entries of others not carried over", count, why),) if count else ()
