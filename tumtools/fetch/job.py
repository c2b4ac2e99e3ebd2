# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Fetch one sequence: it ends verified and in place, or with an error that says what is wrong."""

from __future__ import annotations

import shutil
import threading
import time
from dataclasses import replace
from datetime import UTC, datetime
from email.utils import parsedate_to_datetime
from typing import TYPE_CHECKING, Final

from tumtools.catalogue.entry import ARCHIVES, RECORDINGS, Entry, RemoteFile
from tumtools.errors import FetchError, InputError, IntegrityError, OutputError, UsageError
from tumtools.fetch.cache import Cache, Record, Stored, remove_path
from tumtools.fetch.contents import differences
from tumtools.fetch.download import Listener
from tumtools.fetch.follow import FollowingReader, GrowingFile
from tumtools.fetch.lockfile import LockFile, Pin, find_lock
from tumtools.fetch.options import Event, Fetched, FetchOptions, Stage, silent
from tumtools.fetch.state import Part
from tumtools.fetch.transfer import Arrived, Transfer, follow_complete
from tumtools.fetch.transport import MirrorError, display_url
from tumtools.fetch.unpack import Unpacked, content_root, unpack_tar, unpack_zip
from tumtools.fetch.verify import Known, check_content
from tumtools.fetch.whole import check_whole
from tumtools.staging import fsync, fsync_tree

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from tumtools.fetch.options import Report

UNPACK_FACTOR: Final = 1.1
"""What archives of the benchmark unpack to, where the catalogue does not know better."""
_SPARE: Final = 16 << 20
_FIRST_USE: Final = "first use"

_STANDINGS: Final = {
    "confirmed": "the catalogue (confirmed by several sources)",
    "single": "the catalogue (measured by one source)",
    None: "the catalogue",
}


def fetch(
    entry: Entry,
    options: FetchOptions | None = None,
    report: Report = silent,
    cancelled: threading.Event | None = None,
) -> Fetched:
    """Fetch one sequence, verify it, and unpack it.

    Args:
        entry: The sequence.
        options: How.
        report: Told what happens, from several threads.
        cancelled: Set it to stop.

    Raises:
        FetchError: No mirror has it.
        IntegrityError: What came, or what is there, is not what is known, or not safe.
        OutputError: It cannot be written.
        UsageError: The sequence has no file of the kind asked for.
        CancelledError: `cancelled` was set; what has come is resumed next time.

    """
    return _Job(entry, options or FetchOptions(), report, cancelled or threading.Event()).run()


