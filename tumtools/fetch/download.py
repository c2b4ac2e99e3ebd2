# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""One resumable download from one URL into a `.part` file."""

from __future__ import annotations

import random
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import requests
import urllib3.exceptions

from tumtools.errors import OutputError
from tumtools.fetch.state import Part, Version
from tumtools.fetch.transport import MirrorError, PassingError, display_url, request
from tumtools.fetch.verify import Known, check_announced, check_beginning

if TYPE_CHECKING:
    import threading
    from collections.abc import Callable

    from tumtools.fetch.follow import GrowingFile
    from tumtools.fetch.options import Patience

BLOCK: Final = 1 << 18
"""Bytes that are read before they are written: at most so many are lost when the process is killed."""
_ENOUGH: Final = 512
"""Bytes that tell the kind of a file."""
_PAGE: Final = 1 << 16
"""Bytes of a page in which a title is looked for."""

_CONTENT_RANGE = re.compile(r"bytes (?:(\d+)-(\d+)|\*)/(\d+|\*)")


class CancelledError(Exception):
    """The download was given up on request; what is there stays."""


@dataclass(frozen=True, slots=True)
class Listener:
    """Who is told of the progress of a download.

    Attributes:
        progress: Called with bytes that are there and those of the whole file (None if not known).
        note: Called with what goes wrong and passes.
        announce: Called with the bytes to come and those of the whole file before they come; may refuse.

    """

    progress: Callable[[int, int | None], None]
    note: Callable[[str], None]
    announce: Callable[[int, int], None]


