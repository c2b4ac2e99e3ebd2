# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A worker process of the local engine: takes jobs from a pipe until it is closed."""

from __future__ import annotations

import resource
import signal
import sys
from typing import TYPE_CHECKING, Any, Final, NoReturn

from tumtools.batch.task import execute, is_out_of_threads
from tumtools.errors import TumtoolsError

if TYPE_CHECKING:
    from multiprocessing.connection import Connection
    from sys import UnraisableHookArgs

_SOON_SECONDS: Final = 0.01


def work(connection: Connection[Any, Any], memory_limit: int | None) -> None:
    """Do jobs and send back their outcomes, or a text where there is none."""
    # Ctrl-C goes to the whole process group; the parent decides, and asks to end with SIGTERM.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _end)
    sys.unraisablehook = _end_again
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT, signal.SIGTERM})
    if memory_limit is not None:
        # Data, not address space: mapped files and reserved stacks are no memory.
        resource.setrlimit(resource.RLIMIT_DATA, (memory_limit, memory_limit))
    answer: object = None  # ready: imports are no part of a task's time
    while True:
        try:
            connection.send(answer)
        except BrokenPipeError:
            return  # the parent is gone; the ledger has what came of the job
        try:
            answer = execute(connection.recv())
        except EOFError:
            return
        except MemoryError:
            answer = "out of memory (--memory-limit)"
        except TumtoolsError as error:
            answer = str(error)
        except RuntimeError as error:
            threads = is_out_of_threads(error)
            answer = "no thread could be started (--memory-limit)" if threads else _words(error)
        except Exception as error:  # noqa: BLE001 - the parent reports it as a failure of the task
            answer = _words(error)


def _words(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"


def _end(number: int, frame: object) -> NoReturn:
    del number, frame
    sys.exit(1)


def _end_again(unraisable: UnraisableHookArgs) -> None:
    """End where the end came to something that lets no exception out, such as a generator that is closed."""
    if unraisable.exc_type is not SystemExit:
        sys.__unraisablehook__(unraisable)
        return
    signal.signal(signal.SIGALRM, _end)
    signal.setitimer(signal.ITIMER_REAL, _SOON_SECONDS)
