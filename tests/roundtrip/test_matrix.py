# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Every format to every format and back, with every option: the same, or what is said to be lost."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from tests.roundtrip.harness import run
from tests.roundtrip.page import all_cells, read_page, text_of
from tests.roundtrip.variants import Chain, chain_name, pairs, triples

if TYPE_CHECKING:
    from pathlib import Path

    from tests.roundtrip.base import Sources

PAGE = read_page()


@pytest.mark.parametrize("chain", pairs() + triples(), ids=chain_name)
def test_a_sequence_comes_back_as_it_was_or_as_it_was_said(
    chain: Chain, sources: Sources, tmp_path: Path
) -> None:
    outcome = run(chain, sources[chain[0]], tmp_path)
    assert PAGE.get(chain_name(chain)) == text_of(outcome), "run: python docs/generate_matrix.py"


def test_the_page_has_every_cell_and_no_other() -> None:
    assert list(PAGE) == all_cells(), "run: python docs/generate_matrix.py"
