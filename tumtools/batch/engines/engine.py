# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What an engine must do: take jobs, give back what came of them, end."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from tumtools.errors import OutputError, UsageError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from tumtools.batch.task import Job, Outcome


def say_nothing(text: str) -> None:
    """Nobody listens."""
    del text


@dataclass(frozen=True, slots=True)
class EngineSettings:
    """What an engine is made with; each takes what means something to it.

    Attributes:
        workers: Tasks side by side.
        address: Of a scheduler that runs already.
        timeout: Seconds that a task may take; None for no limit.
        memory_limit: Bytes that a worker may have; None for no limit.
        say: Told, in a line, what a person who waits should know.

    """

    workers: int = 1
    address: str | None = None
    timeout: float | None = None
    memory_limit: int | None = None
    say: Callable[[str], None] = say_nothing


def refuse_address(settings: EngineSettings) -> None:
    """Refuse the address of a scheduler, for an engine that has none.

    Raises:
        UsageError: There is one.

    """
    if settings.address is not None:
        raise UsageError("--address is for a scheduler of dask", hint="add --engine dask")


class EngineLostError(OutputError):
    """What runs the jobs is gone, and not for something that a job did."""


@dataclass(frozen=True, slots=True)
class Completed:
    """A job that an engine is done with.

    Attributes:
        job: As submitted.
        outcome: What came of it; None if its worker was lost.
        reason: Why there is no outcome.

    """

    job: Job
    outcome: Outcome | None
    reason: str = ""


class Engine(Protocol):
    """Runs jobs with `tumtools.batch.task.execute`, in whatever processes it has.

    A third-party package registers a callable that takes `EngineSettings` and returns an engine, as an
    entry point of the group `tumtools.engines`.
    """

    @property
    def capacity(self) -> int:
        """How many jobs it wants to have at a time."""

    def submit(self, job: Job) -> None:
        """Take a job."""

    def as_completed(self) -> Iterator[Completed]:
        """Yield each submitted job when it is done, in any order; end when there is none left.

        More jobs may be submitted between two of them.

        Raises:
            EngineLostError: The engine itself is gone; what it was given is left as it is.

        """

    def shutdown(self) -> None:
        """End all workers; what they work on is given up and its claims are released."""
