# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Get a file from the first mirror that gives the right one, hashed and unpacked on the way."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from tumtools.errors import FetchError, InputError, IntegrityError
from tumtools.fetch.download import Download, Listener
from tumtools.fetch.follow import Follower, FollowingReader, GrowingFile
from tumtools.fetch.transport import MirrorError, display_url, new_session
from tumtools.fetch.verify import Known, check_content

if TYPE_CHECKING:
    import threading
    from collections.abc import Callable, Sequence

    from tumtools.fetch.options import Patience
    from tumtools.fetch.state import Part
    from tumtools.fetch.unpack import Unpacked

    Consume = Callable[[FollowingReader], Unpacked | None]


@dataclass(frozen=True, slots=True)
class Arrived:
    """A file that is complete and right.

    Attributes:
        url: Where it came from.
        bytes: Its size.
        sha256: Its checksum.
        unpacked: What has been unpacked of it, if that was wanted.
        received: Bytes that came over the line.

    """

    url: str
    bytes: int
    sha256: str
    unpacked: Unpacked | None
    received: int = 0


class Transfer:
    """The way of one file from its mirrors into its `.part` file."""

    def __init__(
        self,
        part: Part,
        kind: str,
        known: tuple[Known, ...],
        consume: Consume | None,
        *,
        patience: Patience,
        listener: Listener,
        cancelled: threading.Event,
    ) -> None:
        self._part = part
        self._known = known
        self._consume = consume
        self._listener = listener
        self._growing = GrowingFile(part.path)
        self._follower: Follower[Unpacked | None] | None = None
        self._session = new_session()
        self._download = Download(
            self._session,
            part,
            self._growing,
            kind=kind,
            known=known,
            patience=patience,
            listener=listener,
            cancelled=cancelled,
        )

    def run(self, label: str, urls: Sequence[str]) -> Arrived:
        """Try the URLs in order.

        Args:
            label: Name of the sequence, for messages.
            urls: The mirrors.

        Raises:
            IntegrityError: No mirror has the right file, and one has a wrong one.
            FetchError: No mirror has the file.
            OutputError: It cannot be written.
            CancelledError: On request.

        """
        failures: list[tuple[str, MirrorError]] = []
        try:
            for url in urls:
                try:
                    return self._from_mirror(url)
                except MirrorError as error:
                    failures.append((display_url(url), error))
                    if url != urls[-1]:
                        self._listener.note(f"{display_url(url)}: {error.reason}; trying the next address")
        finally:
            self._growing.abandon()
            if self._follower is not None:
                self._follower.join()
            self._session.close()
        raise _failed(label, failures)

    def _from_mirror(self, url: str) -> Arrived:
        resumed = self._part.size > 0
        try:
            return self._get(url)
        except MirrorError as error:
            if not (resumed and error.integrity and self._part.size == 0):
                raise
            # The beginning may be of another version than the rest.
            self._listener.note(f"the resumed file is not right ({error.reason}); downloading it again")
            return self._get(url)

    def _get(self, url: str) -> Arrived:
        if self._follower is None:
            self._follower = Follower(self._growing, self._consume)
            self._follower.start()
        self._download.fetch_from(url)
        self._follower.join()
        follower, self._follower = self._follower, None
        try:
            if follower.sha256:  # the checksum explains more than what the damage does to the archive
                check_content(self._part.size, follower.sha256, self._known)
            if isinstance(follower.error, InputError):
                raise as_mirror_error(follower.error)
            if follower.error is not None:
                raise follower.error
        except MirrorError:
            self._download.start_over()
            raise
        return Arrived(
            display_url(url), self._part.size, follower.sha256, follower.value, self._download.received
        )


def follow_complete(part_or_file: GrowingFile, consume: Consume | None) -> Follower[Unpacked | None]:
    """Hash and unpack a file that is complete already."""
    part_or_file.grown_to(part_or_file.path.stat().st_size)
    part_or_file.complete()
    follower: Follower[Unpacked | None] = Follower(part_or_file, consume)
    follower.start()
    follower.join()
    return follower


def as_mirror_error(error: InputError) -> MirrorError:
    """Say what is wrong with an archive as a reason not to take it from a mirror."""
    where = f" ({error.location})" if error.location else ""
    return MirrorError(f"{error.message}{where}", error.hint, integrity=True)


def _failed(label: str, failures: list[tuple[str, MirrorError]]) -> FetchError:
    kind = IntegrityError if any(error.integrity for _, error in failures) else FetchError
    lines = [f"{url}: {error.reason}" for url, error in failures]
    text = lines[0] if len(lines) == 1 else "\n    ".join([f"none of {len(lines)} addresses works", *lines])
    hints = dict.fromkeys(error.hint for _, error in failures if error.hint)
    return kind(text, path=label, hint="; ".join(hints) or None)
