# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The figures of the documentation are those that the script draws, and each is shown."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path

import pytest
from PIL import Image

DOCS = Path(__file__).parents[2] / "docs"


def test_the_script_draws_the_figures_that_the_pages_show(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    spec = importlib.util.spec_from_file_location("generate_figures", DOCS / "generate_figures.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.main(tmp_path)
    kept = DOCS / "explanation" / "figures"
    drawn = {path.name for path in tmp_path.iterdir()}
    assert drawn == {path.name for path in kept.iterdir()}
    shown = {
        path.parent / name
        for path in DOCS.rglob("*.md")
        for name in re.findall(r"!\[[^]]*\]\(([^)]+)\)", path.read_text())
    }
    assert shown == {kept / name for name in drawn}
    for name in drawn:
        # Another version of matplotlib may place a letter elsewhere; the size stays.
        with Image.open(kept / name) as old, Image.open(tmp_path / name) as new:
            assert old.size == new.size
        assert (kept / name).stat().st_size < 60_000
