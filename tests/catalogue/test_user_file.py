# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A user's own catalogue file adds sequences; what is wrong in it is named with its place."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING

import pytest

from tumtools.catalogue import catalogue as module
from tumtools.catalogue import load_catalogue
from tumtools.errors import InputError, MissingInputError

if TYPE_CHECKING:
    from pathlib import Path

MINI: dict[str, object] = {"name": "mini/rpy", "files": {"tgz": {"urls": ["https://example.org/m.tgz"]}}}


@pytest.fixture(autouse=True)
def _own_configuration(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "user_folder", lambda: tmp_path / "config")
    monkeypatch.delenv("TUMTOOLS_CATALOGUE", raising=False)


def write(path: Path, *sequences: object) -> Path:
    path.parent.mkdir(exist_ok=True)
    path.write_text(json.dumps({"sequences": sequences}))
    return path


def test_a_json_file_adds_sequences(tmp_path: Path) -> None:
    catalogue = load_catalogue(write(tmp_path / "mine.json", MINI))
    entry = catalogue.get("mini/rpy")
    assert (entry.name, entry.short, entry.kind) == ("mini_rpy", "mini/rpy", "sequence")
    assert entry.files["tgz"].urls == ("https://example.org/m.tgz",)
    assert catalogue.get("fr1/xyz").name == "rgbd_dataset_freiburg1_xyz"


def test_a_toml_file_does_the_same(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(
        '[[sequences]]\nname = "lab_one"\nshort = "lab/one"\ncamera = "fr1"\n'
        '[sequences.files.tgz]\nurls = ["http://example.org/a/one.tgz"]\nbytes = 12\n'
        "[sequences.frames]\nrgb = 3\n"
    )
    entry = load_catalogue(path).get("lab/one")
    assert (entry.name, entry.camera, entry.files["tgz"].bytes, entry.frames) == (
        "lab_one",
        "fr1",
        12,
        {"rgb": 3},
    )


def test_files_of_the_environment_and_of_the_configuration_folder_are_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    one = write(tmp_path / "one.json", MINI)
    two = write(tmp_path / "two.json", {**MINI, "name": "mini/two"})
    write(tmp_path / "config" / "catalogue.json", {**MINI, "name": "mini/three"})
    monkeypatch.setenv("TUMTOOLS_CATALOGUE", os.pathsep.join([str(one), str(two)]))
    catalogue = load_catalogue(one)  # named twice is read once
    assert [entry.short for entry in catalogue][-3:] == ["mini/rpy", "mini/two", "mini/three"]


@pytest.mark.parametrize(
    ("change", "place", "message"),
    [
        ({"naem": "x"}, "sequences[0] (mini/rpy)", "unknown key 'naem'"),
        ({"kind": "film"}, ".kind", "expected one of sequence, validation, calibration, got 'film'"),
        ({"name": "../x"}, ".name", "names a folder"),
        ({"name": "a/../../x"}, ".short", "not a name"),
        ({"page_index": "1"}, ".page_index", "expected a whole number"),
        ({"frames": {"rgb": -1}}, ".frames", "expected a whole number"),
        ({"files": {"rar": {"urls": ["http://x/y"]}}}, ".files.rar", "unknown kind of file"),
        ({"files": {"tgz": {}}}, ".files.tgz", "the key 'urls' is missing"),
        ({"files": {"tgz": {"urls": []}}}, ".files.tgz.urls", "at least one URL"),
        ({"files": {"tgz": {"urls": ["ftp://x/y"]}}}, ".files.tgz.urls", "expected http:// or https://"),
        ({"files": {"tgz": {"urls": ["http://x/y"], "sha256": "AB"}}}, ".files.tgz.sha256", "64 lower-case"),
        ({"files": {"tgz": {"urls": ["http://x/y"], "standing": "sure"}}}, "standing", "confirmed, single"),
        ({"files": []}, ".files", "expected a table"),
    ],
)
def test_what_is_wrong_is_named_with_its_place(
    tmp_path: Path, change: dict[str, object], place: str, message: str
) -> None:
    path = write(tmp_path / "mine.json", {**MINI, **change})
    with pytest.raises(InputError) as caught:
        load_catalogue(path)
    assert caught.value.path == str(path)
    assert place in str(caught.value.location)
    assert message in caught.value.message


def test_a_near_miss_of_a_key_gets_a_suggestion(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        load_catalogue(write(tmp_path / "mine.json", {**MINI, "file": {}}))
    assert caught.value.hint == "did you mean 'files'?"


def test_a_name_that_is_taken_is_refused(tmp_path: Path) -> None:
    path = write(tmp_path / "mine.json", {**MINI, "name": "freiburg1_rpy"})
    with pytest.raises(InputError, match="is taken by rgbd_dataset_freiburg1_rpy"):
        load_catalogue(path)


@pytest.mark.parametrize("text", ["{", "[]", '{"sequences": 1}', '{"sequences": [1]}', "\xff", "[" * 100_000])
def test_what_is_no_catalogue_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "mine.json"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(InputError):
        load_catalogue(path)


def test_a_newer_layout_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "mine.json"
    path.write_text('{"schema_version": 2, "sequences": []}')
    with pytest.raises(InputError, match="expected schema_version 1, got 2"):
        load_catalogue(path)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(MissingInputError, match="no such catalogue file"):
        load_catalogue(tmp_path / "none.json")
