# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Processes of this machine. What crashes, hangs or eats all memory is one task that failed."""

from __future__ import annotations

import multiprocessing
import resource
import signal
import sys
import time
from collections import deque
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing.connection import wait
from typing import TYPE_CHECKING, Any, Final

from tumtools.batch.engines.engine import Completed, EngineSettings, refuse_address
from tumtools.batch.engines.interrupts import children_undisturbed
from tumtools.batch.engines.worker import work
from tumtools.batch.task import Outcome
from tumtools.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from multiprocessing.connection import Connection
    from multiprocessing.context import SpawnProcess

    from tumtools.batch.task import Job

_GRACE_SECONDS: Final = 10.0
"""What a worker gets to clean up behind itself."""

_LONGEST_PAUSE: Final = 3600.0
"""Seconds; the system takes some weeks at most."""


@dataclass(slots=True)
class _Worker:
    """A process, our end of its pipe, and what it works on."""

    process: SpawnProcess
    connection: Connection[Any, Any]
    job: Job | None = None
    ready: bool = False
    deadline: float = field(default=float("inf"))


class LocalEngine:
    """A pool of processes made by spawn, so that no thread or lock of this one is inherited."""

    def __init__(self, settings: EngineSettings) -> None:
        refuse_address(settings)
        _refuse_memory_limit(settings.memory_limit)
        self._settings = settings
        self._context = multiprocessing.get_context("spawn")
        self._queue: deque[Job] = deque()
        self._workers: list[_Worker] = []

    @property
    def capacity(self) -> int:
        """One job in hand for each worker, so that none waits for the parent."""
        return 2 * self._settings.workers

    def submit(self, job: Job) -> None:
        """Take a job."""
        self._queue.append(job)

    def as_completed(self) -> Iterator[Completed]:
        """Yield jobs as they are done."""
        while self._give() or self._busy():
            yield from self._wait()

    def shutdown(self) -> None:
        """End all workers; they get some seconds to remove what is half done."""
        self._queue.clear()
        workers, self._workers = self._workers, []
        for worker in workers:
            if worker.job is None:
                worker.connection.close()  # it ends by itself
            else:
                worker.process.terminate()
        deadline = time.monotonic() + _GRACE_SECONDS
        for worker in workers:
            worker.process.join(max(0.0, deadline - time.monotonic()))
            self._bury(worker)

    def _busy(self) -> list[_Worker]:
        return [worker for worker in self._workers if worker.job is not None]

    def _give(self) -> bool:
        """Give jobs to idle workers, starting them as needed; return whether there was any job."""
        given = False
        idle = [worker for worker in self._workers if worker.job is None]
        while self._queue and (idle or len(self._workers) < self._settings.workers):
            worker = idle.pop() if idle else self._start()
            worker.job = self._queue.popleft()
            self._set_deadline(worker)
            with suppress(BrokenPipeError):  # it has died while idle; `_wait` finds out
                worker.connection.send(worker.job)
            given = True
        return given

    def _set_deadline(self, worker: _Worker) -> None:
        """Let the time of a job run, from when its worker is ready."""
        if self._settings.timeout is not None and worker.ready:
            worker.deadline = time.monotonic() + self._settings.timeout

    def _start(self) -> _Worker:
        ours, theirs = self._context.Pipe()
        process = self._context.Process(target=work, args=(theirs, self._settings.memory_limit), daemon=True)
        with children_undisturbed():
            process.start()
        theirs.close()
        worker = _Worker(process, ours)
        self._workers.append(worker)
        return worker

    def _wait(self) -> Iterator[Completed]:
        """Wait until something happens to any worker."""
        busy = self._busy()
        first = min(worker.deadline for worker in busy)
        pause = None if first == float("inf") else min(max(0.0, first - time.monotonic()), _LONGEST_PAUSE)
        ready = wait([worker.connection for worker in busy], pause)
        for worker in busy:
            if worker.connection in ready:
                yield from self._receive(worker)
            elif worker.deadline <= time.monotonic():
                yield self._time_out(worker)

    def _receive(self, worker: _Worker) -> Iterator[Completed]:
        try:
            answer = worker.connection.recv()
        except (EOFError, ConnectionResetError):
            worker.process.join(_GRACE_SECONDS)
            code = worker.process.exitcode
            self._remove(worker)
            yield Completed(_finish(worker), None, f"the worker process died ({_words(code)})")
            return
        if answer is None:
            worker.ready = True
            self._set_deadline(worker)
        elif isinstance(answer, Outcome):
            yield Completed(_finish(worker), answer)
        else:
            yield Completed(_finish(worker), None, str(answer))

    def _time_out(self, worker: _Worker) -> Completed:
        job = _finish(worker)
        worker.process.terminate()
        worker.process.join(_GRACE_SECONDS)
        self._remove(worker)
        return Completed(job, None, f"took longer than {self._settings.timeout:g} s (--timeout)")

    def _remove(self, worker: _Worker) -> None:
        self._workers.remove(worker)
        self._bury(worker)

    def _bury(self, worker: _Worker) -> None:
        if worker.process.is_alive():
            worker.process.kill()
        worker.process.join()
        worker.connection.close()


def _refuse_memory_limit(limit: int | None) -> None:
    """Refuse what the system would refuse in each worker."""
    if limit is None:
        return
    most = resource.getrlimit(resource.RLIMIT_DATA)[1]
    if limit > sys.maxsize or (most != resource.RLIM_INFINITY and limit > most):
        raise UsageError(
            f"--memory-limit {limit}: this process may give {min(most % 2**64, sys.maxsize)} bytes at most",
            hint="`ulimit -H -d` tells it in kB",
        )


def _finish(worker: _Worker) -> Job:
    job, worker.job, worker.deadline = worker.job, None, float("inf")
    if job is None:
        raise AssertionError
    return job


def _words(exit_code: int | None) -> str:
    """Say how a process ended."""
    if exit_code is None or exit_code >= 0:
        return f"exit code {exit_code}"
    name = signal.Signals(-exit_code).name
    return f"{name}; out of memory?" if name == "SIGKILL" else name
