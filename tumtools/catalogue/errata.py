# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What a user of a sequence should know, told from its numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tumtools.catalogue.entry import Entry, GroundTruthFacts

_UNCOVERED_S: Final = 1.0
"""Ground truth that is missing for less than this in total is not worth a sentence."""
_PAGE_LENGTH_DIFFERS: Final = 0.02


def errata(entry: Entry) -> tuple[str, ...]:
    """Return sentences about what is special or wrong in a sequence."""
    found = [*entry.errata]
    found += [f"the {stream} file has no rows" for stream in entry.empty_streams]
    if entry.public_groundtruth is False:
        found.append("there is no public ground truth; only the benchmark's online tool can score it")
    if entry.groundtruth is not None:
        found += _of_groundtruth(entry.groundtruth)
    return tuple(found)


def _of_groundtruth(facts: GroundTruthFacts) -> Iterator[str]:
    if facts.duplicate_stamp_rows:
        rows = "row repeats" if facts.duplicate_stamp_rows == 1 else "rows repeat"
        yield f"ground truth: {facts.duplicate_stamp_rows} {rows} a stamp"
    duration, covered = facts.duration_s, facts.duration_with_groundtruth_s
    if duration is not None and covered is not None and duration - covered > _UNCOVERED_S:
        hole = f"; the longest hole has {facts.max_gap_s:g} s" if facts.max_gap_s is not None else ""
        yield f"ground truth covers {covered:g} of {duration:g} s{hole}: do not interpolate across it"
    page, path = facts.page_trajectory_length_m, facts.path_length_sum_m
    if page is not None and path is not None and abs(page - path) > _PAGE_LENGTH_DIFFERS * path:
        yield (
            f"the published length of {page:g} m is smoothed and counts across holes; "
            f"the path through the poses has {path:g} m"
        )
