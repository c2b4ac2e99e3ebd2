# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Awkward contents to every format and from there to the benchmark's layout: the same, or refused."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from tests.roundtrip.contents import CONTENTS
from tests.roundtrip.page import REFUSED, content_cell, read_page, text_of
from tests.roundtrip.run import run_content
from tests.roundtrip.variants import Variant, awkward_variants

if TYPE_CHECKING:
    from pathlib import Path

PAGE = read_page()


@pytest.mark.parametrize("variant", awkward_variants(), ids=str)
@pytest.mark.parametrize("content", CONTENTS)
def test_awkward_contents_come_back_or_are_refused(content: str, variant: Variant, tmp_path: Path) -> None:
    outcome = run_content(content, variant, tmp_path)
    said = REFUSED if outcome is None else text_of(outcome)
    assert PAGE.get(content_cell(content, variant)) == said, "run: python docs/generate_matrix.py"
