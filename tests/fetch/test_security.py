# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""TLS is always verified, proxies and CA settings of the system are honoured."""

from __future__ import annotations

import shutil
import ssl
import subprocess
from typing import TYPE_CHECKING

import pytest

from tests.fetch.conftest import ARCHIVE, Place
from tests.fetch.server import Served, Server
from tumtools.errors import FetchError

if TYPE_CHECKING:
    from pathlib import Path


@pytest.fixture(scope="module")
def certificate(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A certificate for localhost that nobody trusts, and its key."""
    if shutil.which("openssl") is None:
        pytest.skip("no openssl to make a certificate with")
    folder = tmp_path_factory.mktemp("tls")
    cert, key = folder / "cert.pem", folder / "key.pem"
    command = [
        "openssl",
        "req",
        "-x509",
        "-newkey",
        "rsa:2048",
        "-nodes",
        "-days",
        "2",
        "-subj",
        "/CN=localhost",
    ]
    command += [
        "-addext",
        "subjectAltName=DNS:localhost,IP:127.0.0.1",
        "-keyout",
        str(key),
        "-out",
        str(cert),
    ]
    subprocess.run(command, check=True, capture_output=True)
    return cert, key


def secure_server(certificate: tuple[Path, Path]) -> Server:
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(*certificate)
    return Server(context)


def test_a_certificate_that_nobody_trusts_is_refused_at_once(
    place: Place, certificate: tuple[Path, Path]
) -> None:
    with secure_server(certificate) as server:
        server.files["/f/mini.tgz"] = Served(ARCHIVE)
        with pytest.raises(FetchError, match=r"certificate cannot be verified: .*self.signed") as caught:
            place.fetch(place.entry(server.url("/f/mini.tgz")))
    assert "REQUESTS_CA_BUNDLE" in str(caught.value.hint)
    assert server.requests == []


@pytest.mark.parametrize("variable", ["REQUESTS_CA_BUNDLE", "SSL_CERT_FILE"])
def test_a_certificate_that_the_system_trusts_is_accepted(
    place: Place, certificate: tuple[Path, Path], variable: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(variable, str(certificate[0]))
    with secure_server(certificate) as server:
        server.files["/f/mini.tgz"] = Served(ARCHIVE, drops=[100_000])
        assert place.fetch(place.entry(server.url("/f/mini.tgz"))).downloaded == len(ARCHIVE)
        assert server.starts == [None, 100_000]


def test_a_redirect_from_https_to_http_is_refused(
    place: Place, certificate: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SSL_CERT_FILE", str(certificate[0]))
    place.serve()
    with secure_server(certificate) as server:
        server.files["/f/mini.tgz"] = Served(location=place.server.url("/f/mini.tgz"))
        with pytest.raises(FetchError, match="refused to follow a redirect from https to http"):
            place.fetch(place.entry(server.url("/f/mini.tgz")))
    assert place.server.requests == []


def test_a_redirect_from_http_to_https_is_followed(
    place: Place, certificate: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SSL_CERT_FILE", str(certificate[0]))
    with secure_server(certificate) as server:
        server.files["/f/mini.tgz"] = Served(ARCHIVE)
        place.serve(location=server.url("/f/mini.tgz"))
        assert place.fetch().downloaded == len(ARCHIVE)


def test_the_proxy_of_the_system_is_used(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    place.serve()  # the test server answers as a proxy does: it takes the path of the whole URL
    monkeypatch.setenv("http_proxy", place.server.url(""))
    place.fetch(place.entry("http://dataset.example.org/f/mini.tgz"))
    assert [request.path for request in place.server.requests] == ["http://dataset.example.org/f/mini.tgz"]


def test_hosts_of_no_proxy_are_asked_directly(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    place.serve()
    monkeypatch.setenv("http_proxy", "http://127.0.0.1:9")
    monkeypatch.setenv("no_proxy", "127.0.0.1")
    place.fetch()
    assert [request.path for request in place.server.requests] == ["/f/mini.tgz"]


def test_a_proxy_that_is_not_there_is_named(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("http_proxy", "http://127.0.0.1:9")
    with pytest.raises(FetchError, match="the proxy does not let us through") as caught:
        place.fetch(place.entry("http://dataset.example.org/f/mini.tgz"))
    assert "HTTPS_PROXY" in str(caught.value.hint)
