# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Object stores and the web, through obstore. Credentials come from the environment and stay there.

Transfers are retried by obstore, uploads of large files go in parts, and S3 is told the SHA-256 of each part.
"""

from __future__ import annotations

import uuid
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from datetime import timedelta
from fnmatch import fnmatchcase
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeVar

from tumtools.batch.places import STORE_SCHEMES, WEB_SCHEMES, is_pattern, last_name
from tumtools.batch.scratch import scratch_errors, scratch_folder
from tumtools.batch.stores.answers import first_line, store_error
from tumtools.batch.tree import sha256_of, summary, walk
from tumtools.errors import (
    FetchError,
    IntegrityError,
    MissingInputError,
    OutputError,
    TumtoolsError,
    UsageError,
)

try:
    import obstore
    from obstore.exceptions import AlreadyExistsError, BaseError, NotFoundError, PreconditionError
    from obstore.store import from_url
except ImportError as error:
    raise UsageError("URLs of stores need the extra s3", hint="pip install 'tumtools[s3]'") from error

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from obstore import BytesStream, ObjectMeta, UpdateVersion
    from obstore.store import ObjectStore, RetryConfig

    from tumtools.batch.tree import Measure

_Result = TypeVar("_Result")

_RETRIES: Final[RetryConfig] = {
    "max_retries": 10,
    "retry_timeout": timedelta(minutes=3),
    "backoff": {"init_backoff": timedelta(milliseconds=100), "max_backoff": timedelta(seconds=15), "base": 2},
}
_TRIES: Final = 4
"""For a file whose connection breaks on the way."""
_CHUNK: Final = 4 << 20
_CONNECTIONS: Final = 8
_PART: Final = 8 << 20
_MOST_PARTS: Final = 9000  # S3 takes 10 000
_PARTS_AT_ONCE: Final = 4


@lru_cache(maxsize=16)
def _open(url: str) -> ObjectStore:
    scheme = url.partition("://")[0]
    try:
        if scheme == "s3":
            return from_url(url, config={"checksum_algorithm": "SHA256"}, retry_config=_RETRIES)
        options = {"allow_http": True} if scheme == "http" else None
        return from_url(url, client_options=options, retry_config=_RETRIES)  # type: ignore[arg-type]  # a TypedDict
    except (BaseError, ValueError) as error:
        raise store_error(url, error, "cannot be opened") from error


class RemoteStore:
    """A bucket, or what has a prefix in it."""

    def __init__(self, place: str, scratch: Path | None = None) -> None:
        self._place = place
        self._scratch = scratch
        self._store = _open(place)

    def check(self) -> None:
        """See that the bucket can be written to."""
        name = f".tumtools/new-{uuid.uuid4().hex}"
        try:
            self._try(name, lambda: obstore.put(self._store, name, b""))
            self._try(name, lambda: obstore.delete(self._store, name))
        except (FetchError, MissingInputError) as error:
            cause = error.__cause__
            words = first_line(cause) if isinstance(cause, Exception) else error.message
            why = error.message if error.hint is not None else words
            raise OutputError(
                f"the destination cannot be written to: {why}",
                path=self._place,
                hint=error.hint or "does the bucket exist, and are its credentials in the environment?",
            ) from error

    def read(self, name: str) -> bytes | None:
        """Return a record, or None."""
        found = self._get(name)
        return None if found is None else found[0]

    def write(self, name: str, data: bytes) -> None:
        """Write a record."""
        self._try(name, lambda: obstore.put(self._store, name, data))

    def create(self, name: str, data: bytes) -> bool:
        """Write a record if there is none."""
        return self._put_if(name, data, "create")

    def replace(self, name: str, old: bytes, new: bytes | None) -> bool:
        """Write or remove a record if it is still the old one."""
        found = self._get(name)
        if found is None or found[0] != old:
            return False
        if new is not None:
            return self._put_if(name, new, found[1])
        # Stores cannot remove on a condition. A claim is removed long before it expires, or when its task
        # is done: nobody takes it in between.
        self._try(name, lambda: obstore.delete(self._store, name))
        return True

    def names(self, prefix: str) -> Iterator[str]:
        """Yield the names of the records below a prefix."""
        yield from (meta["path"] for meta in self._list(prefix))

    def measure(self, name: str) -> Measure | None:
        """Look at an output."""
        return _measure(self._store, self._place, name)

    def sha256(self, name: str) -> str:
        """Hash an output by downloading it."""
        with scratch_folder(self._scratch) as folder:
            return sha256_of(_download(self._store, self._place, name, folder)[0])

    @contextmanager
    def output(self, name: str) -> Iterator[Path]:
        """Give a path in a scratch folder, and upload what is there when the block ends well."""
        with scratch_folder(self._scratch) as folder:
            path = folder / last_name(name)
            with scratch_errors(path):
                yield path
            self._upload(path, name)

    def _upload(self, path: Path, name: str) -> None:
        files = [(f"{name}/{inner}" if inner else name, file) for inner, file in walk(path)]
        old = {meta["path"] for meta in self._list(f"{name}/")}

        def put(item: tuple[str, Path]) -> None:
            key, file = item
            part = max(_PART, file.stat().st_size // _MOST_PARTS)
            self._try(
                key,
                lambda: obstore.put(self._store, key, file, chunk_size=part, max_concurrency=_PARTS_AT_ONCE),
            )

        with ThreadPoolExecutor(_CONNECTIONS) as pool:
            list(pool.map(put, files))
        for key in sorted(old - {key for key, _ in files}):
            self._try(key, lambda key=key: obstore.delete(self._store, key))  # type: ignore[misc]  # bound now
        found = self.measure(name)
        expected = sum(file.stat().st_size for _, file in files)
        if found is None or (found.files, found.bytes) != (len(files), expected):
            raise IntegrityError(
                f"{len(files)} files of {expected} bytes were uploaded, the store has "
                f"{found.files if found else 0} of {found.bytes if found else 0}",
                path=f"{self._place}/{name}",
                hint="does anybody else write there? Run the task again",
            )

    def _get(self, name: str) -> tuple[bytes, UpdateVersion] | None:
        try:
            result = self._try(name, lambda: obstore.get(self._store, name))
            version: UpdateVersion = {}
            if result.meta["e_tag"] is not None:
                version["e_tag"] = result.meta["e_tag"]
            if result.meta["version"] is not None:
                version["version"] = result.meta["version"]
            return self._try(name, lambda: bytes(result.bytes())), version
        except MissingInputError:
            return None

    def _put_if(self, name: str, data: bytes, mode: UpdateVersion | str) -> bool:
        try:
            obstore.put(self._store, name, data, mode=mode, use_multipart=False)  # type: ignore[arg-type]  # "create"
        except (AlreadyExistsError, PreconditionError):
            return False
        except (BaseError, OSError) as error:
            raise OutputError(first_line(error), path=f"{self._place}/{name}") from error
        return True

    def _list(self, prefix: str) -> list[ObjectMeta]:
        return self._try(prefix, lambda: _list(self._store, prefix))

    def _try(self, name: str, request: Callable[[], _Result]) -> _Result:
        return _request(f"{self._place}/{name}", request)


def match(pattern: str) -> dict[str, int]:
    """Return the URLs of objects, and of folders of objects, that a pattern matches, and their sizes.

    The URLs are sorted; `*` stops at `/`.

    Raises:
        FetchError: The store cannot be read.

    """
    scheme, _, rest = pattern.partition("://")
    bucket, *parts = rest.split("/")
    plain = next((number for number, part in enumerate(parts) if is_pattern(part)), len(parts))
    root = f"{scheme}://{bucket}"
    prefix = "/".join(parts[:plain])
    found: Counter[str] = Counter()
    for meta in _request(pattern, lambda: _list(_open(root), f"{prefix}/" if prefix else "")):
        names = meta["path"].split("/")[: len(parts)]
        if len(names) == len(parts) and all(map(fnmatchcase, names, parts)):
            found["/".join([root, *names])] += meta["size"]
    return dict(sorted(found.items()))


@contextmanager
def download(url: str, scratch: Path | None) -> Iterator[tuple[Path, Measure]]:
    """Give a copy of an object, or of all that is below a prefix, under its own name.

    With it goes what `measure_url` says of what was copied.

    Raises:
        MissingInputError: There is nothing.
        FetchError: The store cannot be read.

    """
    base, _, name = url.rpartition("/")
    with scratch_folder(scratch) as folder:
        yield _download(_open(base), base, name, folder)


def measure_url(url: str) -> Measure | None:
    """Look at an object, or at all that is below a prefix; None if there is nothing.

    Raises:
        FetchError: The store cannot be read.

    """
    base, _, name = url.rpartition("/")
    return _measure(_open(base), base, name)


def _measure(store: ObjectStore, place: str, name: str) -> Measure | None:
    files = _files(store, place, name)
    return _summary(files) if files else None


def _summary(files: list[tuple[str, ObjectMeta]]) -> Measure:
    return summary(
        (inner, meta["size"], meta["e_tag"] or str(meta["last_modified"])) for inner, meta in files
    )


def _files(store: ObjectStore, place: str, name: str) -> list[tuple[str, ObjectMeta]]:
    """Return the object of a name, or those below it with their names from there, sorted."""
    try:
        return [("", _request(f"{place}/{name}", lambda: obstore.head(store, name)))]
    except MissingInputError:
        if place.partition("://")[0] in WEB_SCHEMES:
            return []
    found = _request(f"{place}/{name}", lambda: _list(store, f"{name}/"))
    files = [(meta["path"][len(name) + 1 :], meta) for meta in found if meta["path"].startswith(f"{name}/")]
    return sorted(files, key=lambda item: item[0])


def _download(store: ObjectStore, place: str, name: str, folder: Path) -> tuple[Path, Measure]:
    files = _files(store, place, name)
    if not files:
        raise MissingInputError("there is nothing of that name", path=f"{place}/{name}")
    root = folder / last_name(name)

    def get(item: tuple[str, ObjectMeta]) -> None:
        inner, meta = item
        path = root / inner if inner else root
        if ".." in Path(inner).parts:
            raise IntegrityError(f"an object has the name {inner!r}", path=f"{place}/{name}")
        with scratch_errors(path):
            path.parent.mkdir(parents=True, exist_ok=True)
        _get_file(store, place, f"{name}/{inner}" if inner else name, meta, path)

    with ThreadPoolExecutor(_CONNECTIONS) as pool:
        list(pool.map(get, files))
    return root, _summary(files)


def _get_file(store: ObjectStore, place: str, name: str, meta: ObjectMeta, path: Path) -> None:
    size = meta["size"]
    url = f"{place}/{name}"

    def get() -> int:
        result = obstore.get(store, name)
        # Servers of the web may have an ETag for each way to send a file; those of stores name the content.
        if place.partition("://")[0] in STORE_SCHEMES and result.meta["e_tag"] != meta["e_tag"]:
            raise IntegrityError("changed while it was downloaded", path=url, hint="run the task again")
        return _save(result.stream(min_chunk_size=_CHUNK), path)

    for attempt in range(_TRIES):
        try:
            received = _request(url, get)
        except (MissingInputError, IntegrityError):
            raise
        except FetchError:
            if attempt == _TRIES - 1:
                raise
        else:
            if received == size:
                return
    raise FetchError(f"broke off before {size} bytes were there", path=url)


def _save(chunks: BytesStream, path: Path) -> int:
    """Write what comes to the scratch folder, whose troubles are not the store's; return its size."""
    with scratch_errors(path):
        file = path.open("wb", buffering=0)
    with file:
        for chunk in chunks:
            left = memoryview(chunk)
            while left:
                with scratch_errors(path):
                    left = left[file.write(left) :]
        return file.tell()


def _list(store: ObjectStore, prefix: str) -> list[ObjectMeta]:
    return [meta for chunk in obstore.list(store, prefix or None) for meta in chunk]


def _request(url: str, request: Callable[[], _Result]) -> _Result:
    try:
        return request()
    except TumtoolsError:
        raise
    except (NotFoundError, FileNotFoundError) as error:
        raise MissingInputError("there is nothing of that name", path=url) from error
    except (BaseError, OSError) as error:
        raise store_error(url, error, "the store cannot be used") from error
