# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Digests and files are the same whatever the hash seed, the time zone, the locale and the number of jobs."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tests.roundtrip.base import FIXTURE
from tumtools.formats.registry import FORMATS

if TYPE_CHECKING:
    from collections.abc import Iterator

ROOT = Path(__file__).parents[2]
FIXTURE_DIGEST = "03feec81ef315cf68a0d4d9ec178689e5808e269c6d04eb97be0bffe016a697c"
SETTINGS = (
    {"PYTHONHASHSEED": "0", "TZ": "UTC", "LC_ALL": "C", "jobs": "1"},
    {"PYTHONHASHSEED": "1", "TZ": "Asia/Kathmandu", "LC_ALL": "C.UTF-8", "jobs": "2"},
    {"PYTHONHASHSEED": "random", "TZ": "America/St_Johns", "LC_ALL": "de_DE.UTF-8", "jobs": "8"},
)


def run(folder: Path, settings: dict[str, str], *words: str) -> str:
    environment = {**os.environ, **settings, "PYTHONPATH": str(ROOT)}
    jobs = environment.pop("jobs")
    command = [sys.executable, "-m", "tumtools", *words, "--jobs", jobs]
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, check=True, timeout=120
    )
    return done.stdout


def files(path: Path) -> Iterator[tuple[str, str]]:
    for file in sorted(path.rglob("*") if path.is_dir() else [path]):
        if file.is_file():
            yield str(file.relative_to(path)), hashlib.sha256(file.read_bytes()).hexdigest()


@pytest.mark.parametrize("name", FORMATS)
def test_the_same_bytes_and_the_same_digest_under_all_settings(name: str, tmp_path: Path) -> None:
    results = []
    for number, settings in enumerate(SETTINGS):
        folder = tmp_path / str(number)
        folder.mkdir()
        target = f"sequence{FORMATS[name].suffix}"
        run(folder, settings, "convert", str(FIXTURE), target, "--to", name)
        document = json.loads(run(folder, settings, "digest", target, "--json"))
        results.append((list(files(folder / target)), document["sha256"], document["streams"]))
    assert results[0] == results[1] == results[2]


def test_the_digest_is_the_one_in_the_documentation() -> None:
    """It is a definition: whoever changes it by accident changes it for everybody."""
    found = run(ROOT, SETTINGS[0], "digest", str(FIXTURE), "--json")
    assert json.loads(found)["sha256"] == FIXTURE_DIGEST
    assert FIXTURE_DIGEST in (ROOT / "docs" / "reference" / "digest.md").read_text()
