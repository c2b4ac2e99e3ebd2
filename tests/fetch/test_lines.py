# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Bad lines and bad servers: every download ends verified, or says what is wrong."""

from __future__ import annotations

import dataclasses
import re
from datetime import UTC, datetime, timedelta
from email.utils import format_datetime
from typing import TYPE_CHECKING

import pytest

from tests.fetch.conftest import ARCHIVE, QUICK, Place, sequence_files, sha256
from tests.fetch.server import LAST_MODIFIED, MTIME, Served
from tumtools.errors import FetchError, IntegrityError

if TYPE_CHECKING:
    from pathlib import Path

SIZE = len(ARCHIVE)
SHA = sha256(ARCHIVE)


def assert_unpacked(folder: Path) -> None:
    there = {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    assert there == {name.removeprefix("rgbd_dataset_mini/"): data for name, data in sequence_files().items()}


def assert_fetched(place: Place) -> None:
    """All is in place, and nothing else is left."""
    assert_unpacked(place.cache / "rgbd_dataset_mini")
    assert sorted(path.name for path in place.cache.iterdir()) == [".tumtools", "rgbd_dataset_mini"]
    meta = sorted(path.name for path in (place.cache / ".tumtools").iterdir())
    assert meta == [f"rgbd_dataset_mini.{end}" for end in ("json", "lock", "sha256")]


def test_normal(place: Place) -> None:
    place.serve()
    fetched = place.fetch()
    assert_fetched(place)
    assert (fetched.bytes, fetched.sha256, fetched.downloaded) == (SIZE, SHA, SIZE)
    assert fetched.path == place.cache / "rgbd_dataset_mini"
    assert place.server.requests[0].headers["Accept-Encoding"] == "identity"
    assert place.server.requests[0].headers["User-Agent"].startswith("tumtools/")


def test_redirect_to_another_host_name(place: Place) -> None:
    place.serve(path="/g/mini.tgz")
    place.serve(location=place.server.url("/g/mini.tgz", "localhost"))
    assert place.fetch().url == place.server.url("/f/mini.tgz")
    assert_fetched(place)


def test_relative_redirects_are_followed_and_endless_ones_are_not(place: Place) -> None:
    place.serve(path="/f/b.tgz")
    place.serve(location="b.tgz")
    assert place.fetch().downloaded == SIZE
    place.serve(path="/f/loop.tgz", location="loop.tgz")
    with pytest.raises(FetchError, match="more than 10 redirects"):
        place.fetch(place.entry("/f/loop.tgz"), dest=place.folder / "other")


def test_redirects_to_other_schemes_are_refused(place: Place) -> None:
    place.serve(location="file:///etc/passwd")
    with pytest.raises(FetchError, match="refused to follow a redirect to file"):
        place.fetch()
    assert place.nothing_in_place()


def test_thirty_broken_connections_in_a_row_download_nothing_twice(place: Place) -> None:
    place.serve(drops=[SIZE // 31] * 30)
    fetched = place.fetch()
    assert_fetched(place)
    starts = [start or 0 for start in place.server.starts]
    assert len(starts) == 31
    assert starts == [number * (SIZE // 31) for number in range(31)]
    assert place.server.sent == fetched.downloaded == SIZE


def test_the_etag_goes_with_every_resume(place: Place) -> None:
    place.serve(drops=[1000])
    place.fetch()
    assert place.server.requests[1].headers["Range"] == "bytes=1000-"
    assert place.server.requests[1].headers["If-Range"] == '"one"'


def test_a_weak_etag_is_no_validator_but_the_date_is(place: Place) -> None:
    place.serve(drops=[1000], etag='W/"one"')
    place.fetch()
    assert place.server.requests[1].headers["If-Range"] == LAST_MODIFIED
    assert place.server.starts == [None, 1000]


def test_without_any_validator_a_resume_needs_a_known_checksum(place: Place) -> None:
    place.serve(drops=[1000], etag=None, last_modified=None)
    place.fetch()
    assert place.server.starts == [None, None]
    place.serve(drops=[1000], etag=None, last_modified=None)
    place.server.requests.clear()
    place.fetch(place.entry(sha256=SHA), dest=place.folder / "other")
    assert place.server.starts == [None, 1000]
    assert "If-Range" not in place.server.requests[1].headers


def test_a_stalled_connection_is_given_up_and_resumed(place: Place) -> None:
    place.serve(stall=True, block=10_000)
    place.fetch(patience=dataclasses.replace(QUICK, read_timeout=0.3))
    assert_fetched(place)
    assert re.search(r"no byte came for 0\.3 s, after \d+ bytes; trying again", place.notes)
    assert place.server.sent == SIZE


def test_a_server_without_ranges_sends_all_again(place: Place) -> None:
    place.serve(ranges=False, drops=[300_000])
    place.fetch()
    assert_fetched(place)
    assert "the server sent the whole file instead of the rest; starting over" in place.notes
    assert place.server.sent == SIZE + 300_000


def test_a_server_without_ranges_that_always_breaks_is_given_up(place: Place) -> None:
    place.serve(ranges=False, drops=[300_000] * 100)
    with pytest.raises(FetchError, match="the connection broke after 300000 bytes; gave up after 4 attempts"):
        place.fetch()
    assert len(place.server.requests) == 4
    assert place.nothing_in_place()


def test_a_file_that_changes_between_two_parts_is_started_over(place: Place) -> None:
    served = place.serve(b"\x1f\x8b" + bytes(500_000), drops=[100_000])

    def change(served: Served) -> None:
        if len(place.server.requests) == 2:
            served.body, served.etag = ARCHIVE, '"two"'

    served.before = change
    place.fetch()
    assert_fetched(place)
    assert place.server.starts == [None, 100_000]


def test_a_changed_etag_is_seen_even_if_the_server_ignores_if_range(place: Place) -> None:
    served = place.serve(drops=[100_000], last_modified=None)

    def change(served: Served) -> None:
        if len(place.server.requests) == 2:
            served.etag = '"two"'

    served.before = change
    served.ignore_if_range = True
    place.fetch()
    assert_fetched(place)
    assert "the file has changed on the server; starting over" in place.notes
    assert place.server.starts == [None, 100_000, None]


def test_a_part_that_is_complete_needs_no_further_byte(place: Place) -> None:
    place.serve(chunked=True, drop_at_end=True)  # without a length, only the 416 tells the end
    place.fetch()
    assert_fetched(place)
    assert place.server.requests[-1].status == 416
    assert place.server.sent == SIZE


def test_a_416_of_a_file_that_has_become_shorter_starts_over(place: Place) -> None:
    served = place.serve(ARCHIVE + bytes(100_000), drops=[SIZE + 50_000])

    def shorten(served: Served) -> None:
        if len(place.server.requests) == 2:
            served.body = ARCHIVE

    served.before = shorten
    place.fetch()
    assert_fetched(place)
    assert f"HTTP 416): its file has {SIZE} bytes, {SIZE + 100_000} were announced" in place.notes


def test_a_content_length_that_is_too_large_is_said_in_the_end(place: Place) -> None:
    place.serve(content_length=SIZE + 1000)
    with pytest.raises(
        FetchError, match=rf"its file has {SIZE} bytes, {SIZE + 1000} were announced; gave up"
    ):
        place.fetch()
    assert place.nothing_in_place()


def test_a_content_length_that_is_too_small_is_found_by_the_archive_itself(place: Place) -> None:
    place.serve(content_length=SIZE - 1000)
    with pytest.raises(IntegrityError, match="the archive is damaged or cut off"):
        place.fetch()
    assert place.nothing_in_place()


def test_and_by_the_catalogue_before_a_byte_is_downloaded(place: Place) -> None:
    place.serve(content_length=SIZE - 1000)
    with pytest.raises(
        IntegrityError, match=f"the server offers {SIZE - 1000} bytes, the catalogue .* has {SIZE}"
    ):
        place.fetch(place.entry(bytes=SIZE, sha256=SHA, standing="single"))
    assert place.nothing_in_place()
    assert not list(place.cache.glob("*.part"))


@pytest.mark.parametrize(
    "etag", [f'"{SIZE:x}-{MTIME * 1_000_000:x}"', f'"{MTIME:x}-{SIZE:x}"'], ids=["apache", "nginx"]
)
def test_and_by_the_size_in_the_etag(place: Place, etag: str) -> None:
    place.serve(content_length=SIZE - 1000, etag=etag)
    with pytest.raises(
        IntegrityError, match=rf"announces {SIZE - 1000} bytes, but its ETag says .* has {SIZE}"
    ):
        place.fetch()
    place.serve(etag=etag)
    place.fetch()
    assert_fetched(place)


def test_an_etag_that_only_looks_like_a_size_is_not_believed(place: Place) -> None:
    place.serve(etag='"1234-4ae2a151e2841f"')
    place.fetch()
    assert_fetched(place)


def test_an_html_page_with_status_200_is_named_with_its_title(place: Place) -> None:
    page = b"<!DOCTYPE html>\n<html><head><title>Log in &amp;\n continue\x1b[31m</title></head></html>"
    place.serve(page, content_type="text/html; charset=utf-8")
    with pytest.raises(FetchError) as caught:
        place.fetch()
    assert 'the server sent an HTML page titled "Log in & continue [31m" instead of a gzip archive' in str(
        caught.value
    )
    assert "open the URL in a browser" in str(caught.value.hint)
    assert len(place.server.requests) == 1  # it will not get better
    assert place.nothing_in_place()


def test_a_page_under_the_type_of_an_archive_is_found_too(place: Place) -> None:
    place.serve(b"<html><body>gone</body></html>")
    with pytest.raises(FetchError, match="the server sent an HTML page instead of a gzip archive"):
        place.fetch()


def test_something_else_is_shown_by_its_first_bytes(place: Place) -> None:
    place.serve(b"hello, world")
    with pytest.raises(
        IntegrityError, match=r"is not a gzip archive: expected b'\\x1f\\x8b' at offset 0, got b'hell'"
    ):
        place.fetch()


def test_403_behind_a_redirect_names_the_host(place: Place) -> None:
    place.serve(path="/g/mini.tgz", answers=[(403, {})])
    target = place.server.url("/g/mini.tgz", "localhost")
    place.serve(location=target)
    with pytest.raises(FetchError, match=rf"HTTP 403 Forbidden \(redirected to {target}\)") as caught:
        place.fetch()
    assert "webshare.cvg.cit.tum.de" in str(caught.value.hint)
    assert len(place.server.requests) == 2


def test_404_on_the_first_mirror_goes_to_the_second(place: Place) -> None:
    place.serve(path="/second/mini.tgz")
    fetched = place.fetch(place.entry("/first/mini.tgz", "/second/mini.tgz"))
    assert fetched.url == place.server.url("/second/mini.tgz")
    assert "first/mini.tgz: HTTP 404" in place.notes
    assert_fetched(place)


def test_if_no_mirror_works_all_are_named(place: Place) -> None:
    place.serve(path="/second/mini.tgz", answers=[(410, {})])
    with pytest.raises(FetchError) as caught:
        place.fetch(place.entry("/first/mini.tgz", "/second/mini.tgz"))
    text = str(caught.value)
    assert "none of 2 addresses works" in text
    assert "/first/mini.tgz: HTTP 404" in text
    assert "/second/mini.tgz: HTTP 410" in text
    assert "--mirror" in text


def test_another_mirror_goes_on_where_the_first_broke_if_the_checksum_is_known(place: Place) -> None:
    first = place.serve(drops=[200_000])
    first.before = lambda served: served.answers.append((404, {})) if len(place.server.requests) > 1 else None
    place.serve(path="/g/mini.tgz", etag='"another"')
    entry = place.entry("/f/mini.tgz", "/g/mini.tgz", sha256=SHA)
    assert place.fetch(entry).url.endswith("/g/mini.tgz")
    assert place.server.starts == [None, 200_000, 200_000]
    assert "If-Range" not in place.server.requests[-1].headers
    assert_fetched(place)


def test_and_starts_over_if_it_is_not(place: Place) -> None:
    first = place.serve(drops=[200_000])
    first.before = lambda served: served.answers.append((404, {})) if len(place.server.requests) > 1 else None
    place.serve(path="/g/mini.tgz", etag='"another"')
    place.fetch(place.entry("/f/mini.tgz", "/g/mini.tgz"))
    assert place.server.starts == [None, 200_000, None]
    assert_fetched(place)


def test_a_mirror_option_comes_first_in_the_benchmarks_layout_and_flat(place: Place) -> None:
    place.serve(path="/m/mini.tgz")
    fetched = place.fetch(place.entry("/f/mini.tgz"), mirror=place.server.url("/m/"))
    assert fetched.url == place.server.url("/m/mini.tgz")
    assert [request.path for request in place.server.requests] == ["/m/f/mini.tgz", "/m/mini.tgz"]


@pytest.mark.parametrize("form", ["seconds", "date"])
def test_429_waits_as_long_as_the_server_asks(place: Place, form: str) -> None:
    later = format_datetime(datetime.now(UTC) + timedelta(seconds=2), usegmt=True)
    place.serve(answers=[(429, {"Retry-After": "1" if form == "seconds" else later})])
    fetched = place.fetch()
    assert fetched.seconds > 0.9
    assert "HTTP 429 Too Many Requests; trying again in" in place.notes
    assert_fetched(place)


def test_a_server_that_asks_to_wait_for_an_hour_is_not_waited_for(place: Place) -> None:
    place.serve(answers=[(429, {"Retry-After": "3600"})])
    with pytest.raises(FetchError, match="HTTP 429 Too Many Requests; the server asks to wait 3600 s"):
        place.fetch()
    assert len(place.server.requests) == 1


@pytest.mark.parametrize("status", [408, 500, 502, 503, 504])
def test_server_errors_can_pass(place: Place, status: int) -> None:
    place.serve(answers=[(status, {}), (status, {})])
    place.fetch()
    assert_fetched(place)


def test_server_errors_that_do_not_pass_end(place: Place) -> None:
    place.serve(answers=[(500, {})] * 50)
    with pytest.raises(FetchError, match="HTTP 500 Internal Server Error; gave up after 4 attempts"):
        place.fetch()
    assert len(place.server.requests) == 4


@pytest.mark.parametrize("status", [400, 401, 403, 404, 410, 451])
def test_refusals_are_not_asked_again(place: Place, status: int) -> None:
    place.serve(answers=[(status, {})] * 9)
    with pytest.raises(FetchError, match=f"HTTP {status}"):
        place.fetch()
    assert len(place.server.requests) == 1


def test_a_flipped_byte_is_found(place: Place) -> None:
    damaged = bytearray(ARCHIVE)
    damaged[SIZE // 2] ^= 1
    place.serve(bytes(damaged))
    entry = place.entry(bytes=SIZE, sha256=SHA, standing="confirmed")
    with pytest.raises(
        IntegrityError, match=f"its sha256 is {sha256(bytes(damaged))}, the catalogue .* has {SHA}"
    ):
        place.fetch(entry)
    assert place.nothing_in_place()
    assert not list(place.cache.glob("*.part"))
    place.serve()
    place.fetch(entry)
    assert_fetched(place)


def test_a_mirror_with_a_flipped_byte_is_passed_over(place: Place) -> None:
    damaged = bytearray(ARCHIVE)
    damaged[SIZE // 2] ^= 1
    place.serve(bytes(damaged))
    place.serve(path="/good/mini.tgz")
    fetched = place.fetch(place.entry("/f/mini.tgz", "/good/mini.tgz", sha256=SHA))
    assert fetched.url.endswith("/good/mini.tgz")
    assert_fetched(place)


def test_a_resumed_file_that_turns_out_wrong_is_downloaded_again_from_its_start(place: Place) -> None:
    served = place.serve(drops=[100_000])
    entry = place.entry(sha256=SHA)
    with pytest.raises(FetchError):
        place.fetch(entry, patience=dataclasses.replace(QUICK, retries=0))
    part = next(place.cache.glob("*.part"))
    data = bytearray(part.read_bytes())
    data[50_000] ^= 1  # a disk error
    part.write_bytes(data)
    served.drops = []
    place.fetch(entry)
    assert_fetched(place)
    assert "the resumed file is not right" in place.notes
    assert place.server.starts == [None, 100_000, None]


def test_a_state_file_that_is_damaged_means_starting_over(place: Place) -> None:
    place.serve(drops=[100_000])
    with pytest.raises(FetchError):
        place.fetch(patience=dataclasses.replace(QUICK, retries=0))
    next(place.cache.glob("*.part.json")).write_text("{")
    place.fetch()
    assert_fetched(place)
    assert place.server.starts == [None, None]


def test_nobody_listens(place: Place) -> None:
    entry = place.entry("http://127.0.0.1:9/f/mini.tgz")
    with pytest.raises(FetchError, match=r"no connection: .*refused; gave up after 4 attempts"):
        place.fetch(entry)


def test_a_body_of_chunks_is_read_and_resumed(place: Place) -> None:
    place.serve(chunked=True, drops=[200_000])
    place.fetch()
    assert_fetched(place)
    assert place.server.starts == [None, 200_000]


def test_a_content_encoding_is_not_undone(place: Place) -> None:
    place.serve(content_encoding="gzip")  # what misconfigured servers say of .tgz files
    assert place.fetch().sha256 == SHA
    assert_fetched(place)


def test_credentials_in_a_url_are_not_written_anywhere(place: Place) -> None:
    place.serve()
    url = place.server.url("/f/mini.tgz").replace("http://", "http://user:secret@") + "?token=secret"
    place.server.files["/f/mini.tgz?token=secret"] = place.server.files["/f/mini.tgz"]
    fetched = place.fetch(place.entry(url))
    assert "secret" not in fetched.url
    written = [
        path.read_text("latin-1") for path in place.folder.rglob("*") if path.suffix in (".lock", ".part")
    ]
    assert not any("secret" in text for text in written)
    assert place.server.requests[0].headers["Authorization"].startswith("Basic ")
