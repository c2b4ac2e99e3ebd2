# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Sources, outputs and the ledger in a bucket whose server fails one request in ten."""

from __future__ import annotations

import errno
import functools
import http.server
import importlib.util
import json
import os
import pathlib
import shutil
import tarfile
import threading
from typing import IO, TYPE_CHECKING, Self

import pytest

from tests.batch import batches
from tests.batch.batches import FIXTURES, FOUR_TARGETS, Batch, hashes
from tests.batch.s3_server import BUCKET, Flaky, s3_server
from tests.interop.programs import missing
from tumtools.errors import OutputError, TumtoolsError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

pytestmark = pytest.mark.interop


@pytest.fixture
def server(monkeypatch: pytest.MonkeyPatch) -> Iterator[Flaky]:
    with s3_server(0.1) as (application, environment):
        monkeypatch.setattr(batches, "ENVIRONMENT", batches.ENVIRONMENT | environment)
        yield application


def manifest(folder: Path, source: str, destination: str) -> Batch:
    batch = Batch(folder, targets=FOUR_TARGETS)
    (folder / "manifest.toml").write_text(
        f'destination = "{destination}"\n[[source]]\npath = "{source}"\n{FOUR_TARGETS}'
    )
    return batch


def upload(folder: Path, prefix: str) -> None:
    from tumtools.batch.stores.remote import RemoteStore

    with RemoteStore(f"s3://{BUCKET}").output(prefix) as place:
        shutil.copytree(folder, place)


def test_a_bucket_gets_the_same_bytes_as_a_folder(tmp_path: Path, server: Flaky) -> None:
    from tumtools.batch.stores.remote import download

    for name in ("remote", "local"):
        (tmp_path / name).mkdir()
    local = Batch(tmp_path / "local", sources=3, targets=FOUR_TARGETS)
    upload(tmp_path / "local" / "data", "in/data")
    remote = manifest(tmp_path / "remote", f"s3://{BUCKET}/in/data/*", f"s3://{BUCKET}/out")
    assert len(remote.plan()) == 12
    scratch = tmp_path / "scratch"
    words = ("batch", "run", "plan.json", "--json", "--claim", "--workers", "1", "--scratch", str(scratch))
    processes = [remote.start(*words) for _ in range(3)]
    printed = [process.communicate(timeout=200) for process in processes]
    assert [process.returncode for process in processes] == [0, 0, 0], printed
    assert sum(json.loads(stdout)["counts"]["done"] for stdout, _ in printed) == 12
    assert list(scratch.iterdir()) == []
    server.log.clear()
    assert remote.run()["done before"] == 12
    assert remote.status() == {"done": 12}
    assert [request for request in server.log if request.startswith("GET /lab/in/data/")] == []
    assert remote.status("--full") == {"done": 12}
    assert server.failed > 20

    local.plan()
    local.run()
    with download(f"s3://{BUCKET}/out", tmp_path) as (copy, _):
        assert hashes(copy) == local.tree()
        left = [path for path in copy.rglob("*") if "claims" in path.parts and path.is_file()]
        assert left == []
        records = "".join(path.read_text() for path in copy.glob(".tumtools/ledger/*/*.json"))
    assert records.count('"state": "done"') == 12
    for secret in ("the-secret-key", "the-key-id"):
        assert secret not in records + remote.plan_file.read_text()


def test_what_was_changed_in_the_bucket_is_done_again(tmp_path: Path, server: Flaky) -> None:
    import obstore
    from obstore.store import from_url

    batch = Batch(tmp_path, destination=f"s3://{BUCKET}/again")
    batch.plan()
    assert batch.run()["done"] == 1
    obstore.put(from_url(f"s3://{BUCKET}"), "again/full_0/full_0.mcap", b"something else")
    assert batch.status() == {"changed": 1}
    assert batch.run()["done"] == 1
    assert batch.status("--full") == {"done": 1}


def test_claims_in_a_bucket_are_exclusive(server: Flaky) -> None:
    from tumtools.batch.claims import Claims
    from tumtools.batch.stores.remote import RemoteStore

    claims = Claims(RemoteStore(f"s3://{BUCKET}/claims"))
    for _ in range(5):
        with claims.hold("0123", 0) as first:
            assert first is not None
            assert first.renew()
            with claims.hold("0123", 0) as second:
                assert second is None
    assert list(claims.all()) == []