class _Job:
    """The work on one sequence."""

    def __init__(
        self, entry: Entry, options: FetchOptions, report: Report, cancelled: threading.Event
    ) -> None:
        self._entry = entry
        self._options = options
        self._report = report
        self._cancelled = cancelled
        self._kind = _kind_of(entry, options.kind)
        self._remote: RemoteFile = entry.files[self._kind]
        self._unpack = options.unpack and self._kind in ARCHIVES
        self._cache = Cache(options.dest)
        self._target = self._cache.file(entry.name, self._kind)
        self._staging = self._cache.staging(entry.name)
        self._locks = LockFile(options.lock or find_lock())
        self._started = time.monotonic()

    def run(self) -> Fetched:
        entry = self._entry
        with self._cache.lock(
            entry.name, lambda: self._tell("waiting", "another process is fetching it; waiting")
        ):
            known = self._known()
            there = self._already_there(known)
            if there is not None:
                return there
            try:
                if self._target.is_file():
                    return self._adopt(known)
                if self._options.offline:
                    raise FetchError(
                        f"it is not in {self._cache.root}, and --offline forbids to download it",
                        path=entry.label,
                        hint=f"run `tumtools fetch {entry.label}` where there is a network",
                    )
                return self._download(known)
            finally:
                remove_path(self._staging)

    def _known(self) -> tuple[Known, ...]:
        facts = []
        if self._remote.bytes is not None or self._remote.sha256 is not None:
            facts.append(Known(_STANDINGS[self._remote.standing], self._remote.bytes, self._remote.sha256))
        pin = self._locks.get(self._target.name)
        if pin is not None:
            facts.append(Known(str(self._locks.path), pin.bytes, pin.sha256))
        return tuple(facts)

    def _already_there(self, known: tuple[Known, ...]) -> Fetched | None:
        record = self._cache.record(self._entry.name)
        path = self._cache.folder(self._entry.name) if self._unpack else self._target
        if not path.exists():
            return None
        kind = record.unpacked_from if record and self._unpack else self._kind
        stored = record.files.get(kind) if record and kind else None
        if stored is not None:
            self._check(stored.bytes, stored.sha256, known if kind == self._kind else (), path)
            return self._fetched(path, stored)
        if self._unpack:
            raise OutputError(
                "is in the way: it was not fetched by tumtools",
                path=path,
                hint="use it as it is, or move it away and run the same command again",
            )
        return None

    def _check(self, nbytes: int, sha256: str, known: tuple[Known, ...], path: Path) -> None:
        try:
            check_content(nbytes, sha256, known)
        except MirrorError as error:
            raise IntegrityError(
                f"what is here is not what is known: {error.reason}",
                path=path,
                hint="nothing was changed; move it away and fetch it again, or correct the lock file",
            ) from error

    def _adopt(self, known: tuple[Known, ...]) -> Fetched:
        """Use a file that lies at its place already: fetched with --no-extract, or put there by the user."""
        size = self._target.stat().st_size
        self._check_space(0, size)
        follower = follow_complete(GrowingFile(self._target), self._consume)
        if follower.sha256:
            self._check(size, follower.sha256, known, self._target)
        if isinstance(follower.error, InputError):
            raise IntegrityError(
                follower.error.message,
                path=self._target,
                location=follower.error.location,
                hint="move it away and fetch it again",
            ) from follower.error
        if follower.error is not None:
            raise follower.error
        record = self._cache.record(self._entry.name)
        before = record.files.get(self._kind) if record else None
        url = before.url if before else display_url(self._remote.urls[0])
        arrived = Arrived(url, size, follower.sha256, follower.value)
        return self._finish(arrived, known, before.last_modified if before else None, None)

    def _download(self, known: tuple[Known, ...]) -> Fetched:
        part = Part(self._target)
        transfer = Transfer(
            part,
            self._kind,
            known,
            # An archive that stays packed is checked if nothing else tells that it is whole.
            self._consume if self._unpack or not any(fact.sha256 for fact in known) else None,
            patience=self._options.patience,
            listener=Listener(
                lambda done, total: self._tell("downloading", done=done, total=total),
                lambda message: self._tell("note", message),
                self._check_space,
            ),
            cancelled=self._cancelled,
        )
        arrived = transfer.run(self._entry.label, self._urls())
        modified = _iso_date(part.version.last_modified if part.version else None)
        return self._finish(arrived, known, modified, part)

    def _urls(self) -> list[str]:
        urls = list(self._remote.urls)
        if self._options.mirror is not None:
            base = self._options.mirror.rstrip("/")
            folder, name = urls[0].rstrip("/").split("/")[-2:]
            urls[:0] = [f"{base}/{folder}/{name}", f"{base}/{name}"]
        return list(dict.fromkeys(urls))

    def _consume(self, reader: FollowingReader) -> Unpacked | None:
        label = self._target.name
        if self._unpack and self._kind != "zip":
            return unpack_tar(reader, self._kind, self._staging, label)
        reader.drain()
        if self._unpack:
            return unpack_zip(reader.path, self._staging, label)
        if self._kind in ARCHIVES:
            check_whole(reader.path, self._kind, label)
        return None

    def _check_space(self, to_come: int, size: int) -> None:
        """Refuse early what will not fit: `to_come` bytes to download of a file of `size` bytes."""
        unpacked = (self._remote.tar_bytes or round(size * UNPACK_FACTOR)) if self._unpack else 0
        need = to_come + unpacked + _SPARE
        try:
            self._cache.root.mkdir(parents=True, exist_ok=True)
            free = shutil.disk_usage(self._cache.root).free
        except OSError as error:
            raise OutputError(f"cannot be used: {error.strerror}", path=self._cache.root) from error
        if need > free:
            parts = [f"{_megabytes(to_come)} to download"]
            parts += [f"{_megabytes(unpacked)} unpacked"] if self._unpack else []
            raise OutputError(
                f"{self._entry.label} needs {_megabytes(need)} ({', '.join(parts)} and some to spare), "
                f"{_megabytes(free)} are free",
                path=self._cache.root,
                hint="make room (`tumtools cache prune`), or use --no-extract, or another disk with --dest "
                "or TUMTOOLS_CACHE",
            )

    def _finish(
        self, arrived: Arrived, known: tuple[Known, ...], modified: str | None, part: Part | None
    ) -> Fetched:
        """Put in place what has been verified. `part` is None for a file that lies at its place."""
        entry, name = self._entry, self._entry.name
        if any(fact.sha256 for fact in known):
            trust = (self._remote.standing or "catalogue") if self._remote.sha256 else "lock"
        else:
            trust = _FIRST_USE
        now = datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
        stored = Stored(arrived.bytes, arrived.sha256, arrived.url, trust, modified, now)
        notes: tuple[str, ...] = ()
        files: dict[str, tuple[int, str]] = {}
        root = self._staging
        if self._unpack and arrived.unpacked is not None:
            root, files = content_root(arrived.unpacked)
            notes = self._compare(root, files, trust)
        if trust == _FIRST_USE:
            pin = Pin(name, arrived.url, arrived.bytes, arrived.sha256, modified)
            self._locks.add(self._target.name, pin)
            notes = (*notes, f"nobody publishes its checksum; it is now in {self._locks.path}")
        record = self._cache.record(name) or Record(entry)
        record = replace(record, entry=entry, files={**record.files, self._kind: stored})
        try:
            if self._unpack:
                fsync_tree(root)
                # The record comes before the folder: whatever the moment, a folder of ours is known as ours.
                self._cache.write_checksums(name, files)
                digest = _digest(root, files)
                self._cache.write_record(replace(record, unpacked_from=self._kind, digest=digest))
                root.rename(self._cache.folder(name))
            else:
                self._cache.write_record(record)
            if part is not None and (self._options.keep_archive or not self._unpack):
                part.commit(self._target)
            elif part is not None:
                part.discard()
            fsync(self._cache.root)
        except OSError as error:
            if isinstance(error, OutputError):
                raise
            raise OutputError(
                f"cannot be put in place: {error.strerror}", path=self._cache.folder(name)
            ) from error
        path = self._cache.folder(name) if self._unpack else self._target
        return self._fetched(path, stored, arrived.received, notes)

    def _compare(self, root: Path, files: dict[str, tuple[int, str]], trust: str) -> tuple[str, ...]:
        """Return how the content differs from its lists; a difference from the catalogue is an error."""
        own, facts = differences(self._entry, root, files)
        if facts and trust in (_FIRST_USE, "lock"):
            raise IntegrityError(
                f"the archive is not what the catalogue describes: {facts[0]}",
                path=self._entry.label,
                hint="nothing was put in place; correct the catalogue file if the archive is right",
            )
        return (*own, *facts)

    def _fetched(self, path: Path, stored: Stored, received: int = 0, notes: tuple[str, ...] = ()) -> Fetched:
        return Fetched(
            self._entry.name,
            self._entry.label,
            path,
            stored.url,
            stored.bytes,
            stored.sha256,
            stored.trust,
            received,
            time.monotonic() - self._started,
            notes,
        )

    def _tell(self, stage: Stage, message: str = "", done: int = 0, total: int | None = None) -> None:
        self._report(Event(self._entry.label, stage, done, total, message))


def _digest(root: Path, files: Mapping[str, tuple[int, str]]) -> dict[str, str]:
    """Return the digest of what has been unpacked, as strings; nothing is read but the text files."""
    from tumtools.fetch.content_digest import content_digest  # noqa: PLC0415 - brings numpy
    from tumtools.model.digest import to_strings  # noqa: PLC0415 - see above

    return to_strings(content_digest(root, {name: sha256 for name, (_, sha256) in files.items()}))


def _kind_of(entry: Entry, wanted: str | None) -> str:
    if wanted is None:
        wanted = next((kind for kind in RECORDINGS if kind in entry.files), None)
    if wanted is None or wanted not in entry.files:
        what = f"no {wanted} file" if wanted else "no file that holds it"
        raise UsageError(
            f"the catalogue knows {what} of {entry.label}",
            hint=f"it knows: {', '.join(entry.files)}" if entry.files else None,
        )
    return wanted


def _iso_date(http_date: str | None) -> str | None:
    try:
        return parsedate_to_datetime(http_date or "").astimezone(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    except (TypeError, ValueError):
        return None


def _megabytes(count: int) -> str:
    return f"{count / 1e6:,.0f} MB"
