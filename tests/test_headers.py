# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Every source file says whose it is and under which licence."""

from __future__ import annotations

import subprocess
from pathlib import Path

ROOT = Path(__file__).parents[1]
HEADER = "# SPDX-FileCopyrightText: 2026 The tumtools authors\n# SPDX-License-Identifier: MIT\n"


def test_every_python_file_begins_with_the_spdx_lines() -> None:
    files = subprocess.run(
        ["git", "ls-files", "*.py"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout.split()
    without = [
        name
        for name in files
        if not (ROOT / name).read_text().removeprefix("#!/usr/bin/env python3\n").startswith(HEADER)
    ]
    assert files
    assert without == []
