# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A server on the loopback that speaks the XML interface of Google Cloud Storage.

There is no emulator of it in the package registries that knows preconditions there. The interface is S3's
but for a few headers, so these are put in front of moto's server: an object has a number, its generation,
and conditions name that instead of the ETag (cloud.google.com/storage/docs/xml-api/reference-headers).
"""

from __future__ import annotations

import json
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import pytest
import requests

from tests.batch.s3_server import BUCKET, require_moto

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

_AUTHORIZATION = (
    "AWS4-HMAC-SHA256 Credential=somebody/20260101/us-east-1/s3/aws4_request, SignedHeaders=host, Signature=0"
)
"""In place of Google's token; moto looks at its form only."""
_CONDITION = "HTTP_X_GOOG_IF_GENERATION_MATCH"


class GoogleFace:
    """A WSGI application in front of one that speaks S3."""

    def __init__(self, inner: Callable[..., Iterable[bytes]]) -> None:
        self._inner = inner
        self._lock = threading.Lock()
        self._generations: dict[str, int] = {}
        self.conditions = 0

    def __call__(self, environ: dict[str, Any], start_response: Callable[..., object]) -> Iterable[bytes]:
        environ["HTTP_AUTHORIZATION"] = _AUTHORIZATION
        condition = environ.pop(_CONDITION, None)
        if condition is not None:
            self.conditions += 1
            if condition == "0":
                environ["HTTP_IF_NONE_MATCH"] = "*"
            else:
                tags = {str(number): tag for tag, number in self._generations.items()}
                environ["HTTP_IF_MATCH"] = tags.get(condition, '"none"')

        def start(status: str, headers: list[tuple[str, str]], *more: object) -> object:
            tag = next((value for name, value in headers if name.lower() == "etag"), None)
            if tag is not None:
                with self._lock:
                    number = self._generations.setdefault(tag, len(self._generations) + 1)
                headers = [*headers, ("x-goog-generation", str(number))]
            return start_response(status, headers, *more)

        return self._inner(environ, start)


@contextmanager
def gs_server() -> Iterator[tuple[GoogleFace, dict[str, str]]]:
    """Serve an empty bucket; give the application and the environment that leads to it."""
    make_server, application = require_moto()
    face = GoogleFace(application)
    server = make_server("127.0.0.1", 0, face, threaded=True)
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    address = f"http://127.0.0.1:{server.server_port}"
    account = {
        "gcs_base_url": address,
        "disable_oauth": True,
        "client_email": "",
        "private_key": "the-secret-key",
        "private_key_id": "",
    }
    environment = {"GOOGLE_SERVICE_ACCOUNT_KEY": json.dumps(account)}
    try:
        with pytest.MonkeyPatch.context() as patch:
            for name, value in environment.items():
                patch.setenv(name, value)
            requests.post(f"{address}/moto-api/reset", timeout=60).raise_for_status()
            requests.put(f"{address}/{BUCKET}", timeout=60).raise_for_status()
            yield face, environment
    finally:
        server.shutdown()
        server.server_close()
        thread.join()
