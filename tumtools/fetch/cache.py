# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The folder that holds fetched sequences: the cache, or the folder of `--dest`, which has the same layout.

rgbd_dataset_freiburg1_desk/            the unpacked sequence
rgbd_dataset_freiburg1_desk.tgz         the archive, if it is kept
rgbd_dataset_freiburg1_desk.tgz.part    a download in progress, and its state in .tgz.part.json
.tumtools/NAME.json                     where it came from, and the facts of the catalogue
.tumtools/NAME.sha256                   checksums of the unpacked files, as `sha256sum` writes them
.tumtools/NAME.lock                     held by the process that works on the sequence
.tumtools/NAME.staging/                 an archive while it is unpacked
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Final

from tumtools.catalogue import Catalogue, Entry
from tumtools.catalogue.entry import RECORDINGS, SUFFIXES, as_table, parse_entry
from tumtools.catalogue.table import build
from tumtools.errors import InputError, IntegrityError, OutputError
from tumtools.fetch.atomic import exclusive, write_text

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping
    from contextlib import AbstractContextManager

CACHE_VARIABLE: Final = "TUMTOOLS_CACHE"
_META: Final = ".tumtools"
_SCHEMA_VERSION: Final = 1


@dataclass(frozen=True, slots=True)
class Stored:
    """A file that has been downloaded.

    Attributes:
        bytes: Its size.
        sha256: Its checksum.
        url: Where it came from.
        trust: Why it was trusted.
        last_modified: Date of the server's file, ISO 8601.
        fetched: When, ISO 8601, UTC.

    """

    bytes: int
    sha256: str
    url: str
    trust: str
    last_modified: str | None = None
    fetched: str | None = None


@dataclass(frozen=True, slots=True)
class Record:
    """What is known of a fetched sequence.

    Attributes:
        entry: Its catalogue entry at that time, so that names of a user's catalogue work without it.
        files: What has been downloaded, by kind; the file itself may be gone once it is unpacked.
        unpacked_from: Kind of the archive that the folder comes from.
        digest: Digest of the content of the folder, as strings (`model.digest`); empty where none is known.

    """

    entry: Entry
    files: Mapping[str, Stored] = field(default_factory=dict)
    unpacked_from: str | None = None
    digest: Mapping[str, str] = field(default_factory=dict)