class Download:
    """A download of one file, which may be tried from several URLs one after the other.

    Attributes:
        received: Bytes that came over the line.

    """

    def __init__(
        self,
        session: requests.Session,
        part: Part,
        growing: GrowingFile,
        *,
        kind: str,
        known: tuple[Known, ...],
        patience: Patience,
        listener: Listener,
        cancelled: threading.Event,
    ) -> None:
        self._session = session
        self._part = part
        self._growing = growing
        self._kind = kind
        self._known = known
        self._patience = patience
        self._listener = listener
        self._cancelled = cancelled
        self.received = 0
        growing.grown_to(part.size)

    def fetch_from(self, url: str) -> None:
        """Download the file, or what is missing of it, and try again on failures that can pass.

        Raises:
            MirrorError: It cannot be had from this URL.
            OutputError: It cannot be written.
            CancelledError: On request.

        """
        best, failures = self._part.size, 0
        while True:
            try:
                self._attempt(url)
            except PassingError as error:
                # Only bytes that were never there before count as progress: a server that cannot resume
                # brings the same beginning again and again.
                if self._part.size > best:
                    best, failures = self._part.size, 0
                failures += 1
                if failures > self._patience.retries:
                    raise MirrorError(
                        f"{error.reason}; gave up after {failures} attempts", error.hint
                    ) from error
                self._wait(error, failures)
            else:
                return

    def start_over(self) -> None:
        """Forget what is there."""
        self._part.discard()
        self._growing.restart()

    def _wait(self, error: PassingError, failures: int) -> None:
        patience = self._patience
        delay = min(patience.longest_delay, patience.first_delay * 2 ** (failures - 1))
        delay *= random.uniform(0.5, 1.0)  # noqa: S311 - spreads clients, keeps no secret
        if error.retry_after is not None:
            delay = max(delay, error.retry_after)
        self._listener.note(f"{error.reason}; trying again in {delay:.1f} s")
        if self._cancelled.wait(delay):
            raise CancelledError

    def _attempt(self, url: str) -> None:
        offset = self._resume_offset(url)
        version = self._part.version
        if offset and version is not None and version.length == offset:
            self._growing.complete()
            return
        headers = {}
        if offset and version is not None:
            headers["Range"] = f"bytes={offset}-"
            if version.validator is not None and version.url == display_url(url):
                headers["If-Range"] = version.validator
        reply = request(self._session, url, headers, self._patience)
        with reply.response as response:
            if response.status_code == requests.codes.requested_range_not_satisfiable:
                self._unsatisfiable(response, offset)
            elif response.status_code == requests.codes.partial_content:
                self._continue(url, response, offset)
            else:
                self._begin(url, response)

    def _resume_offset(self, url: str) -> int:
        """Return where to go on; without a way to tell that the file is still the same, at the beginning."""
        version = self._part.version
        offset = self._part.size
        if offset == 0 or version is None:
            return 0
        checked_later = any(fact.sha256 is not None for fact in self._known)
        same_place = version.validator is not None and version.url == display_url(url)
        if same_place or checked_later:
            return offset
        self.start_over()
        return 0

    def _unsatisfiable(self, response: requests.Response, offset: int) -> None:
        match = _CONTENT_RANGE.fullmatch(response.headers.get("Content-Range", "").strip())
        total = int(match[3]) if match and match[3] != "*" else None
        length = self._part.version.length if self._part.version else None
        if offset and total == offset and length in (None, total):
            self._growing.complete()
            return
        self.start_over()
        raise PassingError(
            f"the server has no bytes after {offset} (HTTP 416): its file has "
            f"{'an unknown number of' if total is None else total} bytes"
            + ("" if length is None else f", {length} were announced")
        )

    def _continue(self, url: str, response: requests.Response, offset: int) -> None:
        match = _CONTENT_RANGE.fullmatch(response.headers.get("Content-Range", "").strip())
        if match is None or match[1] is None or int(match[1]) != offset or not offset:
            self.start_over()
            sent = response.headers.get("Content-Range")
            raise PassingError(f"asked for the bytes from {offset}, the server sent {sent!r}")
        before = self._part.version
        total = int(match[3]) if match[3] != "*" else before.length if before else None
        now = Version.of_response(display_url(url), response.headers, total)
        if before is not None and before.differs_from(now):
            self.start_over()
            raise PassingError("the file has changed on the server; starting over")
        if total is not None:
            self._listener.announce(total - offset, total)
        self._listener.note(f"going on at byte {offset}")
        self._receive(response, offset, total)

    def _begin(self, url: str, response: requests.Response) -> None:
        encoded = response.headers.get("Transfer-Encoding") is not None
        announced = response.headers.get("Content-Length", "")
        length = int(announced) if announced.isdigit() and not encoded else None
        check_announced(self._kind, length, response.headers, self._known)
        first = self._beginning(response)
        if length is not None:
            self._listener.announce(length - self._part.size, length)
        if self._part.size:
            self._listener.note("the server sent the whole file instead of the rest; starting over")
        self._growing.restart()
        try:
            self._part.begin(Version.of_response(display_url(url), response.headers, length))
        except OSError as error:
            raise OutputError(f"cannot be written: {error.strerror}", path=self._part.path) from error
        self._receive(response, 0, length, first)

    def _beginning(self, response: requests.Response) -> bytes:
        """Return the first bytes of the body, which are of the right kind."""
        content_type = response.headers.get("Content-Type", "")
        first = self._read_at_least(response, b"", _ENOUGH)
        try:
            check_beginning(self._kind, first, content_type)
        except MirrorError:
            # Read on: the title of an HTML page tells what went wrong.
            check_beginning(self._kind, self._read_at_least(response, first, _PAGE), content_type)
            raise
        return first

    def _read_at_least(self, response: requests.Response, data: bytes, size: int) -> bytes:
        while len(data) < size and (block := self._read(response)):
            data += block
        return data

    def _receive(
        self, response: requests.Response, offset: int, total: int | None, first: bytes = b""
    ) -> None:
        """Write the body behind what is there; `first` is what has been read of it already."""
        try:
            with self._part.path.open("ab", buffering=0) as file:
                block = first or self._read(response)
                while block:
                    view = memoryview(block)
                    while view:
                        view = view[file.write(view) :]
                    offset += len(block)
                    self._growing.grown_to(offset, block)
                    self._listener.progress(offset, total)
                    block = self._read(response)
        except OSError as error:
            raise OutputError(
                f"cannot be written: {error.strerror}",
                path=self._part.path,
                hint="what is there is kept; make room and run the same command again",
            ) from error
        if total is not None and offset < total:
            raise PassingError(f"the connection ended after {offset} of {total} bytes")
        self._growing.complete()

    def _read(self, response: requests.Response) -> bytes:
        """Return what has come of the body, undecoded, up to a block; none at its end."""
        if self._cancelled.is_set():
            raise CancelledError
        try:
            block: bytes = response.raw.read1(BLOCK, decode_content=False)
        except urllib3.exceptions.ReadTimeoutError as error:
            raise PassingError(
                f"no byte came for {self._patience.read_timeout:g} s, after {self._part.size} bytes"
            ) from error
        except (urllib3.exceptions.HTTPError, OSError) as error:
            raise PassingError(f"the connection broke after {self._part.size} bytes") from error
        self.received += len(block)
        return block
