# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Engines: what runs the tasks of a plan. A table of our own, and an entry-point group for others."""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import entry_points
from typing import TYPE_CHECKING, Final, cast

from tumtools.batch.engines.others import OthersEngine, words_of
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
        UsageError: There is none of that name, what it needs is not installed, or it cannot be started.

    """
    others = entry_points(group=GROUP)
    same = [entry for entry in others if entry.name == name]
    if name in ENGINES:
        module, attribute = ENGINES[name]
        for entry in same:
            settings.say(f"the engine {name} is that of tumtools; {words_of(entry)} is not used")
        factory = getattr(import_module(module), attribute)
        return cast("Callable[[EngineSettings], Engine]", factory)(settings)
    if not same:
        known = ", ".join([*ENGINES, *sorted(others.names)])
        raise UsageError(f"no engine {name!r}", hint=f"engines: {known}")
    for entry in same[1:]:
        settings.say(f"the engine {name} is {words_of(same[0])}; {words_of(entry)} is not used")
    return OthersEngine(same[0], settings)
