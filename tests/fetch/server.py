# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A server on loopback that misbehaves as asked: real sockets, a thread for each connection."""

from __future__ import annotations

import re
import socket
import threading
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import TYPE_CHECKING, Self

if TYPE_CHECKING:
    import ssl
    from collections.abc import Callable

LAST_MODIFIED = "Fri, 30 Sep 2011 15:14:33 GMT"
MTIME = 1317395673


@dataclass
class Served:
    """What is at a path, and how it is served.

    Attributes:
        body: The file.
        etag: Its ETag; None sends none.
        ranges: Whether `Range` is honoured.
        drops: Bytes after which the next connections break, one number for each.
        answers: Statuses of the next requests instead of the file, with extra headers.
        location: Redirect to this URL instead.
        content_length: What to announce instead of the true length (for the whole file).
        content_type: Type to announce.
        stall: Stop in the middle of the first response for ever.
        block: Bytes that are sent at once.
        pace: Called before a block is sent, with the position of its end; may wait.
        chunked: Send without Content-Length.
        content_encoding: Content-Encoding to claim.
        ignore_if_range: Honour Range whatever If-Range says.
        drop_at_end: Break the connection of the next response after its last byte.
        before: Called before each request is answered.

    """

    body: bytes = b""
    etag: str | None = '"one"'
    last_modified: str | None = LAST_MODIFIED
    ranges: bool = True
    drops: list[int] = field(default_factory=list)
    answers: list[tuple[int, dict[str, str]]] = field(default_factory=list)
    location: str | None = None
    content_length: int | None = None
    content_type: str = "application/x-gzip"
    stall: bool = False
    block: int = 1 << 16
    pace: Callable[[int], None] | None = None
    chunked: bool = False
    content_encoding: str | None = None
    ignore_if_range: bool = False
    drop_at_end: bool = False
    before: Callable[[Served], None] | None = None


@dataclass
class Request:
    """A request that came: path, first byte asked for (None without Range), bytes sent."""

    path: str
    start: int | None
    headers: dict[str, str]
    sent: int = 0
    status: int = 0


class Server:
    """The server; `files` can be changed while it runs."""

    def __init__(self, context: ssl.SSLContext | None = None) -> None:
        self.files: dict[str, Served] = {}
        self.requests: list[Request] = []
        self.done = threading.Event()
        server = self

        class Handler(_Handler):
            owner = server

        self._http = _Http(("127.0.0.1", 0), Handler)
        self.scheme = "http"
        if context is not None:
            self.scheme = "https"
            self._http.socket = context.wrap_socket(self._http.socket, server_side=True)
        self.port = self._http.server_address[1]
        self._thread = threading.Thread(target=self._http.serve_forever, args=(0.02,), daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.done.set()
        self._http.shutdown()
        self._http.server_close()
        self._thread.join()

    def url(self, path: str, host: str = "127.0.0.1") -> str:
        return f"{self.scheme}://{host}:{self.port}{path}"

    @property
    def sent(self) -> int:
        """Bytes of bodies that went out."""
        return sum(request.sent for request in self.requests)

    @property
    def starts(self) -> list[int | None]:
        """First bytes that were asked for."""
        return [request.start for request in self.requests]


class _Http(ThreadingHTTPServer):
    daemon_threads = True
    block_on_close = False

    def handle_error(self, request: object, client_address: object) -> None:
        """Broken connections are what this is about."""


class _Handler(BaseHTTPRequestHandler):
    owner: Server
    protocol_version = "HTTP/1.1"

    def log_message(self, *_: object) -> None:
        pass

    def setup(self) -> None:
        # Little room in the socket, so that what was sent is about what was read.
        self.request.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 1 << 14)
        super().setup()

    def do_GET(self) -> None:
        path = re.sub(r"^http://[^/]+", "", self.path)
        match = re.fullmatch(r"bytes=(\d+)-", self.headers.get("Range", ""))
        request = Request(self.path, int(match[1]) if match else None, dict(self.headers))
        self.owner.requests.append(request)
        served = self.owner.files.get(path)
        if served is None:
            self._plain(request, 404, {}, b"nothing here")
            return
        if served.before is not None:
            served.before(served)
        if served.answers:
            status, headers = served.answers.pop(0)
            self._plain(request, status, headers, b"no")
        elif served.location is not None:
            self._plain(request, 302, {"Location": served.location}, b"")
        else:
            self._file(request, served)

    def _plain(self, request: Request, status: int, headers: dict[str, str], body: bytes) -> None:
        request.status = status
        self.send_response(status)
        for name, value in headers.items():
            self.send_header(name, value)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def _file(self, request: Request, served: Served) -> None:
        body, start = served.body, 0
        if_range = self.headers.get("If-Range")
        same = served.ignore_if_range or if_range in (None, served.etag, served.last_modified)
        if request.start is not None and served.ranges and same:
            start = request.start
            if start >= len(body):
                self._plain(request, 416, {"Content-Range": f"bytes */{len(body)}"}, b"")
                return
        partial = request.start is not None and served.ranges and same
        request.status = 206 if partial else 200
        self.send_response(request.status)
        if partial:
            self.send_header("Content-Range", f"bytes {start}-{len(body) - 1}/{len(body)}")
        if served.etag is not None:
            self.send_header("ETag", served.etag)
        if served.last_modified is not None:
            self.send_header("Last-Modified", served.last_modified)
        self.send_header("Content-Type", served.content_type)
        if served.content_encoding is not None:
            self.send_header("Content-Encoding", served.content_encoding)
        whole = served.content_length if served.content_length is not None else len(body)
        length = whole - start
        if served.chunked:
            self.send_header("Transfer-Encoding", "chunked")
        else:
            self.send_header("Content-Length", str(length))
        self.end_headers()
        self._body(request, served, body[start : start + length])
        if length != len(body) - start:
            self.close_connection = True

    def _body(self, request: Request, served: Served, rest: bytes) -> None:
        drop = served.drops.pop(0) if served.drops else None
        view = memoryview(rest)[:drop]
        for begin in range(0, len(view), served.block):
            block = view[begin : begin + served.block]
            if served.pace is not None:
                served.pace(len(served.body) - len(rest) + begin + len(block))
            if served.chunked:
                self.wfile.write(b"%x\r\n" % len(block) + block + b"\r\n")
            else:
                self.wfile.write(block)
            request.sent += len(block)
            if served.stall and begin >= len(view) // 2:
                served.stall = False
                self.owner.done.wait(30)
                return
        if (drop is not None and len(view) < len(rest)) or served.drop_at_end:
            served.drop_at_end = False
            # A reset, not an orderly end.
            self.wfile.flush()
            self.connection.shutdown(socket.SHUT_RDWR)
            self.close_connection = True
        elif served.chunked:
            self.wfile.write(b"0\r\n\r\n")
