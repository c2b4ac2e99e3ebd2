# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""HTTP: one request with its redirects, and which failures can pass.

System proxies and CA settings are those of requests (`HTTPS_PROXY`, `NO_PROXY`, `REQUESTS_CA_BUNDLE`, ...)
and of OpenSSL (`SSL_CERT_FILE`, the system's store). TLS is always verified.
"""

from __future__ import annotations

import re
import socket
import ssl
from dataclasses import dataclass
from datetime import UTC, datetime
from email.utils import parsedate_to_datetime
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import urljoin, urlsplit, urlunsplit

import requests
from requests.adapters import HTTPAdapter

import tumtools

if TYPE_CHECKING:
    from collections.abc import Mapping

    from tumtools.fetch.options import Patience

MAX_REDIRECTS: Final = 10
_REDIRECTS: Final = frozenset({301, 302, 303, 307, 308})
_CAN_PASS: Final = frozenset({408, 425, 429, 500, 502, 503, 504, 507, 509, 520, 521, 522, 523, 524, 529})
_HINTS: Final = {
    401: "the server wants a log-in; put the credentials into ~/.netrc",
    403: "a proxy or the server refuses this host; the benchmark needs both cvg.cit.tum.de and "
    "webshare.cvg.cit.tum.de; `--mirror URL` fetches from elsewhere",
    404: "the file is not at this address; `--mirror URL` fetches from elsewhere",
    407: "the proxy wants a log-in; put it into HTTPS_PROXY: http://user:password@proxy:port",
    429: "the server is asked too often; try later, or with fewer --jobs",
}


class MirrorError(Exception):
    """A mirror cannot give the file; the next one may.

    Attributes:
        reason: What happened.
        hint: What the user can do about it.
        integrity: Whether what it gives is not what is known.

    """

    def __init__(self, reason: str, hint: str | None = None, *, integrity: bool = False) -> None:
        super().__init__(reason)
        self.reason = reason
        self.hint = hint
        self.integrity = integrity


class PassingError(MirrorError):
    """A failure that can pass.

    Attributes:
        retry_after: Seconds that the server asks to wait.

    """

    retry_after: float | None = None


class _SystemTrust(HTTPAdapter):
    """Trusts the system's certificate store besides requests' own; both are verified against."""

    def __init__(self) -> None:
        self._context = ssl.create_default_context()
        super().__init__(max_retries=0)

    def init_poolmanager(self, *args: Any, **kwargs: Any) -> None:  # noqa: ANN401 - passed through as they are
        super().init_poolmanager(*args, **kwargs, ssl_context=self._context)

    def proxy_manager_for(self, *args: Any, **kwargs: Any) -> Any:  # noqa: ANN401 - the same
        return super().proxy_manager_for(*args, **kwargs, ssl_context=self._context)


def new_session() -> requests.Session:
    """Return a session that honours the system's settings and asks for the bytes as they are."""
    session = requests.Session()
    session.mount("https://", _SystemTrust())
    session.headers["User-Agent"] = f"tumtools/{tumtools.__version__}"
    # A .tgz must not be unpacked on the way: its checksum is of the compressed bytes.
    session.headers["Accept-Encoding"] = "identity"
    return session


def display_url(url: str) -> str:
    """Return a URL without user name, password, query and fragment, for messages and files."""
    parts = urlsplit(url)
    return urlunsplit((parts.scheme, parts.netloc.rpartition("@")[2], parts.path, "", ""))


@dataclass(frozen=True, slots=True)
class Reply:
    """A response after redirects; `where` says, for messages, if it came from another host."""

    response: requests.Response
    where: str


def request(session: requests.Session, url: str, headers: Mapping[str, str], patience: Patience) -> Reply:
    """Send a GET and follow redirects; the body is not read yet.

    Returns:
        A reply with status 200, 206 or 416.

    Raises:
        PassingError: Worth another try.
        MirrorError: Not worth one.

    """
    current = url
    for _ in range(MAX_REDIRECTS + 1):
        where = "" if current == url else f" (redirected to {display_url(current)})"
        response = _get(session, current, headers, patience, where)
        if response.status_code not in _REDIRECTS:
            return Reply(_checked(response, where, patience), where)
        target = urljoin(current, response.headers.get("Location", ""))
        response.close()
        before, after = urlsplit(current).scheme, urlsplit(target).scheme
        if "Location" not in response.headers:
            raise MirrorError(f"HTTP {response.status_code} without a Location{where}")
        if after not in ("http", "https"):
            raise MirrorError(f"refused to follow a redirect to {after}: {display_url(target)}{where}")
        if (before, after) == ("https", "http"):
            raise MirrorError(
                f"refused to follow a redirect from https to http: {display_url(target)}{where}",
                "what comes over http can be changed on the way",
            )
        current = target
    raise MirrorError(f"more than {MAX_REDIRECTS} redirects")


def _get(
    session: requests.Session, url: str, headers: Mapping[str, str], patience: Patience, where: str
) -> requests.Response:
    try:
        return session.get(
            url,
            headers=dict(headers),
            stream=True,
            allow_redirects=False,
            timeout=(patience.connect_timeout, patience.read_timeout),
        )
    except requests.exceptions.SSLError as error:
        raise MirrorError(
            f"the server's certificate cannot be verified: {_innermost(error)}{where}",
            "if a proxy with its own certificate is in between, name its CA file in REQUESTS_CA_BUNDLE",
        ) from error
    except requests.exceptions.ConnectTimeout as error:
        raise PassingError(f"no connection within {patience.connect_timeout:g} s{where}") from error
    except requests.exceptions.Timeout as error:
        raise PassingError(f"no answer within {patience.read_timeout:g} s{where}") from error
    except requests.exceptions.ProxyError as error:
        raise PassingError(
            f"the proxy does not let us through: {_innermost(error)}{where}",
            "check HTTP_PROXY, HTTPS_PROXY and NO_PROXY",
        ) from error
    except requests.exceptions.ConnectionError as error:
        cause = _innermost(error)
        if isinstance(cause, socket.gaierror) and cause.errno != socket.EAI_AGAIN:
            raise MirrorError(
                f"the host {urlsplit(url).hostname} is not known{where}", "check the name and the network"
            ) from error
        raise PassingError(f"no connection: {cause}{where}", "check the network") from error
    except requests.exceptions.RequestException as error:
        raise MirrorError(f"not a request that can be sent: {error}{where}") from error


def _checked(response: requests.Response, where: str, patience: Patience) -> requests.Response:
    status = response.status_code
    if status in (200, 206, 416):
        return response
    reason = f"HTTP {status} {plain(response.reason or '')}".rstrip() + where
    wait = _retry_after(response.headers.get("Retry-After"))
    response.close()
    if status not in _CAN_PASS:
        raise MirrorError(reason, _HINTS.get(status))
    if wait is not None and wait > patience.longest_retry_after:
        raise MirrorError(f"{reason}; the server asks to wait {wait:.0f} s", _HINTS.get(status))
    error = PassingError(reason, _HINTS.get(status))
    error.retry_after = wait
    raise error


def _retry_after(text: str | None) -> float | None:
    """Read `Retry-After`: seconds, or a date."""
    if text is None:
        return None
    if text.strip().isdigit():
        return float(text)
    try:
        return max(0.0, (parsedate_to_datetime(text) - datetime.now(UTC)).total_seconds())
    except (TypeError, ValueError):
        return None


def _innermost(error: BaseException) -> BaseException:
    """Return the exception that says what really happened, below those of requests and urllib3."""
    seen: set[int] = set()
    while id(error) not in seen:
        seen.add(id(error))
        inner = getattr(error, "reason", None) or error.__cause__ or error.__context__
        if not isinstance(inner, BaseException):
            inner = next((arg for arg in error.args if isinstance(arg, BaseException)), None)
        if inner is None:
            return error
        error = inner
    return error


def plain(text: str, limit: int = 120) -> str:
    """Make a server's text fit to print: one line, no control characters, not too long."""
    clean = re.sub(r"\s+", " ", "".join(char if char.isprintable() else " " for char in text)).strip()
    return clean if len(clean) <= limit else clean[: limit - 1] + "…"
