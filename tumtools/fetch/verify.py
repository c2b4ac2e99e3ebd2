# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Is this the file that was asked for? Its first bytes, its length, its checksum."""

from __future__ import annotations

import html
import re
from dataclasses import dataclass
from email.utils import parsedate_to_datetime
from typing import TYPE_CHECKING, Final

from tumtools.fetch.transport import MirrorError, plain

if TYPE_CHECKING:
    from collections.abc import Mapping

MAGIC: Final[dict[str, tuple[int, bytes, str]]] = {
    "tgz": (0, b"\x1f\x8b", "a gzip archive"),
    "tar": (257, b"ustar", "a tar archive"),
    "tar.zst": (0, b"\x28\xb5\x2f\xfd", "a zstd archive"),
    "zip": (0, b"PK", "a zip archive"),
    "bag": (0, b"#ROSBAG V2.0\n", "a ROS 1 bag"),
    "bag_2hz_pointclouds": (0, b"#ROSBAG V2.0\n", "a ROS 1 bag"),
    "mcap": (0, b"\x89MCAP0\r\n", "an MCAP file"),
    "rgb_avi": (0, b"RIFF", "an AVI film"),
    "depth_avi": (0, b"RIFF", "an AVI film"),
    "ir_avi": (0, b"RIFF", "an AVI film"),
}
"""Kind of file -> offset, bytes that are there, what to call it."""

_TITLE = re.compile(rb"<title[^>]*>(.{0,2000}?)</title", re.IGNORECASE | re.DOTALL)
_HTML = re.compile(rb"\s*(<!--.{0,4000}?-->\s*)?<(!doctype\s+html|html|head|body)", re.IGNORECASE | re.DOTALL)
_APACHE_ETAG = re.compile(r'(?:W/)?"?(?:[0-9a-f]+-)?([0-9a-f]+)-([0-9a-f]{12,14})"?')
_NGINX_ETAG = re.compile(r'(?:W/)?"?([0-9a-f]{8})-([0-9a-f]+)"?')
_PORTAL_HINT = "open the URL in a browser: a log-in page, a proxy's notice or an error page is in the way"


@dataclass(frozen=True, slots=True)
class Known:
    """What is known of a file beforehand.

    Attributes:
        by: Who knows it, for messages: `the catalogue (one source)`.
        bytes: Its size.
        sha256: Its checksum.

    """

    by: str
    bytes: int | None = None
    sha256: str | None = None


def check_announced(
    kind: str, length: int | None, headers: Mapping[str, str], known: tuple[Known, ...]
) -> None:
    """Compare the headers of a response for the whole file with what is known, before its body is read.

    Raises:
        MirrorError: It cannot be the file.

    """
    content_type = headers.get("Content-Type", "").partition(";")[0].strip().lower()
    if length is not None and not content_type.startswith("text/html"):  # a page is named by its title
        for fact in known:
            if fact.bytes is not None and fact.bytes != length:
                raise MirrorError(
                    f"the server offers {length} bytes, {fact.by} has {fact.bytes}",
                    "the server's file is another one than the catalogue's; nothing was downloaded",
                    integrity=True,
                )
        size = size_in_etag(headers.get("ETag"), headers.get("Last-Modified"))
        if size is not None and size != length:
            raise MirrorError(
                f"the server announces {length} bytes, but its ETag says that the {kind} has {size}",
                integrity=True,
            )


def check_beginning(kind: str, first: bytes, content_type: str) -> None:
    """Look at the first bytes of a file.

    Raises:
        MirrorError: An HTML page, or anything else that is not of this kind.

    """
    if kind not in MAGIC:
        if _HTML.match(first):
            raise MirrorError(f"the server sent an HTML page{_title(first)}", _PORTAL_HINT)
        return
    offset, magic, name = MAGIC[kind]
    if first[offset : offset + len(magic)] == magic:
        return
    if _HTML.match(first) or content_type.lower().startswith("text/html"):
        raise MirrorError(f"the server sent an HTML page{_title(first)} instead of {name}", _PORTAL_HINT)
    there = first[offset : offset + max(len(magic), 4)]
    raise MirrorError(
        f"what the server sent is not {name}: expected {magic!r} at offset {offset}, got {there!r}",
        integrity=True,
    )


def check_content(nbytes: int, sha256: str, known: tuple[Known, ...]) -> None:
    """Compare a complete file with what is known.

    Raises:
        MirrorError: Size or checksum differ.

    """
    for fact in known:
        if fact.bytes is not None and fact.bytes != nbytes:
            raise MirrorError(f"it has {nbytes} bytes, {fact.by} has {fact.bytes}", integrity=True)
        if fact.sha256 is not None and fact.sha256 != sha256:
            raise MirrorError(
                f"its sha256 is {sha256}, {fact.by} has {fact.sha256}",
                "the file is damaged or another one; it was thrown away",
                integrity=True,
            )


def size_in_etag(etag: str | None, last_modified: str | None) -> int | None:
    """Read the file's size out of an Apache (size-mtime) or nginx (mtime-size) ETag.

    Only if the time in it is that of Last-Modified: other servers' tags can look alike.
    """
    if etag is None or last_modified is None:
        return None
    try:
        modified = int(parsedate_to_datetime(last_modified).timestamp())
    except (TypeError, ValueError):
        return None
    if (match := _APACHE_ETAG.fullmatch(etag)) and int(match[2], 16) // 1_000_000 == modified:
        return int(match[1], 16)
    if (match := _NGINX_ETAG.fullmatch(etag)) and int(match[1], 16) == modified:
        return int(match[2], 16)
    return None


def _title(page: bytes) -> str:
    match = _TITLE.search(page)
    text = plain(html.unescape(match[1].decode("utf-8", "replace"))) if match else ""
    return f' titled "{text}"' if text else ""
