# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""An S3 server on the loopback that fails one request in ten."""

from __future__ import annotations

import logging
import os
import random
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import pytest
import requests

from tests.interop.programs import missing

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

BUCKET = "lab"


class Flaky:
    """A WSGI application in front of another: each request fails with this probability.

    Every second of those is done all the same, and only its answer is lost.
    """

    def __init__(self, inner: Callable[..., Iterable[bytes]], probability: float) -> None:
        self._inner = inner
        self._random = random.Random(8)
        self._lock = threading.Lock()
        self.probability = probability
        self.failed = self.served = 0
        self.log: list[str] = []
        """Method and path of each request."""

    def __call__(self, environ: dict[str, Any], start_response: Callable[..., object]) -> Iterable[bytes]:
        with self._lock:
            fails = self._random.random() < self.probability
            self.failed += fails
            self.served += not fails
            self.log.append(f"{environ['REQUEST_METHOD']} {environ['PATH_INFO']}")
        if not fails:
            return self._inner(environ, start_response)
        if self.failed % 2:
            list(self._inner(environ, lambda *_: None))
        else:
            environ["wsgi.input"].read(int(environ.get("CONTENT_LENGTH") or 0))
        start_response("503 Slow Down", [("Content-Length", "0")])
        return []


def objects(prefix: str = "") -> dict[str, bytes]:
    """Return what is in the bucket, without asking the server: it runs in this process."""
    from moto.core import DEFAULT_ACCOUNT_ID
    from moto.s3.models import s3_backends

    keys = s3_backends[DEFAULT_ACCOUNT_ID]["aws"].buckets[BUCKET].keys
    return {name: key.value for name, key in list(keys.items()) if name.startswith(prefix)}


def unfinished_uploads() -> int:
    """Return how many uploads in parts were begun and neither completed nor given up."""
    from moto.core import DEFAULT_ACCOUNT_ID
    from moto.s3.models import s3_backends

    return len(s3_backends[DEFAULT_ACCOUNT_ID]["aws"].buckets[BUCKET].multiparts)


def require_moto() -> tuple[Callable[..., Any], Any]:
    """Return what makes a server, and moto's application; skip the test where they are missing."""
    try:
        import obstore  # noqa: F401
        from moto.server import DomainDispatcherApplication, create_backend_app
        from werkzeug.serving import make_server

        from tumtools.batch.stores import remote
    except ImportError:
        missing("obstore and moto[server]")
    remote._open.cache_clear()  # stores of an earlier server
    logging.getLogger("werkzeug").setLevel(logging.ERROR)
    return make_server, DomainDispatcherApplication(create_backend_app)


@contextmanager
def s3_server(probability: float) -> Iterator[tuple[Flaky, dict[str, str]]]:
    """Serve an empty bucket; give the application and the environment that leads to it."""
    make_server, backend = require_moto()
    application = Flaky(backend, 0.0)
    server = make_server("127.0.0.1", 0, application, threaded=True)
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    address = f"http://127.0.0.1:{server.server_port}"
    environment = {
        "AWS_ACCESS_KEY_ID": "the-key-id",
        "AWS_SECRET_ACCESS_KEY": "the-secret-key",
        "AWS_REGION": "us-east-1",
        "AWS_ENDPOINT_URL": address,
        "AWS_ALLOW_HTTP": "true",
    }
    try:
        with pytest.MonkeyPatch.context() as patch:
            for name, value in environment.items():
                patch.setenv(name, value)
            requests.post(f"{address}/moto-api/reset", timeout=60).raise_for_status()
            requests.put(f"{address}/{BUCKET}", timeout=60).raise_for_status()
            application.probability = probability
            yield application, dict(os.environ)
    finally:
        server.shutdown()
        server.server_close()
        thread.join()
