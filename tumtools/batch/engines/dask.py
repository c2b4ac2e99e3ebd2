# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""dask.distributed: a scheduler that runs already, or a cluster of processes on this machine."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, cast

from tumtools.batch.engines.engine import Completed, EngineSettings
from tumtools.batch.task import Outcome, execute
from tumtools.errors import UsageError

try:
    import distributed
except ImportError as error:
    raise UsageError("--engine dask needs the extra dask", hint="pip install 'tumtools[dask]'") from error

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tumtools.batch.task import Job

_DASK: Final[Any] = distributed
"""Most of distributed has no types."""
_AHEAD: Final = 4
"""Jobs for each thread of the cluster that the scheduler has in hand."""
_CONNECT_SECONDS: Final = 20


class DaskEngine:
    """Submits jobs to a scheduler; a job whose worker is lost is given to another one."""

    def __init__(self, settings: EngineSettings) -> None:
        if settings.timeout is not None:
            raise UsageError("--timeout is not for dask", hint="--engine local has it")
        self._cluster: Any = None
        if settings.address is None:
            # One thread a worker: a crash takes one task with it, and memory limits mean one task.
            limit = settings.memory_limit if settings.memory_limit is not None else "auto"
            self._cluster = _DASK.LocalCluster(
                n_workers=settings.workers,
                threads_per_worker=1,
                memory_limit=limit,
                host="127.0.0.1",
                dashboard_address=None,
            )
        elif settings.memory_limit is not None:
            raise UsageError("--memory-limit is not for a cluster that runs", hint="`dask worker` has it")
        try:
            self._client: Any = _DASK.Client(self._cluster or settings.address, timeout=_CONNECT_SECONDS)
        except (OSError, ValueError) as error:
            raise UsageError(
                f"no dask scheduler at {settings.address}: {error}", hint="start one with `dask scheduler`"
            ) from error
        self._jobs: dict[str, Job] = {}
        self._new: list[Any] = []

    @property
    def capacity(self) -> int:
        """A few jobs for each thread of the cluster, so that none waits for the scheduler."""
        threads = cast("dict[str, int]", self._client.nthreads())
        return max(_AHEAD * sum(threads.values()), _AHEAD)

    def submit(self, job: Job) -> None:
        """Take a job."""
        # Not pure: a task that is submitted again, after a failure, is to run again.
        future = self._client.submit(execute, job, pure=False, retries=0)
        self._jobs[future.key] = job
        self._new.append(future)

    def as_completed(self) -> Iterator[Completed]:
        """Yield jobs as they are done."""
        futures, self._new = self._new, []
        waiting = _DASK.as_completed(futures, with_results=True, raise_errors=False)
        for future, result in waiting:
            job = self._jobs.pop(future.key)
            future.release()
            if isinstance(result, Outcome):
                yield Completed(job, result)
            else:
                yield Completed(job, None, _reason(result))
            for new in self._new:
                waiting.add(new)
            self._new.clear()

    def shutdown(self) -> None:
        """Give up what is not done; end the cluster if it is ours."""
        self._client.close()
        if self._cluster is not None:
            self._cluster.close()


def _reason(result: object) -> str:
    """Say why there is no outcome; dask gives what `sys.exc_info` gives."""
    error = result[1] if isinstance(result, tuple) else result
    return f"{type(error).__name__}: {error}".partition("\n")[0]
