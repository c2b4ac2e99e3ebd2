# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""No engine at all: the tasks one after the other in this very process; for debuggers and profilers."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Final

from tumtools.batch.engines.engine import Completed, EngineSettings, refuse_address
from tumtools.batch.task import execute
from tumtools.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tumtools.batch.task import Job


class InlineEngine:
    """Runs a job when its outcome is asked for."""

    capacity: Final = 1

    def __init__(self, settings: EngineSettings) -> None:
        refuse_address(settings)
        if settings.timeout is not None or settings.memory_limit is not None:
            raise UsageError("the engine inline has no time-out and no memory limit")
        self._jobs: deque[Job] = deque()

    def submit(self, job: Job) -> None:
        """Take a job."""
        self._jobs.append(job)

    def as_completed(self) -> Iterator[Completed]:
        """Yield jobs as they are done."""
        while self._jobs:
            job = self._jobs.popleft()
            yield Completed(job, execute(job))

    def shutdown(self) -> None:
        """Forget what has not begun."""
        self._jobs.clear()