def test_a_source_on_the_web_is_downloaded_for_each_task_once(tmp_path: Path) -> None:
    if importlib.util.find_spec("obstore") is None:
        missing("obstore")
    (tmp_path / "web").mkdir()
    with tarfile.open(tmp_path / "web" / "full.tgz", "w:gz") as archive:
        archive.add(FIXTURES / "full", "full")
    got: list[str] = []
    refused: list[str] = []

    class Handler(http.server.SimpleHTTPRequestHandler):
        def do_GET(self) -> None:
            got.append(self.path)
            super().do_GET()

        def do_HEAD(self) -> None:
            if self.path in refused:
                self.send_error(http.HTTPStatus.FORBIDDEN)
            else:
                super().do_HEAD()

        def log_message(self, *_: object) -> None:
            pass

    handler = functools.partial(Handler, directory=tmp_path / "web")
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            batch = manifest(tmp_path, f"http://127.0.0.1:{server.server_port}/full.tgz", "out")
            batch.plan()
            assert batch.run()["done"] == 4
            assert got == ["/full.tgz"] * 4
            assert batch.run()["done before"] == 4
            assert batch.status() == {"done": 4}
            assert got == ["/full.tgz"] * 4
            assert batch.strays() == []
            os.utime(tmp_path / "web" / "full.tgz", (1, 1))
            scratch = tmp_path / "scratch"
            assert batch.status("--scratch", str(scratch)) == {"done": 4}
            assert got == ["/full.tgz"] * 8  # to see that the bytes are the same
            assert list(scratch.iterdir()) == []
            with (tmp_path / "web" / "full.tgz").open("ab") as file:
                file.write(b"more")
            assert batch.status() == {"changed": 4}
            (tmp_path / "web" / "full.tgz").unlink()
            assert batch.status() == {"done": 4}
            refused.append("/full.tgz")
            assert batch.status() == {"unknown": 4}
            batch.status("--check", code=1)
            assert "unknown: full/full.mcap: the source cannot be" in batch.call(
                "batch", "status", "plan.json"
            )
            assert batch.run()["done before"] == 4
        finally:
            server.shutdown()
            thread.join()


def test_a_full_or_missing_scratch_folder_is_named(
    tmp_path: Path, server: Flaky, monkeypatch: pytest.MonkeyPatch
) -> None:
    from tumtools.batch.stores.remote import RemoteStore, download

    (tmp_path / "file").write_text("")
    batch = Batch(tmp_path)
    batch.plan()
    told = batch.call("batch", "run", "plan.json", "--scratch", "file/x", code=4)
    assert told.startswith(f"error: {tmp_path}/file/x: no scratch folder: ")
    assert "--scratch" in told
    assert not batch.out.exists()

    upload(tmp_path / "data", "full/data")
    open_file = pathlib.Path.open
    monkeypatch.setattr(pathlib.Path, "open", lambda *words, **how: FullFile(open_file(*words, **how)))
    with (
        pytest.raises(OutputError, match="the scratch folder is full") as caught,
        download(f"s3://{BUCKET}/full/data", tmp_path / "scratch"),
    ):
        pass
    assert caught.value.path == str(tmp_path / "scratch")
    monkeypatch.undo()
    with (
        pytest.raises(OutputError, match="the scratch folder is full") as caught,
        RemoteStore(f"s3://{BUCKET}/full/out", tmp_path / "scratch").output("x/y.mcap") as place,
    ):
        raise OutputError("cannot write", path=place) from OSError(errno.ENOSPC, "No space left on device")
    assert caught.value.path == str(tmp_path / "scratch")


class FullFile:
    """A file on a disk without space."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def write(self, _: bytes) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")


def test_a_plan_has_the_sizes_that_the_store_lists(tmp_path: Path, server: Flaky) -> None:
    local = Batch(tmp_path, sources=2)
    upload(tmp_path / "data", "sizes/data")
    (tmp_path / "manifest.toml").write_text(
        f'destination = "out"\n[[source]]\npath = "s3://{BUCKET}/sizes/data/*"\n[[target]]\nto = "mcap"\n'
    )
    sizes = [
        sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
        for folder in sorted((tmp_path / "data").iterdir())
    ]
    assert [task["bytes_in"] for task in local.plan()] == sizes


def test_a_damaged_source_in_a_bucket_is_named_as_in_the_bucket(tmp_path: Path, server: Flaky) -> None:
    import obstore
    from obstore.store import from_url

    obstore.put(from_url(f"s3://{BUCKET}"), "bad/bad.bag", b"#ROSBAG V2.0\njunk")
    batch = manifest(tmp_path, f"s3://{BUCKET}/bad/bad.bag", "out")
    batch.plan()
    assert batch.run(code=1)["failed"] == 4
    (reason,) = {entry["reason"].partition(": ")[0] for entry in batch.ledger().values()}
    assert reason.startswith(f"s3://{BUCKET}/bad/bad.bag, offset")


def test_a_bucket_that_is_not_there_is_one_error(tmp_path: Path, server: Flaky) -> None:
    batch = Batch(tmp_path, sources=2, destination="s3://nosuch/out")
    batch.plan()
    message = batch.call("batch", "run", "plan.json", code=4)
    assert message.startswith("error: s3://nosuch/out: the destination cannot be written to")
    assert "NoSuchBucket" in message


def test_a_password_in_the_endpoint_is_not_told(
    tmp_path: Path, server: Flaky, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tumtools.batch.stores.remote._RETRIES", {"max_retries": 0})
    monkeypatch.setenv("AWS_ENDPOINT_URL", "http://user:the-password@127.0.0.1:9")
    from tumtools.batch.stores import remote

    remote._open.cache_clear()
    with pytest.raises(TumtoolsError, match=r"http://\.\.\.@127") as caught:
        remote.RemoteStore(f"s3://{BUCKET}/x").read("name")
    assert "the-password" not in str(caught.value)
    remote._open.cache_clear()
