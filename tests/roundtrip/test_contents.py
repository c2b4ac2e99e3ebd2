# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Awkward contents to every format and from there to the benchmark's layout: the same, or refused."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from tests.roundtrip.contents import CONTENTS, refused
from tests.roundtrip.harness import write_and_check
from tests.roundtrip.variants import Variant, awkward_variants, defaults
from tumtools.errors import OutputError
from tumtools.sources import open_source

if TYPE_CHECKING:
    from pathlib import Path


@pytest.mark.parametrize("variant", awkward_variants(), ids=str)
@pytest.mark.parametrize("content", CONTENTS)
def test_awkward_contents_come_back_or_are_refused(content: str, variant: Variant, tmp_path: Path) -> None:
    target = tmp_path / "to" / f"sequence{variant.suffix}"
    with CONTENTS[content](tmp_path) as before:
        if refused(content, variant):
            with pytest.raises(OutputError, match="does not fit"):
                write_and_check(before, target, variant)
            assert not target.parent.exists() or not list(target.parent.iterdir())
            return
        write_and_check(before, target, variant)
    with open_source(target) as between:
        write_and_check(between, tmp_path / "back" / "sequence", defaults()[0])
