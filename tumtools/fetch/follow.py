# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Hash and unpack a file in one pass while it is being downloaded.

The download writes the `.part` file; a thread follows. It takes the blocks that were just written from memory
while it keeps up, and reads what it missed from the file (out of the system's page cache). So a slow disk or
decompressor never slows the line, memory stays flat, and a resumed download needs nothing special: the pass
starts at the beginning of what is there.
"""

from __future__ import annotations

import hashlib
import threading
from collections import deque
from typing import IO, TYPE_CHECKING, Final, Generic, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

_T = TypeVar("_T")
_BLOCK: Final = 1 << 20
_MAX_RECENT: Final = 32
"""Blocks of the download that are kept in memory for the follower."""


class _RestartedError(Exception):
    """The file was emptied; the pass starts over."""


class _AbandonedError(Exception):
    """Nobody waits for the pass any more."""


class GrowingFile:
    """How far a file has grown; the writer tells, the reader waits."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._changed = threading.Condition()
        self._size = 0
        self._recent: deque[tuple[int, bytes]] = deque()  # where they begin in the file, and the bytes
        self._complete = False
        self._abandoned = False
        self._generation = 0

    def grown_to(self, size: int, block: bytes = b"") -> None:
        """Tell that so many bytes are in the file, and which were the last ones."""
        with self._changed:
            self._size = size
            if block:
                self._recent.append((size - len(block), block))
                if len(self._recent) > _MAX_RECENT:
                    self._recent.popleft()
            self._changed.notify_all()

    def restart(self) -> None:
        """Tell that the file has been emptied."""
        with self._changed:
            self._size = 0
            self._recent.clear()
            self._complete = False
            self._generation += 1
            self._changed.notify_all()

    def complete(self) -> None:
        """Tell that nothing more will come."""
        with self._changed:
            self._complete = True
            self._changed.notify_all()

    def abandon(self) -> None:
        """End the pass."""
        with self._changed:
            self._abandoned = True
            self._changed.notify_all()

    @property
    def generation(self) -> int:
        """How often the file has been emptied."""
        with self._changed:
            return self._generation

    def wait_beyond(self, position: int, generation: int) -> tuple[int, bytes]:
        """Wait for more than `position` bytes.

        Returns:
            Up to where to read the file from `position`, and instead of reading, the bytes if they are in
            memory; `position` itself at the end of the file.

        """
        with self._changed:
            while True:
                if self._abandoned:
                    raise _AbandonedError
                if self._generation != generation:
                    raise _RestartedError
                if self._size > position:
                    return self._next(position)
                if self._complete:
                    return position, b""
                self._changed.wait()

    def _next(self, position: int) -> tuple[int, bytes]:
        while self._recent and self._recent[0][0] < position:
            self._recent.popleft()
        if not self._recent:
            return self._size, b""
        begin, block = self._recent[0]
        if begin > position:
            return begin, b""
        self._recent.popleft()
        return begin + len(block), block


class FollowingReader:
    """The content of a growing file from its beginning, hashed as it is read.

    Attributes:
        path: The file.
        position: Bytes that have been read.

    """

    def __init__(self, file: GrowingFile) -> None:
        self.path = file.path
        self._file = file
        self._generation = file.generation
        self._stream: IO[bytes] | None = None
        self._hash = hashlib.sha256()
        self._block = memoryview(b"")
        self._taken = 0
        self.position = 0

    def read(self, size: int = -1) -> bytes:
        """Return the next bytes, at most `size`; none at the end of the file."""
        if not self._block:
            self._block = memoryview(self._take())
        part = bytes(self._block if size < 0 else self._block[:size])
        self._block = self._block[len(part) :]
        self.position += len(part)
        return part

    def readinto(self, buffer: bytearray | memoryview) -> int:
        """Fill a buffer, or its beginning, with the next bytes; 0 at the end of the file."""
        if not self._block:
            self._block = memoryview(self._take())
        count = min(len(buffer), len(self._block))
        buffer[:count] = self._block[:count]
        self._block = self._block[count:]
        self.position += count
        return count

    def drain(self) -> str:
        """Read what is left and return the sha256 of the whole file."""
        while block := self._take():
            self.position += len(block)
        return self._hash.hexdigest()

    def close(self) -> None:
        """Release the file."""
        if self._stream is not None:
            self._stream.close()

    def _take(self) -> bytes:
        """Return the next block, hashed; none at the end of the file."""
        end, block = self._file.wait_beyond(self._taken, self._generation)
        if not block and end > self._taken:
            if self._stream is None:
                self._stream = self.path.open("rb", buffering=0)
            self._stream.seek(self._taken)
            block = self._stream.read(min(end - self._taken, _BLOCK))
            if not block:
                raise _RestartedError  # emptied since the lines above
        self._hash.update(block)
        self._taken += len(block)
        return block


class Follower(Generic[_T]):
    """A thread that hashes a growing file and gives its content to a consumer.

    Attributes:
        sha256: Checksum of the whole file, once `join` has returned.
        value: What the consumer gave.
        error: What it raised, if it did; the checksum is there nevertheless.

    """

    def __init__(self, file: GrowingFile, consume: Callable[[FollowingReader], _T] | None) -> None:
        self._file = file
        self._consume = consume
        self._thread = threading.Thread(target=self._run, name=f"follow {file.path.name}", daemon=True)
        self.sha256 = ""
        self.value: _T | None = None
        self.error: Exception | None = None

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def join(self) -> None:
        """Wait until the pass has ended; the file must be complete or abandoned."""
        self._thread.join()

    def _run(self) -> None:
        while True:
            try:
                self._pass()
            except _RestartedError:
                continue
            except _AbandonedError:
                pass
            except Exception as error:  # noqa: BLE001 - a thread has nobody to raise to; `fetch` raises it
                self.error = self.error or error
            return

    def _pass(self) -> None:
        self.value, self.error, self.sha256 = None, None, ""
        reader = FollowingReader(self._file)
        try:
            if self._consume is not None:
                try:
                    self.value = self._consume(reader)
                except (_RestartedError, _AbandonedError):
                    raise
                except Exception as error:  # noqa: BLE001 - kept: a wrong checksum explains it better
                    self.error = error
            self.sha256 = reader.drain()
        finally:
            reader.close()
