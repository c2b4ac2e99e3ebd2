# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The rules, a module per family."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from tumtools.validate.rules import (
    accelerometer,
    containers,
    depth,
    files,
    images,
    known,
    poses,
    stamps,
    timing,
)

if TYPE_CHECKING:
    from tumtools.validate.rule import Rule

RULES: Final[dict[str, Rule]] = {
    entry.code: entry
    for family in (files, stamps, timing, images, depth, poses, accelerometer, known, containers)
    for entry in family.RULES
}
"""All rules by code, in the order of their codes."""
