# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What can be asked of `fetch`, what it tells while it works, and what it gives."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

Stage = Literal["waiting", "downloading", "note", "done", "failed"]


@dataclass(frozen=True, slots=True)
class Patience:
    """How long to wait and how often to try.

    Attributes:
        connect_timeout: Seconds until a connection must stand.
        read_timeout: Seconds without a byte after which a connection counts as broken.
        retries: Attempts in a row that bring no new byte before a mirror is given up.
        first_delay: Seconds before the first retry; doubles with each (with jitter).
        longest_delay: Most seconds between two attempts.
        longest_retry_after: Most seconds that a server may ask to wait (`Retry-After`).

    """

    connect_timeout: float = 10.0
    read_timeout: float = 30.0
    retries: int = 5
    first_delay: float = 0.5
    longest_delay: float = 30.0
    longest_retry_after: float = 120.0


@dataclass(frozen=True, slots=True)
class FetchOptions:
    """How to fetch.

    Attributes:
        kind: Which file, a key of `catalogue.entry.SUFFIXES`; None takes the first recording there is.
        dest: Folder to put the sequence in; None for the cache.
        unpack: Whether an archive is unpacked.
        keep_archive: Whether the archive stays after it has been unpacked.
        mirror: URL of a folder to look in before the known places.
        offline: Use only what is there.
        lock: The lock file; None finds it (`lockfile.find_lock`).
        jobs: Sequences side by side.
        patience: Time-outs and retries.

    """

    kind: str | None = None
    dest: Path | None = None
    unpack: bool = True
    keep_archive: bool = False
    mirror: str | None = None
    offline: bool = False
    lock: Path | None = None
    jobs: int = 1
    patience: Patience = field(default_factory=Patience)


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happens while a sequence is fetched.

    Attributes:
        name: Label of the sequence.
        stage: What it is about.
        done: Bytes that are there.
        total: Bytes of the whole file, where known.
        message: For notes, waits and failures: what to tell the user.

    """

    name: str
    stage: Stage
    done: int = 0
    total: int | None = None
    message: str = ""


def silent(event: Event) -> None:
    """Tell nobody."""


if TYPE_CHECKING:
    Report = Callable[[Event], None]
    """Called with events, from any thread."""


@dataclass(frozen=True, slots=True)
class Fetched:
    """What came of one name.

    Attributes:
        name: Official name of the sequence.
        label: Its short name.
        path: The folder, archive or recording.
        url: Where the file came from (without credentials).
        bytes: Size of the downloaded file.
        sha256: Its checksum.
        trust: Why it is trusted: `confirmed`, `single` (the catalogue's standing), `lock`, or `first use`.
        downloaded: Bytes that came over the line in this run.
        seconds: How long it took.
        notes: What the user should know.

    """

    name: str
    label: str
    path: Path
    url: str
    bytes: int
    sha256: str
    trust: str
    downloaded: int = 0
    seconds: float = 0.0
    notes: tuple[str, ...] = ()
