# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`fetch`, `list`, `info NAME` and `cache` as a user runs them."""

from __future__ import annotations

import hashlib
import io
import json
import re
import struct
import tarfile
import time
from pathlib import Path
from typing import Any

import pytest

from tests.fetch.conftest import ARCHIVE, Place, make_tar, place, sequence_files, server, sha256
from tumtools.catalogue import packaged_catalogue
from tumtools.cli.main import run
from tumtools.cli.progress import fetch_progress
from tumtools.fetch import Event, fetch_all
from tumtools.model.digest import to_strings
from tumtools.sources import open_source

FULL = Path(__file__).parents[2] / "fixtures" / "full"

__all__ = ["place", "server"]  # fixtures


class Cli:
    """Runs commands and remembers what they said."""

    def __init__(self, place: Place, capsys: pytest.CaptureFixture[str]) -> None:
        self.place = place
        self._capsys = capsys
        self.out = self.err = ""

    def __call__(self, *arguments: str) -> int:
        code = run(list(arguments))
        self.out, self.err = self._capsys.readouterr()
        return code

    def json(self, *arguments: str) -> dict[str, Any]:
        self(*arguments, "--json")
        document: dict[str, Any] = json.loads(self.out)
        assert document["schema_version"] == 1
        return document

    def catalogue(self, *sequences: tuple[str, str], **facts: object) -> None:
        """Put a user's catalogue of names and paths on the server into the configuration folder."""
        entries = [
            {"name": name, "files": {"tgz": {"urls": [self.place.server.url(path)], **facts}}}
            for name, path in sequences
        ]
        folder = self.place.folder / "config" / "tumtools"
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "catalogue.json").write_text(json.dumps({"sequences": entries}))


@pytest.fixture
def cli(place: Place, capsys: pytest.CaptureFixture[str]) -> Cli:
    place.serve()
    made = Cli(place, capsys)
    made.catalogue(("mini/one", "/f/mini.tgz"), ("mini/two", "/f/mini.tgz"), ("mini/gone", "/f/gone.tgz"))
    return made


def test_fetch_prints_where_it_is_and_how_it_is_trusted(cli: Cli) -> None:
    assert cli("fetch", "mini/one") == 0
    assert cli.out.startswith("mini/one  cache/mini_one  (600.5 kB in ")
    assert cli.out.endswith("; sha256 not known before)\n")
    assert "nobody publishes its checksum; it is now in" in cli.err
    assert cli("fetch", "mini/one") == 0
    assert cli.out == "mini/one  cache/mini_one  (was there; sha256 not known before)\n"
    assert len(cli.place.server.requests) == 1


def test_one_that_fails_does_not_stop_the_others(cli: Cli) -> None:
    assert cli("fetch", "mini/gone", "mini/one", "mini/two", "mini/one", "--jobs", "3") == 5
    assert "mini/one  cache/mini_one" in cli.out
    assert "mini/two  cache/mini_two" in cli.out
    assert "error: mini/gone: " in cli.err
    assert "HTTP 404" in cli.err
    assert "2 fetched (1.2 MB), 0 were there, 1 failed" in cli.err
    assert len(cli.place.server.requests) == 3


def test_fetch_as_json(cli: Cli) -> None:
    one, gone = cli.json("fetch", "mini/one", "mini/gone")["sequences"]
    assert (one["status"], one["sha256"], one["downloaded"]) == ("fetched", sha256(ARCHIVE), len(ARCHIVE))
    assert (gone["status"], gone["exit_code"]) == ("failed", 5)
    assert cli.json("fetch", "mini/one")["sequences"][0]["status"] == "present"


def test_what_was_unpacked_is_validated_quickly(cli: Cli) -> None:
    (one,) = cli.json("fetch", "mini/one")["sequences"]
    assert one["validation"]["error"] > 0  # its image is noise
    assert "mini/one: quick validation found" in cli.err
    assert "`tumtools validate cache/mini_one` shows them" in cli.err
    assert cli.json("fetch", "mini/one")["sequences"][0]["validation"] is None


