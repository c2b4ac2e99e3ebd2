# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Run a plan: give its tasks to an engine, note what the engine lost, count what came of them."""

from __future__ import annotations

import random
import time
from collections import deque
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Final

from tumtools.batch.claims import DEFAULT_LEASE, Claims
from tumtools.batch.engines.engine import EngineLostError, say_nothing
from tumtools.batch.ledger import DONE, FAILED, SKIPPED, Ledger
from tumtools.batch.places import is_remote
from tumtools.batch.plan import by_id
from tumtools.batch.proof import prove
from tumtools.batch.stores import open_store
from tumtools.batch.task import BUSY, KEPT, WORKED, Job, Outcome, failure
from tumtools.errors import TumtoolsError
from tumtools.staging import remove_stale

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterator

    from tumtools.batch.claims import Claim
    from tumtools.batch.engines.engine import Completed, Engine
    from tumtools.batch.ledger import Entry
    from tumtools.batch.plan import Plan, Task

_LONGEST_PAUSE: Final = 2.0
_LAST_SECOND: Final = 2.0**35
"""Since 1970; what is later is no time of a day."""


@dataclass(frozen=True, slots=True)
class RunOptions:
    """How to run a plan.

    Attributes:
        retry: Only tasks that failed.
        claim: Others run the same plan at the same time: begin anywhere, leave to them what they work on.
        shard: `(I, N)`: only the I-th (1 = first) of N parts.
        lease: Seconds after which a claim that is not renewed expires.
        scratch: Folder for what is staged; None for the system's.
        full: Hash the outputs of tasks that are done, instead of looking at sizes and times.
        say: Told, in a line, what a person who waits should know.

    """

    retry: bool = False
    claim: bool = False
    shard: tuple[int, int] | None = None
    lease: float = DEFAULT_LEASE
    scratch: Path | None = None
    full: bool = False
    say: Callable[[str], None] = say_nothing


def chosen(plan: Plan, options: RunOptions) -> list[Task]:
    """Return the tasks that a run with these options looks at."""
    tasks = list((plan.shard(*options.shard) if options.shard else plan).tasks)
    if options.retry:
        ledger = Ledger(open_store(plan.destination, options.scratch))
        entries = ledger.read_all(task.id for task in tasks)
        tasks = [
            task
            for task, entry in zip(tasks, entries, strict=True)
            if entry is not None and entry.state == FAILED
        ]
    if options.claim and tasks:
        start = random.randrange(len(tasks))  # noqa: S311 - only so that processes do not start at one place
        tasks = tasks[start:] + tasks[:start]
    return tasks


def run(plan: Plan, tasks: list[Task], engine: Engine, options: RunOptions) -> Generator[Outcome, None, None]:
    """Run tasks and yield what came of each, as they are done; the engine is shut down in the end.

    Args:
        plan: The plan that they are of.
        tasks: As `chosen`.
        engine: What runs them.
        options: How.

    Raises:
        OutputError: The store cannot be written to.
        TumtoolsError: The ledger cannot be read or written.

    """
    runner = _Runner(plan, engine, options)
    try:
        runner.prepare()
        yield from runner.run(tasks)
    except BaseException:
        with suppress(EngineLostError):  # what has gone wrong before is what is told
            engine.shutdown()
        raise
    else:
        engine.shutdown()
    finally:
        runner.release()


