# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Run all cells of the matrix, one after another."""

from __future__ import annotations

import shutil
from typing import TYPE_CHECKING

from tests.roundtrip.base import Sources, make_base
from tests.roundtrip.contents import CONTENTS, refused
from tests.roundtrip.harness import Outcome, run, write_and_check
from tests.roundtrip.page import REFUSED, Totals, content_cell, text_of
from tests.roundtrip.variants import Variant, awkward_variants, chain_name, defaults, pairs, triples
from tumtools.errors import OutputError
from tumtools.sources import open_source

if TYPE_CHECKING:
    from pathlib import Path


def run_content(content: str, variant: Variant, folder: Path) -> Outcome | None:
    """Take a content to a variant and from there to the benchmark's layout; None if it is refused.

    Raises:
        AssertionError: Something is not as it should be.

    """
    target = folder / "to" / f"sequence{variant.suffix}"
    with CONTENTS[content](folder) as before:
        if refused(content, variant):
            try:
                write_and_check(before, target, variant)
            except OutputError:
                assert not target.parent.exists() or not list(target.parent.iterdir())
                return None
            raise AssertionError("it should have been refused")
        there = write_and_check(before, target, variant)
    with open_source(target) as between:
        back = write_and_check(between, folder / "back" / "sequence", defaults()[0])
    return there + back


def run_all(folder: Path) -> tuple[dict[str, str], Totals]:
    """Run all cells; return what each gave, and what was compared.

    Args:
        folder: For the files; a cell's are removed when it is done.

    Raises:
        AssertionError: A cell is not as it should be.

    """
    sources = Sources(make_base(folder), folder / "sources")
    outcomes: dict[str, Outcome | None] = {}
    for chain in pairs() + triples():
        outcomes[chain_name(chain)] = run(chain, sources[chain[0]], folder / "cell")
        shutil.rmtree(folder / "cell")
    for content in CONTENTS:
        for variant in awkward_variants():
            cell = content_cell(content, variant)
            (folder / "cell").mkdir()
            outcomes[cell] = run_content(content, variant, folder / "cell")
            shutil.rmtree(folder / "cell")
    done = [outcome for outcome in outcomes.values() if outcome is not None]
    totals = Totals(
        conversions=sum(len(outcome.steps) for outcome in done),
        images=sum(outcome.images for outcome in done),
        pixels=sum(outcome.pixels for outcome in done),
        nbytes=sum(outcome.nbytes for outcome in done),
    )
    return {
        cell: REFUSED if outcome is None else text_of(outcome) for cell, outcome in outcomes.items()
    }, totals