def test_a_crash_in_a_thread_is_not_lost(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    def crash(*_: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr("tumtools.fetch.parallel.fetch", crash)
    with pytest.raises(ZeroDivisionError):
        fetch_all([place.entry()])


def test_progress_is_a_line_for_each_download(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    with fetch_progress() as report:
        for done in range(0, 3_000_000, 100_000):
            for name, total in (("mini/one", 3_000_000), ("mini/two", None)):
                report(Event(name, "downloading", done, total))
            time.sleep(0.01)
        report(Event("mini/one", "note", message="the connection broke"))
        report(Event("mini/one", "done"))
    shown = terminal.getvalue()
    assert re.search(r"mini/one: +\d+%.*M/3\.00M \[.*<.*B/s\]", shown)
    assert re.search(r"mini/two: .*MB \[.*B/s\]", shown)
    assert "mini/one: the connection broke" in shown


def test_an_unknown_name_downloads_nothing(cli: Cli) -> None:
    assert cli("fetch", "mini/one", "mini/oen") == 2
    assert "did you mean mini/one" in cli.err
    assert cli.place.server.requests == []


def test_a_fetched_sequence_needs_its_catalogue_no_more(cli: Cli) -> None:
    assert cli("fetch", "mini/one") == 0
    (cli.place.folder / "config" / "tumtools" / "catalogue.json").unlink()
    assert cli("fetch", "mini/one", "--offline") == 0
    assert "was there" in cli.out
    assert cli("fetch", "mini/two") == 2
    assert "--catalogue FILE adds your own" in cli.err


def test_an_interrupted_download_says_that_it_goes_on(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("tumtools.fetch.fetch_all", interrupt)
    assert cli("fetch", "mini/one") == 130
    assert "what has come is kept: the same command goes on from there" in cli.err


def test_a_cache_that_cannot_be_written_says_what_to_do(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    (cli.place.folder / "file").touch()
    monkeypatch.setenv("TUMTOOLS_CACHE", str(cli.place.folder / "file"))
    assert cli("fetch", "mini/one") == 4
    assert "cannot be locked: Not a directory" in cli.err
    assert "TUMTOOLS_CACHE names another folder" in cli.err


def test_a_kind_that_a_sequence_does_not_have(cli: Cli) -> None:
    assert cli("fetch", "mini/one", "--format", "bag") == 2
    assert "the catalogue knows no bag file of mini/one" in cli.err


def test_list_marks_what_is_fetched(cli: Cli) -> None:
    cli("fetch", "mini/one")
    assert cli("list", "--kind", "sequence") == 0
    assert [line.split()[1] for line in cli.out.splitlines() if line.startswith("*")] == ["mini/one"]
    documents = cli.json("list")["sequences"]
    assert len(documents) == 89 + 3
    assert [document["short"] for document in documents if document["fetched"]] == ["mini/one"]
    assert [
        d["short"] for d in cli.json("list", "--camera", "fr2", "--category", "testing")["sequences"]
    ] == [
        "fr2/xyz",
        "fr2/rpy",
    ]


def test_a_list_of_nothing_says_what_there_is(cli: Cli) -> None:
    assert cli("list", "--camera", "fr9") == 0
    assert cli.out == ""
    assert "the cameras fr1, fr2, fr3" in cli.err
    assert "Handheld SLAM" in cli.err


def test_info_of_a_sequence_that_is_not_here_shows_the_catalogue(cli: Cli) -> None:
    assert cli("info", "fr2/large_no_loop") == 0
    assert "not fetched" in cli.out
    assert "ground truth covers 21.37 of 112.37 s; the longest hole has 90.123 s" in cli.out
    assert "`tumtools fetch fr2/large_no_loop` gets it" in cli.out
    document = cli.json("info", "fr1/desk")["catalogue"]
    assert document["groundtruth"]["first_stamp"] == "1305031449799600000"
    assert document["files"]["tgz"]["standing"] == "confirmed"


def test_cache_verify_tells_what_the_checksums_of_the_files_do_not(cli: Cli) -> None:
    cli("fetch", "mini/one")
    folder = cli.place.cache / "mini_one"
    (folder / "groundtruth.txt").write_text("1305031102.0000 0 0 0 0 0 0 1\n")
    assert cli("cache", "verify") == 5
    assert "the content of groundtruth is not what was fetched" in cli.err

    (folder / "groundtruth.txt").unlink()
    text = (folder / "rgb.txt").read_text()
    (folder / "rgb.txt").write_text(f"# seen\n{text}")
    assert cli("cache", "verify") == 5
    assert "mini_one/rgb.txt has changed" in cli.err
    assert "content" not in cli.err


def test_the_cache_and_an_archive_made_from_it_have_the_same_digest(cli: Cli) -> None:
    files = {
        f"full/{path.relative_to(FULL)}": path.read_bytes() for path in FULL.rglob("*") if path.is_file()
    }
    cli.place.serve(make_tar(files), "/full.tgz")
    cli.catalogue(("full", "/full.tgz"))
    assert cli("fetch", "full") == 0
    assert cli("convert", "full", str(cli.place.folder / "full.mcap"), "--to", "mcap", "--archive") == 0
    known = cli.json("cache", "list")["sequences"][0]["digest"]
    with open_source(cli.place.folder / "full.mcap") as sequence:
        assert sequence.info.digest is not None
        assert to_strings(sequence.info.digest) == known
    assert len(known) == 5


def test_a_command_on_a_sequence_that_is_not_here_says_how_to_get_it(cli: Cli) -> None:
    assert cli("convert", "fr1/desk", "--to", "mcap") == 4
    assert "hint: `tumtools fetch fr1/desk` gets it" in cli.err
    assert cli("digest", "fr1/dsk") == 4
    assert "did you mean fr1/desk" in cli.err


def test_cache_list_verify_and_prune(cli: Cli) -> None:
    assert cli("cache", "dir") == 0
    assert cli.out == f"{cli.place.cache}\n"
    cli("fetch", "mini/one")
    cli("fetch", "mini/two", "--keep-archive")
    assert [(s["short"], s["bytes"] > 600_000) for s in cli.json("cache", "list")["sequences"]] == [
        ("mini/one", True),
        ("mini/two", True),
    ]
    assert cli("cache", "verify") == 0
    assert cli.out == "mini/one: as it was fetched\nmini/two: as it was fetched\n"

    digest = cli.json("cache", "list")["sequences"][0]["digest"]
    content = sequence_files()["rgbd_dataset_mini/rgb/1305031102.175304.png"]
    value = hashlib.sha256(struct.pack("<q", 1305031102175304000) + hashlib.sha256(content).digest())
    assert digest == {"version": "2", "rgb": f"1 files {value.hexdigest()}"}

    image = next((cli.place.cache / "mini_one" / "rgb").iterdir())
    image.write_bytes(image.read_bytes()[:-1] + b"x")
    (cli.place.cache / "mini_two" / "rgb.txt").unlink()
    assert cli("cache", "verify") == 5
    assert "mini_one/rgb/1305031102.175304.png has changed" in cli.err
    assert "mini_two/rgb.txt is missing" in cli.err
    assert cli("cache", "verify", "mini/two") == 5
    assert [s["error"] for s in cli.json("cache", "verify")["sequences"]] == [
        "mini_one/rgb/1305031102.175304.png has changed; the content of rgb is not what was fetched",
        "mini_two/rgb.txt is missing; the content of rgb is not what was fetched",
    ]

    assert cli("cache", "prune", "--dry-run") == 0
    assert "would remove leftovers of mini_two" in cli.out
    assert (cli.place.cache / "mini_two.tgz").exists()
    assert cli("cache", "prune") == 0
    assert not (cli.place.cache / "mini_two.tgz").exists()
    assert (cli.place.cache / "mini_two").exists()
    assert cli("cache", "prune", "mini/one") == 0
    assert not (cli.place.cache / "mini_one").exists()
    assert cli("cache", "prune", "--all") == 0
    assert [path.name for path in cli.place.cache.iterdir()] == [".tumtools"]
    assert cli("fetch", "mini/one") == 0


def test_prune_removes_unfinished_downloads_but_not_those_in_progress(cli: Cli) -> None:
    from tumtools.fetch import Cache

    cli.place.serve(content_length=len(ARCHIVE) * 2, path="/f/mini.tgz", ranges=False)
    assert cli("fetch", "mini/one", "--retries", "0") == 5
    part = cli.place.cache / "mini_one.tgz.part"
    assert part.exists()
    with Cache().lock("mini_one"):
        assert cli("cache", "prune") == 0
        assert "another process works on it" in cli.err
        assert part.exists()
    assert cli("cache", "prune") == 0
    assert not part.exists()


@pytest.mark.real
def test_the_whole_way_of_a_real_sequence(cli: Cli, real_sequence: Path) -> None:
    archive = cli.place.folder / "rpy.tgz"
    with tarfile.open(archive, "w:gz", compresslevel=1) as tar:
        tar.add(real_sequence, real_sequence.name)
    cli.place.serve(archive.read_bytes(), "/f/rpy.tgz", drops=[5_000_000, 20_000_000])
    mine = cli.place.folder / "mine.json"
    url = cli.place.server.url("/f/rpy.tgz")
    mine.write_text(
        json.dumps(
            {
                "sequences": [
                    {
                        "name": "mini/rpy",
                        "camera": "fr1",
                        "streams": ["rgb", "depth", "groundtruth", "accelerometer"],
                        "frames": {"rgb": 90, "depth": 90},
                        "files": {"tgz": {"urls": [url]}},
                    }
                ]
            }
        )
    )
    fetched = cli.json("fetch", "mini/rpy", "--catalogue", str(mine))["sequences"][0]
    assert fetched["validation"]["error"] == 0
    ours = cli.place.cache / "mini_rpy"
    there = {p.relative_to(real_sequence): p.read_bytes() for p in real_sequence.rglob("*") if p.is_file()}
    assert {p.relative_to(ours): p.read_bytes() for p in ours.rglob("*") if p.is_file()} == there
    # By name, without the catalogue file: the cache remembers.
    document = cli.json("info", "mini/rpy")
    assert (document["streams"]["rgb"]["count"], document["streams"]["depth"]["count"]) == (90, 90)
    cli("digest", str(real_sequence))
    expected = cli.out.split()[0]
    assert cli("digest", "mini/rpy") == 0
    assert cli.out.split()[0] == expected
    assert cli("convert", "mini/rpy", "--to", "mcap", "--archive") == 0
    assert (cli.place.folder / "mini_rpy.mcap").is_file()  # where the user is, not in the cache
    assert sorted(path.name for path in cli.place.cache.iterdir()) == [".tumtools", "mini_rpy"]


@pytest.mark.real
def test_a_real_archive_under_the_name_of_the_official_one_is_refused(cli: Cli, real_sequence: Path) -> None:
    name = "rgbd_dataset_freiburg1_rpy.tgz"
    archive = cli.place.folder / name
    with tarfile.open(archive, "w:gz", compresslevel=1) as tar:
        tar.add(real_sequence, real_sequence.name)
    body = archive.read_bytes()
    entry = packaged_catalogue().get("fr1/rpy")
    fetch = ("fetch", "fr1/rpy", "--mirror", cli.place.server.url("/m"), "--retries", "0")
    for chunked, message in ((False, "the server offers"), (True, "it has")):  # before, and after downloading
        cli.place.serve(body, f"/m/freiburg1/{name}", chunked=chunked)
        assert cli(*fetch) == 5  # the official addresses are behind a dead proxy here
        assert f"{message} {len(body)} bytes, the catalogue (measured by one source) has 410268381" in cli.err
        assert not (cli.place.cache / entry.name).exists()
        assert not list(cli.place.cache.glob("*.part"))
