# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""dask.distributed: a scheduler that runs already, or a cluster of processes on this machine."""

from __future__ import annotations

import logging
import time
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Any, Final, cast

from tumtools.batch.engines.engine import Completed, EngineLostError, EngineSettings
from tumtools.batch.engines.interrupts import children_undisturbed
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
_CLOSE_SECONDS: Final = 10
_LOOK_SECONDS: Final = 0.5
_POLL_SECONDS: Final = 0.01
_OF_CONNECTIONS: Final = ("distributed.client", "tornado.application")
_SILENCE_SECONDS: Final = 10.0
"""After which it is looked whether there are any workers left."""


class DaskEngine:
    """Submits jobs to a scheduler; a job whose worker is lost is given to another one."""

    def __init__(self, settings: EngineSettings) -> None:
        if settings.timeout is not None:
            raise UsageError("--timeout is not for dask", hint="--engine local has it")
        self._settings = settings
        self._cluster: Any = None
        if settings.address is None:
            self._cluster = _own_cluster(settings)
        elif settings.memory_limit is not None:
            raise UsageError("--memory-limit is not for a cluster that runs", hint="`dask worker` has it")
        try:
            self._client: Any = _DASK.Client(self._cluster or settings.address, timeout=_CONNECT_SECONDS)
        except (OSError, ValueError) as error:
            raise UsageError(
                f"no dask scheduler at {settings.address}: {error}", hint="start one with `dask scheduler`"
            ) from error
        if self._cluster is not None:
            self._client.run(_hush_worker)
        self._silence = ExitStack()
        self._silence.enter_context(_silenced(*_OF_CONNECTIONS))
        self._jobs: dict[str, Job] = {}
        self._new: list[Any] = []
        self._told = False

    @property
    def capacity(self) -> int:
        """A few jobs for each thread of the cluster, so that none waits for the scheduler."""
        while not (threads := self._threads()):
            self._tell_of_no_workers()
            time.sleep(_LOOK_SECONDS)
        return _AHEAD * threads

    def submit(self, job: Job) -> None:
        """Take a job."""
        with self._unless_lost():
            # Not pure: a task that is submitted again, after a failure, is to run again.
            function = execute if self._cluster is None else _execute_in_own_cluster
            future = self._client.submit(function, job, pure=False, retries=0)
        self._jobs[future.key] = job
        self._new.append(future)

    def as_completed(self) -> Iterator[Completed]:
        """Yield jobs as they are done."""
        futures, self._new = self._new, []
        waiting = _DASK.as_completed(futures, with_results=True, raise_errors=False)
        while self._wait(waiting):
            future, result = next(waiting)
            if _is_cancelled(result):  # we never do that; dask does when the scheduler is gone
                raise self._lost()
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
        self._silence.close()
        with _silenced("distributed", *_OF_CONNECTIONS):
            self._client.close(timeout=_CLOSE_SECONDS)
            if self._cluster is not None:
                self._cluster.close(timeout=_CLOSE_SECONDS)

    def _wait(self, waiting: Any) -> bool:  # noqa: ANN401 - of dask
        """Wait for a result and return whether there will be one; never for a scheduler that is gone."""
        since = time.monotonic()
        while not waiting.has_ready():
            if waiting.is_empty():
                return False
            if self._client.status not in {"running", "connecting"}:
                raise self._lost()
            if time.monotonic() - since > _SILENCE_SECONDS:
                since = time.monotonic()
                if not self._threads():
                    self._tell_of_no_workers()
            time.sleep(_POLL_SECONDS)
        return True

    def _threads(self) -> int:
        with self._unless_lost():
            return sum(cast("dict[str, int]", self._client.nthreads()).values())

    def _tell_of_no_workers(self) -> None:
        if not self._told:
            self._told = True
            self._settings.say(
                f"waiting for workers: the dask scheduler at {self._address} has none "
                f"(start some with `dask worker {self._address}`)"
            )

    @property
    def _address(self) -> str:
        return self._settings.address or "this machine"

    @contextmanager
    def _unless_lost(self) -> Iterator[None]:
        """Say in words that the scheduler does not answer."""
        try:
            yield
        except (OSError, TimeoutError, CancelledError, RuntimeError, ValueError) as error:
            raise self._lost() from error

    def _lost(self) -> EngineLostError:
        return EngineLostError(
            f"the dask scheduler at {self._address} is gone; what is done is kept, the rest is as it was",
            hint="start the scheduler again, and run again",
        )


def _own_cluster(settings: EngineSettings) -> object:
    """Start a cluster of processes on this machine, which Ctrl-C is not for: we end it."""
    with children_undisturbed():
        # One thread a worker: a crash takes one task with it, and memory limits mean one task.
        return _DASK.LocalCluster(
            n_workers=settings.workers,
            threads_per_worker=1,
            memory_limit=settings.memory_limit if settings.memory_limit is not None else "auto",
            host="127.0.0.1",
            dashboard_address=None,
        )


def _execute_in_own_cluster(job: Job) -> Outcome:
    """Do a task, also in a worker that was started in place of one that was lost."""
    _hush_worker()
    return execute(job)


def _hush_worker() -> None:
    """Let a worker that we end not tell of what it had in hand, nor that the scheduler ended before it."""
    logging.getLogger("distributed").setLevel(logging.CRITICAL + 1)


@contextmanager
def _silenced(*names: str) -> Iterator[None]:
    """Keep what dask logs of something that we tell ourselves, or bring about, to itself."""
    loggers = [logging.getLogger(name) for name in names]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


def _is_cancelled(result: object) -> bool:
    error = result[1] if isinstance(result, tuple) else result
    return isinstance(error, CancelledError)


def _reason(result: object) -> str:
    """Say why there is no outcome; dask gives what `sys.exc_info` gives."""
    error = result[1] if isinstance(result, tuple) else result
    return f"{type(error).__name__}: {error}".partition("\n")[0]
