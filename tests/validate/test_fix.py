# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What can be mended without guessing is mended in a copy; the rest is refused, the source untouched."""

from __future__ import annotations

import hashlib
import shutil
from pathlib import Path

import pytest

from tests.validate.faults import FAULTS
from tumtools.convert import ConvertOptions, convert
from tumtools.errors import InputError, UsageError
from tumtools.formats.options import WriteOptions
from tumtools.synthetic import synthesize
from tumtools.validate.engine import validate
from tumtools.validate.finding import Severity
from tumtools.validate.fix import fix

BY_NAME = {fault.name: fault for fault in FAULTS}
MENDED = {
    "an image file removed (colour)": "left out 1 rows without a file",
    "a header line without #": "put # before a header line",
    "CRLF": "single blanks and line feeds",
    "CRLF in one row": "single blanks and line feeds",
    "tabs": "single blanks and line feeds",
    "commas": "single blanks and line feeds",
    "a byte-order mark": "single blanks and line feeds",
    "no final line end": "single blanks and line feeds",
    "two rows swapped (colour)": "sorted the rows",
    "two rows swapped (ground truth)": "sorted the rows",
    "quaternions of norm 0.9": "normalised",
    "w first": "into the order x y z w",
}
BYTE_FOR_BYTE = set(MENDED) - {"an image file removed (colour)", "quaternions of norm 0.9"}
REFUSED = ["a word instead of a stamp", "a row with a column too few", "UTF-16", "all stamps in milliseconds"]


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fix") / "good"
    convert(synthesize(60, width=64, height=48), folder, "tum", WriteOptions(), ConvertOptions(verify=False))
    return folder


@pytest.fixture
def copy(good: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(good, tmp_path / "bad"))


def _contents(folder: Path) -> dict[str, str]:
    files = [path for path in folder.rglob("*") if path.is_file()]
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


@pytest.mark.parametrize("name", MENDED)
def test_a_fault_is_mended_in_the_copy(name: str, good: Path, copy: Path, tmp_path: Path) -> None:
    BY_NAME[name].inject(copy)
    before = _contents(copy)
    changes = fix(copy, tmp_path / "mended")
    assert MENDED[name] in " ".join(changes)
    assert len(changes) == 1
    assert _contents(copy) == before
    findings = validate(tmp_path / "mended").findings
    assert {f.code for f in findings if f.severity > Severity.INFO} == {"TUM202"}
    if name in BYTE_FOR_BYTE:
        assert _contents(tmp_path / "mended") == _contents(good)


def test_what_needs_no_mending_is_copied_as_it_is(good: Path, tmp_path: Path) -> None:
    assert fix(good, tmp_path / "mended") == []
    assert _contents(tmp_path / "mended") == _contents(good)


@pytest.mark.parametrize("name", REFUSED)
def test_what_would_have_to_be_guessed_is_refused(name: str, copy: Path, tmp_path: Path) -> None:
    BY_NAME[name].inject(copy)
    with pytest.raises(InputError):
        fix(copy, tmp_path / "mended")
    assert not (tmp_path / "mended").exists()


def test_only_sequences_of_format_tum_are_mended(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    convert(synthesize(1, width=64, height=48), path, "mcap", WriteOptions(), ConvertOptions(verify=False))
    with pytest.raises(UsageError, match="format tum"):
        fix(path, tmp_path / "mended")