class Cache:
    """A folder of fetched sequences.

    Attributes:
        root: The folder; need not exist.

    """

    def __init__(self, root: Path | None = None) -> None:
        self.root = root if root is not None else default_root()

    def folder(self, name: str) -> Path:
        """Return where the unpacked sequence is or would be."""
        return self.root / name

    def file(self, name: str, kind: str) -> Path:
        """Return where a downloaded file is or would be."""
        return self.root / f"{name}{SUFFIXES[kind]}"

    def staging(self, name: str) -> Path:
        """Return where an archive is unpacked before it is complete."""
        return self.root / _META / f"{name}.staging"

    def lock(
        self, name: str, on_wait: Callable[[], None] | None = None, *, wait: bool = True
    ) -> AbstractContextManager[None]:
        """Hold the lock of a sequence; one process at a time works on it (`atomic.exclusive`)."""
        return exclusive(self.root / _META / f"{name}.lock", on_wait, wait=wait)

    def record(self, name: str) -> Record | None:
        """Return what is known of a fetched sequence, or None."""
        path = self._record_path(name)
        try:
            document = json.loads(path.read_text("utf-8"))
            if not isinstance(document, dict) or document.get("schema_version") != _SCHEMA_VERSION:
                return None
            return Record(
                parse_entry(document["entry"], str(path), "entry"),
                {
                    key: build(Stored, value, str(path), f"files.{key}")
                    for key, value in document["files"].items()
                },
                document.get("unpacked_from"),
                {str(name): str(value) for name, value in document.get("digest", {}).items()},
            )
        except (OSError, ValueError, KeyError, AttributeError, InputError):
            return None  # unreadable means unknown: the sequence is fetched again

    def records(self) -> Iterator[Record]:
        """Yield all records, by name."""
        for path in sorted((self.root / _META).glob("*.json")):
            record = self.record(path.name.removesuffix(".json"))
            if record is not None:
                yield record

    def write_record(self, record: Record) -> None:
        """Note a fetched sequence."""
        document = {
            "schema_version": _SCHEMA_VERSION,
            "entry": as_table(record.entry),
            "files": {key: as_table(value) for key, value in record.files.items()},
            "unpacked_from": record.unpacked_from,
            "digest": dict(record.digest),
        }
        write_text(self._record_path(record.entry.name), json.dumps(document, indent=1) + "\n")

    def write_checksums(self, name: str, files: Mapping[str, tuple[int, str]]) -> None:
        """Note the checksums of the unpacked files."""
        text = "".join(f"{sha256}  {file}\n" for file, (_, sha256) in sorted(files.items()))
        write_text(self._checksums_path(name), text)

    def checksums(self, name: str) -> dict[str, str]:
        """Return the checksums of the unpacked files: relative name -> sha256."""
        try:
            lines = self._checksums_path(name).read_text("utf-8").splitlines()
        except OSError:
            return {}
        return {line[66:]: line[:64] for line in lines}

    def present(self, record: Record) -> Path | None:
        """Return what there is to open: the folder, or else an archive or recording; None if all is gone."""
        folder = self.folder(record.entry.name)
        if record.unpacked_from is not None and folder.is_dir():
            return folder
        candidates = (self.file(record.entry.name, kind) for kind in RECORDINGS if kind in record.files)
        return next((path for path in candidates if path.is_file()), None)

    def catalogue(self) -> Catalogue:
        """Return the sequences that are there, to look names up."""
        return Catalogue(tuple(record.entry for record in self.records() if self.present(record)))

    def usage(self, name: str) -> int:
        """Return the bytes that a sequence takes, what is unfinished included."""
        return sum(size_of(path) for path in self._paths(name))

    def verify(self, record: Record, progress: Callable[[int], None] | None = None) -> None:
        """Compare what is there of a sequence with the checksums and the digest noted when it was fetched.

        Args:
            record: The sequence.
            progress: Called with the bytes read so far.

        Raises:
            IntegrityError: Files are missing or changed; the message names the first and counts them, and
                says which streams are not what they were.

        """
        name = record.entry.name
        expected = {
            self.file(name, kind): stored.sha256
            for kind, stored in record.files.items()
            if self.file(name, kind).is_file()
        }
        folder = self.folder(name)
        if record.unpacked_from is not None:
            if not folder.is_dir():
                raise IntegrityError("the folder is gone", path=folder, hint=_again(record))
            sums = self.checksums(name)
            if not sums:
                raise IntegrityError("its checksums are gone", path=self._checksums_path(name))
            expected |= {folder / file: sha256 for file, sha256 in sums.items()}
        bad, found = self._compare(expected, progress)
        files = {
            path.relative_to(folder).as_posix(): s for path, s in found.items() if folder in path.parents
        }
        changed = _changed_streams(folder, files, record.digest)
        if bad or changed:
            more = f" (and {len(bad) - 1} more)" if len(bad) > 1 else ""
            text = [f"{bad[0]}{more}"] if bad else []
            text += [f"the content of {' and '.join(changed)} is not what was fetched"] if changed else []
            raise IntegrityError("; ".join(text), path=self.root, hint=_again(record))

    def _compare(
        self, expected: Mapping[Path, str], progress: Callable[[int], None] | None
    ) -> tuple[list[str], dict[Path, str]]:
        """Return what is wrong with files, and the checksums of those that can be read."""
        done = 0
        bad: list[str] = []
        sums: dict[Path, str] = {}
        for path, sha256 in expected.items():
            try:
                found = file_sha256(path)
            except FileNotFoundError:
                bad.append(f"{path.relative_to(self.root)} is missing")
                continue
            except OSError as error:
                bad.append(f"{path.relative_to(self.root)} cannot be read: {error.strerror}")
                continue
            sums[path] = found
            if found != sha256:
                bad.append(f"{path.relative_to(self.root)} has changed")
            done += path.stat().st_size
            if progress is not None:
                progress(done)
        return bad, sums

    def leftovers(self) -> dict[str, list[Path]]:
        """Return, by sequence, what interrupted work has left, and archives that are unpacked as well."""
        found: dict[str, list[Path]] = {}
        for path in sorted([*self.root.glob("*.part"), *self.root.glob("*.part.json")]):
            name = path.name.removesuffix(".json").removesuffix(".part")
            for suffix in sorted(SUFFIXES.values(), key=len, reverse=True):
                if name.endswith(suffix):
                    found.setdefault(name.removesuffix(suffix), []).append(path)
                    break
        for path in sorted((self.root / _META).glob("*.staging")):
            found.setdefault(path.name.removesuffix(".staging"), []).append(path)
        for record in self.records():
            name = record.entry.name
            if record.unpacked_from is not None and self.folder(name).is_dir():
                archive = self.file(name, record.unpacked_from)
                if archive.is_file():
                    found.setdefault(name, []).append(archive)
        return found

    def remove(self, name: str) -> int:
        """Remove all of a sequence; return the bytes set free.

        Raises:
            BusyError: It is being fetched.

        """
        freed = 0
        with self.lock(name, wait=False):
            # The record goes first: without it nothing that is half gone counts as fetched.
            self._record_path(name).unlink(missing_ok=True)
            for path in self._paths(name):
                freed += remove_path(path)
        return freed

    def tidy(self, name: str) -> int:
        """Remove the leftovers of a sequence; return the bytes set free.

        Raises:
            BusyError: It is being fetched.

        """
        with self.lock(name, wait=False):
            return sum(remove_path(path) for path in self.leftovers().get(name, ()))

    def _paths(self, name: str) -> list[Path]:
        files = [self.file(name, kind) for kind in SUFFIXES]
        parts = [Path(f"{file}{end}") for file in files for end in (".part", ".part.json")]
        meta = [self.staging(name), self._checksums_path(name), self._record_path(name)]
        return [path for path in (self.folder(name), *files, *parts, *meta) if path.exists()]

    def _record_path(self, name: str) -> Path:
        return self.root / _META / f"{name}.json"

    def _checksums_path(self, name: str) -> Path:
        return self.root / _META / f"{name}.sha256"


