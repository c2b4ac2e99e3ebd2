# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Claims: who works on a task. A claim that is not renewed expires, and somebody else takes the task.

A claim is a record made by exclusive creation; it is renewed, taken over and removed only if it is still
the one that was read. A claim of a process of the same machine that is gone expires at once.
"""

from __future__ import annotations

import json
import math
import threading
import time
import uuid
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Final

from tumtools.batch.owner import Owner, this_process
from tumtools.batch.plan import LEDGER_FOLDER
from tumtools.batch.records import build, load
from tumtools.errors import TumtoolsError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tumtools.batch.stores.store import Store

DEFAULT_LEASE: Final = 120.0
"""Seconds after which a claim that is not renewed expires."""
_RENEWALS: Final = 4
_FOLDER: Final = f"{LEDGER_FOLDER}/claims/"


@dataclass(frozen=True, slots=True)
class Claim:
    """Says that a task is being worked on.

    Attributes:
        task: Its id.
        token: Random; whose claim it is.
        attempt: The how manieth attempt at the task it is.
        expires: Seconds since 1970.
        owner: The process.

    """

    task: str
    token: str
    attempt: int
    expires: float
    owner: Owner

    def has_expired(self) -> bool:
        """Whether anybody may take the task."""
        return time.time() > self.expires or self.owner.is_dead()

    def encoded(self) -> bytes:
        """Return the record."""
        return json.dumps(asdict(self)).encode()


class Held:
    """A claim of ours, renewed by a thread while the work goes on."""

    def __init__(self, store: Store, claim: Claim, lease: float) -> None:
        self._store = store
        self._lease = lease
        self._claim = claim
        self._lock = threading.Lock()
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._renew_now_and_then, daemon=True)
        self._thread.start()

    @property
    def attempt(self) -> int:
        """The how manieth attempt at the task this is."""
        return self._claim.attempt

    def renew(self) -> bool:
        """Make it last; return whether it is still ours."""
        with self._lock:
            new = replace(self._claim, expires=time.time() + self._lease)
            done = self._store.replace(_name(new.task), self._claim.encoded(), new.encoded())
            # A store may do a request and lose its answer; then what is there is what we wrote.
            if not done and self._store.read(_name(new.task)) != new.encoded():
                return False
            self._claim = new
            return True

    def release(self) -> None:
        """Give the task free, unless it is somebody else's by now."""
        self._end.set()
        self._thread.join()
        with suppress(TumtoolsError):  # what came of the task is noted; the claim expires by itself
            self._store.replace(_name(self._claim.task), self._claim.encoded(), None)

    def _renew_now_and_then(self) -> None:
        while not self._end.wait(self._lease / _RENEWALS):
            try:
                if not self.renew():
                    return
            except TumtoolsError:
                continue  # the store may be back before the lease ends; before the ledger it is renewed again


class Claims:
    """The claims in a store."""

    def __init__(self, store: Store, lease: float = DEFAULT_LEASE) -> None:
        self._store = store
        self._lease = lease

    @contextmanager
    def hold(self, task: str, attempts: int) -> Iterator[Held | None]:
        """Claim a task for the time of the block; None if somebody else works on it.

        Args:
            task: Its id.
            attempts: How often it has been begun, as the ledger knows.

        """
        claim = self._acquire(task, attempts)
        if claim is None:
            yield None
            return
        held = Held(self._store, claim, self._lease)
        try:
            yield held
        finally:
            held.release()

    def read(self, task: str) -> Claim | None:
        """Return the claim of a task, or None."""
        data = self._store.read(_name(task))
        return None if data is None else _parse(task, data)

    def all(self) -> Iterator[Claim]:
        """Yield all claims."""
        for name in list(self._store.names(_FOLDER)):
            claim = self.read(name.rpartition("/")[2].removesuffix(".json"))
            if claim is not None:
                yield claim

    def remove_expired(self, task: str) -> None:
        """Remove the claim of a task if it has expired."""
        data = self._store.read(_name(task))
        if data is not None and _parse(task, data).has_expired():
            self._store.replace(_name(task), data, None)

    def _acquire(self, task: str, attempts: int) -> Claim | None:
        name = _name(task)
        claim = Claim(task, uuid.uuid4().hex, attempts + 1, time.time() + self._lease, this_process())
        if self._store.create(name, claim.encoded()):
            return claim
        data = self._store.read(name)
        if data is None:
            return None  # released a moment ago; whoever had it has noted what came of it
        if data == claim.encoded():
            return claim  # the store did it and lost its answer
        other = _parse(task, data)
        if not other.has_expired():
            return None
        claim = replace(claim, attempt=max(attempts, other.attempt) + 1)
        taken = self._store.replace(name, data, claim.encoded())
        return claim if taken or self._store.read(name) == claim.encoded() else None


def _name(task: str) -> str:
    return f"{_FOLDER}{task}.json"


def _parse(task: str, data: bytes) -> Claim:
    try:
        claim: Claim | None = build(Claim, load(data))
    except ValueError:
        claim = None
    if claim is None or not math.isfinite(claim.expires):
        return Claim(task, "", 0, 0.0, Owner("", 0, 0))  # damaged: expired long ago
    return replace(claim, task=task)
