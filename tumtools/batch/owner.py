# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Who holds a claim, and whether that process still lives."""

from __future__ import annotations

import os
import socket
from dataclasses import dataclass
from functools import cache
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Owner:
    """A process.

    Attributes:
        host: Name of the machine, its boot and its process name space: where `pid` means something.
        pid: Process.
        started: When it started, in ticks of the system; 0 where that is not known.

    """

    host: str
    pid: int
    started: int

    @property
    def words(self) -> str:
        """The process in a few words."""
        return f"process {self.pid} on {self.host.partition(' ')[0] or 'an unknown machine'}"

    def is_dead(self) -> bool:
        """Whether the process is known to be gone; never for one of another machine."""
        if self.host != _host():
            return False
        if self.pid <= 0:
            return True  # stands for a group of processes; nobody's number
        try:
            os.kill(self.pid, 0)
        except ProcessLookupError:
            return True
        except PermissionError:
            return False
        except OverflowError:
            return True  # no system has such a number
        return _started(self.pid) != self.started


def this_process() -> Owner:
    """Return the process that asks."""
    return Owner(_host(), os.getpid(), _started(os.getpid()))


@cache
def _host() -> str:
    # Containers may share a host name, and a machine its name with its former self: then a number of a
    # process would mean another one.
    boot = _text(Path("/proc/sys/kernel/random/boot_id"))
    try:
        space = str(Path("/proc/self/ns/pid").readlink())
    except OSError:
        space = ""
    return f"{socket.gethostname()} {boot} {space}".strip()


def _started(pid: int) -> int:
    fields = _text(Path(f"/proc/{pid}/stat")).rpartition(")")[2].split()
    if not fields or fields[0] in "ZX":
        return -1 if fields else 0  # a zombie works no more
    return int(fields[19])


def _text(path: Path) -> str:
    try:
        return path.read_text("utf-8", "replace").strip()
    except OSError:
        return ""
