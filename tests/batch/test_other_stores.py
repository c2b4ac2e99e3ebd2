# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Batches in stores that are not S3: Google's interface, and Azure's by its emulator azurite."""

from __future__ import annotations

import base64
import hashlib
import hmac
import json
import os
import shutil
import subprocess
from datetime import UTC, datetime
from typing import TYPE_CHECKING

import pytest
import requests

from tests.batch import batches
from tests.batch.batches import FOUR_TARGETS, Batch, hashes
from tests.batch.gs_server import gs_server
from tests.batch.s3_server import BUCKET

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

pytestmark = [pytest.mark.interop, pytest.mark.slow]

AZURITE = "TUMTOOLS_AZURITE"
ACCOUNT = "devstoreaccount1"
KEY = base64.b64encode(b"a key for a server of this test ").decode()


def assert_same_bytes(tmp_path: Path, scheme: str) -> None:
    """Run with sources, outputs and ledger in the store, in three processes; compare with a folder."""
    from tumtools.batch.claims import Claims
    from tumtools.batch.stores.remote import RemoteStore, download, match

    for name in ("remote", "local"):
        (tmp_path / name).mkdir()
    local = Batch(tmp_path / "local", sources=3, targets=FOUR_TARGETS)
    with RemoteStore(f"{scheme}://{BUCKET}").output("in/data") as place:
        shutil.copytree(local.folder / "data", place)
    assert len(match(f"{scheme}://{BUCKET}/in/data/*")) == 3
    remote = Batch(tmp_path / "remote", targets=FOUR_TARGETS)
    (remote.folder / "manifest.toml").write_text(
        f'destination = "{scheme}://{BUCKET}/out"\n[[source]]\n'
        f'path = "{scheme}://{BUCKET}/in/data/*"\n{FOUR_TARGETS}'
    )
    assert len(remote.plan()) == 12
    words = ("batch", "run", "plan.json", "--json", "--claim", "--workers", "1")
    processes = [remote.start(*words) for _ in range(3)]
    printed = [process.communicate(timeout=200) for process in processes]
    assert [process.returncode for process in processes] == [0, 0, 0], printed
    assert sum(json.loads(stdout)["counts"]["done"] for stdout, _ in printed) == 12
    assert remote.run()["done before"] == 12
    assert remote.status("--full") == {"done": 12}
    local.plan()
    local.run()
    with download(f"{scheme}://{BUCKET}/out", tmp_path) as (copy, _):
        assert hashes(copy) == local.tree()
        assert [path for path in copy.rglob("*") if "claims" in path.parts and path.is_file()] == []
    claims = Claims(RemoteStore(f"{scheme}://{BUCKET}/claims"))
    with claims.hold("0123", 0) as first, claims.hold("0123", 0) as second:
        assert first is not None
        assert first.renew()
        assert second is None


def test_google(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with gs_server() as (face, environment):
        monkeypatch.setattr(batches, "ENVIRONMENT", batches.ENVIRONMENT | environment)
        assert_same_bytes(tmp_path, "gs")
        assert face.conditions > 24


@pytest.fixture
def azure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Start azurite and make a container."""
    program = os.environ.get(AZURITE)
    if program is None:
        pytest.skip(f"{AZURITE} does not name azurite-blob (npm install azurite)")
    key = {"AZURITE_ACCOUNTS": f"{ACCOUNT}:{KEY}"}
    with subprocess.Popen(
        [program, "--inMemoryPersistence", "--blobHost", "127.0.0.1", "--blobPort", "0"],
        cwd=tmp_path,
        env=os.environ | key,
        stdout=subprocess.PIPE,
        text=True,
    ) as server:
        try:
            assert server.stdout is not None
            line = next(line for line in server.stdout if "listening on" in line or "successfully" in line)
            address = line[line.index("http://") :].split()[0].rstrip("/")
            environment = {
                "AZURE_STORAGE_ACCOUNT_NAME": ACCOUNT,
                "AZURE_STORAGE_ACCOUNT_KEY": KEY,
                "AZURE_STORAGE_ENDPOINT": f"{address}/{ACCOUNT}",
                "AZURE_ALLOW_HTTP": "true",
            }
            for name, value in environment.items():
                monkeypatch.setenv(name, value)
            monkeypatch.setattr(batches, "ENVIRONMENT", batches.ENVIRONMENT | environment)
            make_container(f"{address}/{ACCOUNT}/{BUCKET}")
            yield
        finally:
            server.kill()


def make_container(url: str) -> None:
    """Create a container; the request is signed (learn.microsoft.com, Authorize with Shared Key)."""
    date = datetime.now(UTC).strftime("%a, %d %b %Y %H:%M:%S GMT")
    text = (
        "PUT"
        + "\n" * 12
        + f"x-ms-date:{date}\nx-ms-version:2021-08-06\n/{ACCOUNT}/{ACCOUNT}/{BUCKET}\nrestype:container"
    )
    digest = hmac.new(base64.b64decode(KEY), text.encode(), hashlib.sha256).digest()
    headers = {
        "x-ms-date": date,
        "x-ms-version": "2021-08-06",
        "Authorization": f"SharedKey {ACCOUNT}:{base64.b64encode(digest).decode()}",
    }
    requests.put(f"{url}?restype=container", headers=headers, timeout=60).raise_for_status()


def test_azure(tmp_path: Path, azure: None) -> None:
    assert_same_bytes(tmp_path, "az")