class _Runner:
    def __init__(self, plan: Plan, engine: Engine, options: RunOptions) -> None:
        self._plan = plan
        self._engine = engine
        self._options = options
        self._store = open_store(plan.destination, options.scratch)
        self._ledger = Ledger(self._store)
        self._claims = Claims(self._store, options.lease)
        self._since = time.time()
        self._told: set[str] = set()

    def run(self, tasks: list[Task]) -> Iterator[Outcome]:
        queue = deque(self._job(task) for task in tasks)
        while queue:
            busy: deque[Job] = deque()
            for outcome, job in self._pass(queue):
                if outcome.how == BUSY and not self._options.claim:
                    busy.append(job)
                else:
                    yield outcome
            queue = busy
            if queue:
                # Another run, or a worker of another machine that is lost: its claim expires.
                self._tell_of_claims(queue)
                time.sleep(min(self._options.lease / 4, _LONGEST_PAUSE))

    def prepare(self) -> None:
        """See that the store can be written to, and remove what killed processes claim in vain.

        These are claims on tasks that are done or no longer planned.
        """
        self._store.check()
        planned = by_id(self._plan)
        for claim in self._claims.all():
            if not claim.has_expired():
                continue
            entry = self._ledger.read(claim.task)
            if claim.task not in planned or (entry is not None and entry.state == DONE):
                self._claims.remove_expired(claim.task)

    def release(self) -> None:
        """Remove the claims of processes of this machine that are gone: nobody has to wait for them."""
        with suppress(TumtoolsError):  # they expire by themselves
            for claim in self._claims.all():
                if claim.owner.is_dead():
                    self._claims.remove_expired(claim.task)

    def _tell_of_claims(self, jobs: deque[Job]) -> None:
        """Say once of each claim of others what is waited for, and how long at most."""
        for job in jobs:
            claim = self._claims.read(job.task.id)
            if claim is None or claim.token in self._told or claim.has_expired():
                continue
            self._told.add(claim.token)
            until = time.strftime("%H:%M:%S", time.localtime(min(claim.expires, _LAST_SECOND)))
            self._options.say(
                f"waiting for {job.task.output}: {claim.owner.words} works on it; "
                f"if that is lost, its claim expires at {until}"
            )

    def _job(self, task: Task) -> Job:
        options = self._options
        return Job(
            task,
            self._plan.destination,
            self._plan.policy,
            options.lease,
            options.scratch,
            self._since,
            options.full,
        )

    def _pass(self, queue: deque[Job]) -> Iterator[tuple[Outcome, Job]]:
        """Run each job of a queue once."""
        jobs = iter(queue)
        for job in islice(jobs, self._engine.capacity):
            self._engine.submit(job)
        for completed in self._engine.as_completed():
            yield completed.outcome or self._note_loss(completed), completed.job
            for job in islice(jobs, 1):
                self._engine.submit(job)

    def _note_loss(self, completed: Completed) -> Outcome:
        """Note a task whose worker could not; what was done stays so unless it is disproved."""
        job, task = completed.job, completed.job.task
        claim, entry = self._claims.read(task.id), self._ledger.read(task.id)
        if entry is not None and entry.finished >= job.since:
            return Outcome(task.id, WORKED, entry)  # the worker was lost after it had noted what came of it
        if entry is not None and entry.state in {DONE, SKIPPED} and not _had_begun(claim, entry):
            # Lost while it only checked. Nothing is hashed here: that may be what the worker was lost for.
            proof = prove(self._store, task, entry, hashes=False)
            if proof.holds and not job.full:
                return Outcome(task.id, KEPT, entry)
            if not proof.disproof:
                reason = f"{completed.reason}, while it checked what is done; the ledger is left as it was"
                return Outcome(task.id, WORKED, failure(job, entry.attempts, reason, time.time()))
        attempts = max(claim.attempt if claim else 0, entry.attempts if entry else 0, 1)
        noted = failure(job, attempts, completed.reason, time.time())
        try:
            self._ledger.write(noted)
            self._claims.remove_expired(task.id)
        except TumtoolsError:
            # The store is out of reach: the failure is reported, and the next run begins the task again.
            noted = replace(noted, reason=f"{noted.reason}; that could not be noted in the ledger")
        if not is_remote(job.destination):
            target = Path(job.destination, task.output)
            if target.parent.is_dir():
                remove_stale(target)
        return Outcome(task.id, WORKED, noted)


def _had_begun(claim: Claim | None, entry: Entry) -> bool:
    """Whether a worker that is gone had found that the task must be done again: then it claimed it."""
    return claim is not None and claim.owner.is_dead() and claim.attempt > entry.attempts
