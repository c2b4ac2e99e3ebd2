# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The page of the matrix: made from what the cells gave, and read again to see that they still give it."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from tests.roundtrip.contents import CONTENTS
from tests.roundtrip.variants import (
    Variant,
    all_variants,
    awkward_variants,
    chain_name,
    defaults,
    pairs,
    triples,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from tests.roundtrip.harness import Outcome
    from tumtools.model.sequence import Loss

PATH: Final = Path(__file__).parents[2] / "docs" / "reference" / "matrix.md"
NOTE: Final = "<!-- Made by docs/generate_matrix.py; do not edit. -->"
SAME: Final = "same"
REFUSED: Final = "refused"


_ASKED: Final = {
    "stream": "{} left out as asked",
    "camera": "camera as asked",
    "frame id": "frame id of {} as asked",
    "text": "names of files of {} made up",
}


@dataclass(frozen=True)
class Totals:
    """What all cells have compared."""

    conversions: int
    images: int
    pixels: int
    nbytes: int


def content_cell(content: str, variant: Variant) -> str:
    """Return the name of a cell of an awkward content."""
    return f"{content}: {variant} -> tum"


def all_cells() -> list[str]:
    """Return the names of all cells, in the order of the page."""
    chains = [chain_name(cell) for cell in pairs() + triples()]
    return chains + [content_cell(content, variant) for content in CONTENTS for variant in awkward_variants()]


def text_of(outcome: Outcome) -> str:
    """Return what is said of a cell: `same`, or what is lost in each step."""
    asked = ", ".join(_ASKED[what].format(stream) for stream, what in sorted(outcome.asked))
    if not any(outcome.steps):
        return f"{SAME}, but {asked}" if asked else SAME
    text = "; then ".join(_losses(step) if step else SAME for step in outcome.steps)
    return f"{text}; and {asked}" if asked else text


def _losses(losses: Iterable[Loss]) -> str:
    return ", ".join(sorted(_loss(loss) for loss in losses))


def _loss(loss: Loss) -> str:
    error = "" if loss.largest_error is None else f", at most {loss.largest_error:.2g} {loss.unit}"
    return f"{loss.stream} {loss.what} ({loss.count}{error})"


def read_page() -> dict[str, str]:
    """Return what the page says of each cell."""
    found = {}
    for line in PATH.read_text().splitlines() if PATH.is_file() else ():
        if line.startswith("| `"):
            cell, _, text = line.removeprefix("| `").removesuffix(" |").partition("` | ")
            found[cell] = text
    return found


def render(results: Mapping[str, str], totals: Totals) -> str:
    """Return the page.

    Args:
        results: What each cell gave, by its name.
        totals: Over all cells.

    """
    return "\n".join(
        [
            *_head(results, totals),
            *_formats(results),
            *_variants(results),
            *_contents(results),
            *_all(results),
        ]
    )


def _head(results: Mapping[str, str], totals: Totals) -> Iterator[str]:
    kinds = Counter(_kind(text) for text in results.values())
    yield f"""{NOTE}

# The matrix of conversions

Each cell is a chain of conversions of a small sequence: four colour and four depth images of 64x48
pixels, 40 rows of accelerations, 12 of ground truth. Each step is read back and compared with what went
into it: stamps to the nanosecond, values to the bit, pixels, and the text of the files; each loss that is
reported is compared with what the target cannot hold, computed from the source without the writer. `same`
means: no loss is reported, the digests of all streams are equal, `tumtools diff` finds nothing, and the
end of the chain is its beginning. Anything else is a bug, and fails the tests.

The tests run every cell and compare it with this page. `python docs/generate_matrix.py` runs them all and
writes it.

| | |
|---|---|
| cells | {len(results)} |
| the same, but for what was asked | {kinds[SAME]} |
| with a loss, which is reported | {kinds["a loss, reported"]} |
| refused, since the target cannot hold the stamps | {kinds[REFUSED]} |
| conversions | {totals.conversions} |
| pairs of images compared | {totals.images:,} |
| pixels compared | {totals.pixels:,} |
| bytes of pixels and rows compared | {totals.nbytes:,} |
"""


def _kind(text: str) -> str:
    if text.startswith(SAME) and ";" not in text:
        return SAME
    return REFUSED if text == REFUSED else "a loss, reported"


def _formats(results: Mapping[str, str]) -> Iterator[str]:
    yield "## Format to format and back\n"
    yield from _table(
        ["from \\ by way of", *map(str, defaults())],
        [[str(a), *(results[chain_name((a, b, a))] for b in defaults())] for a in defaults()],
    )
    kinds = Counter(results[chain_name(cell)] for cell in triples())
    counted = ", ".join(f"{count} {text}" for text, count in sorted(kinds.items()))
    yield f"By way of two other formats, in every order: {counted}.\n"


def _variants(results: Mapping[str, str]) -> Iterator[str]:
    yield "## Every option\n"
    yield "From every format to this one and back; what is lost in the first step, then in the second.\n"
    rows = []
    for variant in all_variants():
        by_text: dict[str, list[str]] = {}
        for a in defaults():
            by_text.setdefault(results[chain_name((a, variant, a))], []).append(str(a))
        shown = [
            text if len(by_text) == 1 else f"{', '.join(names)}: {text}" for text, names in by_text.items()
        ]
        rows.append([str(variant), "<br>".join(shown)])
    yield from _table(["written as", "result"], rows)


def _contents(results: Mapping[str, str]) -> Iterator[str]:
    yield "## Awkward contents\n"
    yield "To each of these and from there to `tum`: " + ", ".join(map(str, awkward_variants())) + ".\n"
    rows = []
    for content in CONTENTS:
        by_text: dict[str, list[str]] = {}
        for variant in awkward_variants():
            by_text.setdefault(results[content_cell(content, variant)], []).append(str(variant))
        shown = [
            text if len(by_text) == 1 else f"{', '.join(names)}: {text}"
            for text, names in sorted(by_text.items(), key=lambda item: -len(item[1]))
        ]
        rows.append([content, "<br>".join(shown)])
    yield from _table(["content", "result"], rows)


def _all(results: Mapping[str, str]) -> Iterator[str]:
    yield "## All cells\n"
    yield from _table(["cell", "result"], [[f"`{cell}`", text] for cell, text in results.items()])


def _table(head: list[str], rows: list[list[str]]) -> Iterator[str]:
    yield "| " + " | ".join(head) + " |"
    yield "|" + "---|" * len(head)
    yield from ("| " + " | ".join(row) + " |" for row in rows)
    yield ""
