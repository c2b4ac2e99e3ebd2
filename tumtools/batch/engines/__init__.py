# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Engines: what runs the tasks of a plan. A table of our own, and an entry-point group for others."""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import entry_points
from typing import TYPE_CHECKING, Final, cast

from tumtools.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Callable

    from tumtools.batch.engines.engine import Engine, EngineSettings

ENGINES: Final = {
    "local": ("tumtools.batch.engines.local", "LocalEngine"),
    "inline": ("tumtools.batch.engines.inline", "InlineEngine"),
    "dask": ("tumtools.batch.engines.dask", "DaskEngine"),
}
"""Name -> module and class, imported when it is used."""
GROUP: Final = "tumtools.engines"


def create_engine(name: str, settings: EngineSettings) -> Engine:
    """Start an engine.

    Raises:
        UsageError: There is none of that name, or what it needs is not installed.

    """
    if name in ENGINES:
        module, attribute = ENGINES[name]
        factory = getattr(import_module(module), attribute)
        return cast("Callable[[EngineSettings], Engine]", factory)(settings)
    others = entry_points(group=GROUP)
    if name not in others.names:
        known = ", ".join([*ENGINES, *sorted(others.names)])
        raise UsageError(f"no engine {name!r}", hint=f"engines: {known}")
    return cast("Callable[[EngineSettings], Engine]", others[name].load())(settings)
