# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Engines of other packages: whatever goes wrong in one is theirs, and their name is told."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, cast

from tumtools.batch.engines.engine import EngineLostError
from tumtools.errors import TumtoolsError, UsageError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from importlib.metadata import EntryPoint

    from tumtools.batch.engines.engine import Completed, Engine, EngineSettings
    from tumtools.batch.task import Job


class OthersEngine:
    """The engine of an entry point; its exceptions come out in words.

    Raises:
        UsageError: It cannot be started.

    """

    def __init__(self, entry: EntryPoint, settings: EngineSettings) -> None:
        self._words = f"the engine {entry.name} ({words_of(entry)})"
        try:
            self._engine = cast("Callable[[EngineSettings], Engine]", entry.load())(settings)
        except TumtoolsError:
            raise
        except Exception as error:
            raise UsageError(
                f"{self._words} cannot be started: {type(error).__name__}: {error}",
                hint="ask those who made it, or choose another with --engine",
            ) from error

    @property
    def capacity(self) -> int:
        """How many jobs it wants to have at a time."""
        with self._named():
            return int(self._engine.capacity)

    def submit(self, job: Job) -> None:
        """Take a job."""
        with self._named():
            self._engine.submit(job)

    def as_completed(self) -> Iterator[Completed]:
        """Yield jobs as they are done."""
        with self._named():
            completed = iter(self._engine.as_completed())
        while True:
            with self._named():
                try:
                    one = next(completed)
                except StopIteration:
                    return
            yield one

    def shutdown(self) -> None:
        """End all workers."""
        with self._named():
            self._engine.shutdown()

    @contextmanager
    def _named(self) -> Iterator[None]:
        try:
            yield
        except TumtoolsError:
            raise
        except Exception as error:
            raise EngineLostError(
                f"{self._words} failed: {type(error).__name__}: {error}; "
                "what is done is kept, the rest is as it was",
                hint="ask those who made it, or choose another with --engine, and run again",
            ) from error


def words_of(entry: EntryPoint) -> str:
    """Name an entry point and the package that it is of."""
    return f"{entry.value} of {entry.dist.name}" if entry.dist is not None else entry.value
