# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Ctrl-C goes to the whole group of processes; children are ended by us, without a word of their own."""

from __future__ import annotations

import signal
import threading
from contextlib import contextmanager
from multiprocessing import resource_tracker
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterator

_SIGNALS: Final = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def children_undisturbed() -> Iterator[None]:
    """Let processes that the block starts begin with SIGINT and SIGTERM blocked; they come afterwards."""
    # The tracker is started by whoever needs it first, and unblocks signals as it starts.
    resource_tracker.ensure_running()
    came: list[int] = []
    # A mask is a thread's own: signals may come by way of another one, such as those of a numerical library.
    main = threading.current_thread() is threading.main_thread()
    handlers = {number: signal.getsignal(number) for number in (_SIGNALS if main else ())}
    for number, handler in handlers.items():
        if handler is not None:  # else it is none of Python's, and could not be put back
            signal.signal(number, lambda number, _: came.append(number))
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, _SIGNALS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, blocked)
        for number, handler in handlers.items():
            if handler is not None:
                signal.signal(number, handler)
        if came:
            signal.raise_signal(came[0])
