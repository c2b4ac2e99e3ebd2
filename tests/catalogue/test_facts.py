# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The packaged catalogue says what is known of the benchmark, all of it and nothing else."""

from __future__ import annotations

import hashlib
import json
import re
from datetime import UTC, datetime
from email.utils import parsedate_to_datetime
from typing import TYPE_CHECKING, Any

import pytest

from tumtools.catalogue import Entry, packaged_catalogue
from tumtools.catalogue.entry import as_table, parse_entry

if TYPE_CHECKING:
    from pathlib import Path

CATALOGUE = packaged_catalogue()
STANDINGS = {"many": "confirmed", "c2": "single"}


@pytest.fixture(scope="module")
def facts(real_data: Path) -> dict[str, Any]:
    path = real_data.parent / "spec" / "catalogue.json"
    if not path.is_file():
        pytest.skip(f"no facts at {path}")
    document: dict[str, Any] = json.loads(path.read_text("utf-8"))
    return document


def flatten(value: object, prefix: str = "") -> dict[str, object]:
    """Leaves by path."""
    if isinstance(value, dict):
        return {k: v for key, item in value.items() for k, v in flatten(item, f"{prefix}.{key}").items()}
    return {} if value is None else {prefix.removeprefix("."): value}


def expected(fact: dict[str, Any], document: dict[str, Any]) -> dict[str, object]:
    """Say the facts of a sequence in the words of the package's catalogue."""
    hosts, sources = document["hosts"], fact["sources"]
    plain = {
        key: fact[key]
        for key in ("name", "short", "category", "kind", "page_index")
        if fact.get(key) is not None
    }
    plain |= {"camera": fact["camera"].replace("freiburg", "fr")}
    plain |= {"public_groundtruth": fact.get("public_groundtruth")}
    plain |= {"streams": [stream.removesuffix(" (empty for fr3)") for stream in fact["streams"]]}
    if any("empty" in stream for stream in fact["streams"]):
        plain["empty_streams"] = ["accelerometer"]
    result = flatten(plain)
    for key in ("frames", "page_size_gib", "inner_files", "groundtruth", "paper_table1"):
        result |= flatten(fact.get(key, {}), key)
    for key, url in fact["urls"].items():
        if key == "tgz":
            webshare = url.replace(hosts["canonical"], hosts["redirect_target"])
            result["files.tgz.urls"] = [url, webshare, fact["urls"]["tgz_old"]]
        elif key != "tgz_old":
            result[f"files.{key}.urls"] = [url]
    for key in ("tgz", "bag", "rgb_avi"):
        for what, value in fact.get(key, {}).items():
            if what == "last_modified":
                date = parsedate_to_datetime(value).astimezone(UTC)
                result[f"files.{key}.{what}"] = date.strftime("%Y-%m-%dT%H:%M:%SZ")
            else:
                result[f"files.{key}.{what}"] = value
        if key in fact:
            result[f"files.{key}.standing"] = STANDINGS[sources[f"{key}.bytes"]]
    return result


@pytest.mark.real
def test_it_agrees_with_the_collected_facts_in_every_value(facts: dict[str, Any]) -> None:
    assert [entry.name for entry in CATALOGUE] == [fact["name"] for fact in facts["sequences"]]
    ours = {"aliases", "errata", "licence"}  # what the package adds
    for entry, fact in zip(CATALOGUE, facts["sequences"], strict=True):
        there = flatten(as_table(entry))
        there = {key: value for key, value in there.items() if key.split(".")[0] not in {*ours, "sources"}}
        assert there == expected(fact, facts)


@pytest.mark.real
def test_it_agrees_with_the_kind_of_source_of_every_value(facts: dict[str, Any]) -> None:
    compared = 0
    for entry, fact in zip(CATALOGUE, facts["sequences"], strict=True):
        for key, kind in fact["sources"].items():
            ours = key
            if key == "page_anchor":
                continue  # the name itself
            if match := re.fullmatch(r"urls\.tgz_(old|redirect)", key):
                ours = f"files.tgz.urls_{match[1]}"
            elif key.startswith("urls."):
                ours = f"files.{key.removeprefix('urls.')}.urls"
            elif key.split(".")[0] in fact["urls"]:
                ours = f"files.{key}"
            assert entry.source_of(ours) == kind, (entry.name, key)
            compared += 1
    assert compared > 1500
    assert CATALOGUE.source_kinds == facts["source_kinds"]


@pytest.mark.real
def test_the_real_ground_truth_files_have_the_size_and_checksum_it_gives(real_data: Path) -> None:
    files = sorted((real_data / "groundtruth").glob("*.txt"))
    assert len(files) == 14
    for path in files:
        known = CATALOGUE.get(path.name).groundtruth
        assert known is not None
        data = path.read_bytes()
        assert (len(data), hashlib.sha256(data).hexdigest()) == (known.bytes, known.sha256), path.name


def test_checksums_always_have_a_standing_and_the_etags_agree_with_sizes_and_dates() -> None:
    with_checksum = with_etag = 0
    for entry in CATALOGUE:
        for file in entry.files.values():
            assert (file.standing is None) == (file.bytes is None)
            with_checksum += file.sha256 is not None
            if file.etag is not None:
                size, microseconds = file.etag.split("-")
                assert int(size, 16) == file.bytes
                date = datetime.fromtimestamp(int(microseconds, 16) // 1_000_000, UTC)
                assert file.last_modified == date.strftime("%Y-%m-%dT%H:%M:%SZ")
                with_etag += 1
    assert with_checksum == 17
    assert with_etag == 5


def test_unknown_stays_absent() -> None:
    entry = CATALOGUE.get("fr1/xyz_validation")
    assert entry.groundtruth is None
    assert entry.files["tgz"].bytes is None
    assert entry.files["tgz"].sha256 is None
    assert "rgb" not in entry.frames
    assert "groundtruth" not in entry.streams


@pytest.mark.parametrize("entry", CATALOGUE.entries, ids=lambda entry: entry.label)
def test_an_entry_survives_the_way_through_plain_tables(entry: Entry) -> None:
    table = json.loads(json.dumps(as_table(entry)))
    assert parse_entry(table, "x", "y") == entry