def default_root() -> Path:
    """Return the cache folder: `TUMTOOLS_CACHE`, or the user's cache folder."""
    named = os.environ.get(CACHE_VARIABLE)
    if named:
        return Path(named)
    from platformdirs import user_cache_path  # noqa: PLC0415 - not needed when the variable is set

    return user_cache_path("tumtools")


def file_sha256(path: Path) -> str:
    """Return the checksum of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def remove_path(path: Path) -> int:
    """Remove a file or a folder; return the bytes set free.

    Raises:
        OutputError: It cannot be removed.

    """
    size = size_of(path)
    try:
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)
    except OSError as error:
        raise OutputError(f"cannot be removed: {error.strerror}", path=path) from error
    return size


def size_of(path: Path) -> int:
    """Return the bytes that a file or folder takes; 0 if it is not there."""
    if path.is_dir() and not path.is_symlink():
        return sum(file.lstat().st_size for file in path.rglob("*") if not file.is_dir())
    try:
        return path.lstat().st_size
    except FileNotFoundError:
        return 0


def _changed_streams(folder: Path, sha256: Mapping[str, str], digest: Mapping[str, str]) -> list[str]:
    """Return the streams whose content is not that of a digest, new ones too; none if no digest is known."""
    from tumtools.fetch.content_digest import content_digest  # noqa: PLC0415 - not needed for downloads
    from tumtools.model.digest import from_strings  # noqa: PLC0415 - see above

    known = (from_strings(digest) if digest else None) or {}
    found = content_digest(folder, sha256) if known else {}
    return [
        stream for stream in sorted(known.keys() | found.keys()) if found.get(stream) != known.get(stream)
    ]


def _again(record: Record) -> str:
    return f"`tumtools cache prune {record.entry.label}`, then `tumtools fetch {record.entry.label}`"
