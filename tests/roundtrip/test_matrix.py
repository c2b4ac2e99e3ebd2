# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Every format to every format and back, with every option: the same, or what is said to be lost."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from tests.roundtrip.harness import run
from tests.roundtrip.variants import Chain, chain_name, pairs, triples

if TYPE_CHECKING:
    from pathlib import Path

    from tests.roundtrip.base import Sources


@pytest.mark.parametrize("chain", pairs() + triples(), ids=chain_name)
def test_a_sequence_comes_back_as_it_was_or_as_it_was_said(
    chain: Chain, sources: Sources, tmp_path: Path
) -> None:
    run(chain, sources[chain[0]], tmp_path)
