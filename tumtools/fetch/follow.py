# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Hash and unpack a file in one pass while it is being downloaded.

The download writes the `.part` file; a thread reads behind it, out of the system's page cache. So a slow disk
or decompressor never slows the line, memory stays flat, and a resumed download needs nothing special: the
pass starts at the beginning of what is there.
"""

from __future__ import annotations

import hashlib
import threading
from typing import TYPE_CHECKING, Final, Generic, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

_T = TypeVar("_T")
_BLOCK: Final = 1 << 20


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
        self._complete = False
        self._abandoned = False
        self._generation = 0

    def grown_to(self, size: int) -> None:
        """Tell that so many bytes are in the file."""
        with self._changed:
            self._size = size
            self._changed.notify_all()

    def restart(self) -> None:
        """Tell that the file has been emptied."""
        with self._changed:
            self._size = 0
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

    def wait_beyond(self, position: int, generation: int) -> int:
        """Return the size once it is more than `position`, or `position` at the end of the file."""
        with self._changed:
            while True:
                if self._abandoned:
                    raise _AbandonedError
                if self._generation != generation:
                    raise _RestartedError
                if self._size > position:
                    return self._size
                if self._complete:
                    return position
                self._changed.wait()


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
        file.wait_beyond(0, self._generation)
        self._stream = file.path.open("rb", buffering=0)
        self._hash = hashlib.sha256()
        self.position = 0

    def read(self, size: int = -1) -> bytes:
        """Return the next bytes, at most `size` (a megabyte if negative); none at the end of the file."""
        buffer = bytearray(_BLOCK if size < 0 else min(size, _BLOCK))
        count = self.readinto(buffer)
        return bytes(memoryview(buffer)[:count])

    def readinto(self, buffer: bytearray | memoryview) -> int:
        """Fill a buffer, or its beginning, with the next bytes; 0 at the end of the file."""
        available = self._file.wait_beyond(self.position, self._generation) - self.position
        view = memoryview(buffer)[:available]
        count = self._stream.readinto(view) if view else 0
        if view and not count:
            raise _RestartedError  # emptied since the line above
        self._hash.update(view[:count])
        self.position += count
        return count

    def close(self) -> None:
        """Release the file."""
        self._stream.close()

    def drain(self) -> str:
        """Read what is left and return the sha256 of the whole file."""
        buffer = bytearray(_BLOCK)
        while self.readinto(buffer):
            pass
        return self._hash.hexdigest()


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
