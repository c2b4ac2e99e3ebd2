# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Run all cells of the matrix of conversions and write its page (`python docs/generate_matrix.py`)."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def main() -> None:
    """Run and write."""
    sys.path.insert(0, str(ROOT))
    from tests.roundtrip.page import PATH, render  # noqa: PLC0415 - found only now
    from tests.roundtrip.run import run_all  # noqa: PLC0415

    with tempfile.TemporaryDirectory() as folder:
        results, totals = run_all(Path(folder))
    PATH.write_text(render(results, totals))


if __name__ == "__main__":
    main()
