# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Engines of other packages: whatever goes wrong in one is theirs, and their name is told."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, cast

from tumtools.batch.engines.engine import Completed, EngineLostError
from tumtools.batch.task import Outcome
from tumtools.errors import TumtoolsError, UsageError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from importlib.metadata import EntryPoint

    from tumtools.batch.engines.engine import Engine, EngineSettings
    from tumtools.batch.task import Job


class OthersEngine:
    """The engine of an entry point; its exceptions come out in words.

    Raises:
        UsageError: It cannot be started.

    """

    def __init__(self, entry: EntryPoint, settings: EngineSettings) -> None:
        self._open: list[Job] = []
        self._words = f"the engine {entry.name} ({words_of(entry)})"
        try:
            self._engine = cast("Callable[[EngineSettings], Engine]", entry.load())(settings)
        except (TumtoolsError, KeyboardInterrupt):
            raise
        except BaseException as error:  # an exit of theirs is none of ours
            raise UsageError(
                f"{self._words} cannot be started: {type(error).__name__}: {error}",
                hint="ask those who made it, or choose another with --engine",
            ) from error

    @property
    def capacity(self) -> int:
        """How many jobs it wants to have at a time."""
        with self._named():
            wanted = int(self._engine.capacity)
            if wanted < 1:
                raise ValueError(f"it wants to have {wanted} jobs at a time")
            return wanted

    def submit(self, job: Job) -> None:
        """Take a job."""
        self._open.append(job)
        with self._named():
            self._engine.submit(job)

    def as_completed(self) -> Iterator[Completed]:
        """Yield jobs as they are done: each that was submitted, once."""
        with self._named():
            completed = iter(self._engine.as_completed())
        while True:
            with self._named():
                try:
                    one = self._closed(next(completed))
                except StopIteration:
                    if self._open:
                        raise ValueError(f"it has ended with {len(self._open)} jobs open") from None
                    return
            yield one

    def _closed(self, one: object) -> Completed:
        """Take a job for done, which must be one that is open."""
        if not isinstance(one, Completed) or not isinstance(one.outcome, Outcome | None):
            raise TypeError(f"it says of a job that it is {one!r:.100}")
        numbers = [number for number, job in enumerate(self._open) if job.task.id == one.job.task.id]
        if not numbers:
            raise ValueError(
                f"it says that {one.job.task.output} is done, which it was not given or has told before"
            )
        del self._open[numbers[0]]
        return one

    def shutdown(self) -> None:
        """End all workers."""
        with self._named():
            self._engine.shutdown()

    @contextmanager
    def _named(self) -> Iterator[None]:
        try:
            yield
        except (TumtoolsError, KeyboardInterrupt):
            raise
        except BaseException as error:
            raise EngineLostError(
                f"{self._words} failed: {type(error).__name__}: {error}; "
                "what is done is kept, the rest is as it was",
                hint="ask those who made it, or choose another with --engine, and run again",
            ) from error


def words_of(entry: EntryPoint) -> str:
    """Name an entry point and the package that it is of."""
    return f"{entry.value} of {entry.dist.name}" if entry.dist is not None else entry.value
