# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A server, a place of one's own, and archives to fetch."""

from __future__ import annotations

import hashlib
import io
import random
import tarfile
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import pytest

from tests.fetch.server import Served, Server
from tumtools.catalogue import Entry, RemoteFile
from tumtools.fetch import Event, Fetched, FetchOptions, Patience, fetch

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping
    from pathlib import Path

QUICK = Patience(connect_timeout=5, read_timeout=5, retries=3, first_delay=0.001, longest_delay=0.002)


def sequence_files(size: int = 600_000) -> dict[str, bytes]:
    """A sequence of one image that does not compress, so that the archive is about as large."""
    return {
        "rgbd_dataset_mini/rgb.txt": b"# color images\n# file: 'mini.bag'\n# timestamp filename\n"
        b"1305031102.175304 rgb/1305031102.175304.png\n",
        "rgbd_dataset_mini/rgb/1305031102.175304.png": random.Random(7).randbytes(size),
    }


def make_tar(
    files: Mapping[str, bytes], mode: str = "w:gz", extra: Callable[[tarfile.TarFile], None] | None = None
) -> bytes:
    buffer = io.BytesIO()
    with tarfile.open(fileobj=buffer, mode=mode) as archive:  # type: ignore[call-overload]  # mode is a variable
        for name, data in files.items():
            member = tarfile.TarInfo(name)
            member.size = len(data)
            archive.addfile(member, io.BytesIO(data))
        if extra is not None:
            extra(archive)
    return buffer.getvalue()


ARCHIVE = make_tar(sequence_files())


def sha256(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


@dataclass
class Place:
    """A user's machine: a working folder, a cache, and what is fetched into it."""

    server: Server
    folder: Path
    events: list[Event] = field(default_factory=list)

    @property
    def cache(self) -> Path:
        return self.folder / "cache"

    @property
    def notes(self) -> str:
        return "\n".join(event.message for event in self.events if event.stage in ("note", "waiting"))

    def serve(self, body: bytes = ARCHIVE, path: str = "/f/mini.tgz", **how: Any) -> Served:
        served = Served(body, **how)
        self.server.files[path] = served
        return served

    def entry(self, *paths: str, kind: str = "tgz", **facts: Any) -> Entry:
        urls = tuple(p if "://" in p else self.server.url(p) for p in paths or (f"/f/mini.{kind}",))
        return Entry("rgbd_dataset_mini", "mini/one", files={kind: RemoteFile(urls, **facts)})

    def fetch(self, entry: Entry | None = None, **options: Any) -> Fetched:
        options = {"patience": QUICK, **options}
        return fetch(entry or self.entry(), FetchOptions(**options), self.events.append)

    def nothing_in_place(self) -> bool:
        """Nothing under a final name, nothing staged, nothing in the lock file."""
        there = [path.name for path in self.cache.iterdir()] if self.cache.exists() else []
        meta = [path.suffix for path in (self.cache / ".tumtools").iterdir()]
        return (
            all(name == ".tumtools" or ".part" in name for name in there)
            and set(meta) <= {".lock"}
            and not (self.folder / "tumtools.lock").exists()
        )


@pytest.fixture
def server() -> Iterator[Server]:
    with Server() as running:
        yield running


@pytest.fixture
def place(server: Server, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Place:
    folder = tmp_path / "work"
    folder.mkdir()
    monkeypatch.chdir(folder)
    monkeypatch.setenv("TUMTOOLS_CACHE", str(folder / "cache"))
    monkeypatch.setenv("XDG_CONFIG_HOME", str(folder / "config"))
    for name in (
        "TUMTOOLS_LOCK",
        "TUMTOOLS_CATALOGUE",
        "REQUESTS_CA_BUNDLE",
        "CURL_CA_BUNDLE",
        "SSL_CERT_FILE",
    ):
        monkeypatch.delenv(name, raising=False)
    for name in ("http_proxy", "https_proxy", "all_proxy", "no_proxy"):
        monkeypatch.delenv(name.upper(), raising=False)
        # Whatever a test does, nothing leaves this machine.
        monkeypatch.setenv(name, "127.0.0.1,localhost" if name == "no_proxy" else "http://127.0.0.1:9")
    return Place(server, folder)
