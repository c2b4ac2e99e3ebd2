# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The outputs of validate, a module each with `render(report) -> str`."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Final, cast

if TYPE_CHECKING:
    from collections.abc import Callable

    from tumtools.validate.engine import Report

FORMATS: Final = ("text", "json", "sarif", "junit", "github", "markdown")
"""Names on the command line; each is a module of this package."""


def render(report: Report, name: str) -> str:
    """Render a report in a format of `FORMATS`; text ends with a line end."""
    module = import_module(f"tumtools.validate.reports.{name}")
    return cast("Callable[[Report], str]", module.render)(report)
