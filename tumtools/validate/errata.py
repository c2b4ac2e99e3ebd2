# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Deviations that the catalogue knows of a published sequence: reported once, never as a warning."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.catalogue.catalogue import packaged_catalogue
from tumtools.model.time import parse_stamp

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy.typing as npt

    from tumtools.catalogue.entry import Entry, GroundTruthFacts
    from tumtools.validate.subject import Subject

_SUFFIX: Final = "-groundtruth"
_GAP_TOLERANCE: Final = 0.002
"""Seconds; the catalogue rounds."""
_SHORTEST_GAP: Final = 0.05
_HALF_SECOND: Final = 500_000_000


@dataclass(frozen=True, slots=True)
class Explained:
    """A deviation that is there and that the catalogue lists.

    Attributes:
        codes: Rules whose findings it explains.
        message: What it is.

    """

    codes: tuple[str, ...]
    message: str


def explain(subject: Subject) -> list[Explained]:
    """Return the known deviations of a sequence, as far as they are in the data."""
    entry = _entry(subject)
    if entry is None or entry.groundtruth is None or subject.groundtruth is None or subject.is_estimate:
        return []
    stamps = np.sort(subject.groundtruth.stamps)
    if len(stamps) < 3:  # noqa: PLR2004 - no median
        return []
    return [*_repeats(entry, entry.groundtruth, stamps), *_gaps(entry, entry.groundtruth, stamps)]


def _entry(subject: Subject) -> Entry | None:
    if subject.info is None:
        return None
    return packaged_catalogue().find(subject.info.name.removesuffix(_SUFFIX))


def _repeats(entry: Entry, facts: GroundTruthFacts, stamps: npt.NDArray[np.int64]) -> Iterator[Explained]:
    repeated = stamps[1:][np.diff(stamps) == 0]
    known = {parse_stamp(text) for text in facts.duplicate_stamps or ()}
    if len(repeated) and set(repeated.tolist()) <= known:
        yield Explained(("TUM102",), f"{len(repeated)} repeated stamps, as published in {entry.label}")


def _gaps(entry: Entry, facts: GroundTruthFacts, stamps: npt.NDArray[np.int64]) -> Iterator[Explained]:
    steps = np.diff(stamps)
    period = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    gaps = steps[steps > 2 * period]
    if not len(gaps) or facts.max_gap_s is None or len(gaps) > (facts.gaps_over_2x_median or 0):
        return
    longest = int(gaps.max()) / 1e9
    if longest > facts.max_gap_s + _GAP_TOLERANCE:
        return
    if longest < _SHORTEST_GAP:
        return
    codes = ("TUM103", "TUM109") if (gaps > _HALF_SECOND).any() else ("TUM103",)
    word = "gap" if len(gaps) == 1 else "gaps"
    yield Explained(
        codes, f"{len(gaps)} {word}, the longest of {longest:.2f} s, as published in {entry.label}"
    )
