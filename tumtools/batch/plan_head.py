# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""How a plan's file begins: what may be replaced by another plan, and what is no recording."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from pathlib import Path

_HEAD: Final = re.compile(rb'\{\n "schema_version": \d{1,9},\n "plan": "[0-9a-f]{32}",\n "destination": "')
_HEAD_BYTES: Final = 128


def is_plan_file(path: Path) -> bool:
    """Whether a file was written by `tumtools batch plan`.

    Raises:
        OSError: It cannot be read.

    """
    with path.open("rb") as file:
        return _HEAD.match(file.read(_HEAD_BYTES)) is not None
