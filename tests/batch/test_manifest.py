# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A manifest that is wrong is refused with the line."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from tumtools.batch.manifest import Manifest, read_manifest
from tumtools.batch.toml_lines import key_lines, line_of
from tumtools.errors import InputError

if TYPE_CHECKING:
    from pathlib import Path

GOOD = """\
destination = "out"
template = "{camera}/{name}-{target}.{ext}"

[[source]]  # line 4
path = "data/*"
[[source]]
name = [
  "fr1/desk",
  "fr1/xyz",
]

[[target]]  # line 12
to = "mcap"
compression = "lz4"
topics = { rgb = "/color" }

[[target]]  # line 17
to = "tum"
ext = "tgz"
start = "0.5"
"""


def read(folder: Path, text: str) -> Manifest:
    path = folder / "manifest.toml"
    path.write_text(text)
    return read_manifest(path)


def test_paths_are_taken_from_the_folder_of_the_manifest(tmp_path: Path) -> None:
    manifest = read(tmp_path, GOOD)
    assert manifest.destination == str(tmp_path / "out")
    assert manifest.sources[0].path == str(tmp_path / "data/*")
    assert manifest.sources[1].names == ("fr1/desk", "fr1/xyz")
    assert [target.ext for target in manifest.targets] == ["mcap", "tgz"]
    assert manifest.targets[0].write == {"compression": "lz4", "topics": {"rgb": "/color"}}


@pytest.mark.parametrize(
    ("old", "new", "line", "message"),
    [
        ('destination = "out"', 'destinaton = "out"', 1, "unknown key 'destinaton'"),
        ('destination = "out"', 'destination = "https://host/x"', 1, "web cannot be written"),
        ('destination = "out"', 'destination = "s3://user:secret@bucket/x"', 1, "credentials come from"),
        ('destination = "out"', 'destination = "ftp://host/x"', 1, "no store has the scheme"),
        ("{camera}/{name}", "{camera}/{nome}", 2, "unknown field {nome}"),
        ("{camera}/{name}", "{camera}/x", 2, "without {name}"),
        ('path = "data/*"', 'path = "https://host/x.tgz?X-Amz-Signature=1"', 5, "signature"),
        ('path = "data/*"', 'path = "data/*"\ncamera = "fr1"', 4, "expected a path, a name or a filter"),
        ('path = "data/*"', "path = 7", 5, "expected a text, got 7"),
        ('path = "data/*"', "path = true", 5, "expected a text, got true"),
        ('path = "data/*"', "path = 1979-05-27", 5, "expected a text, got a date or time"),
        ('path = "data/*"', 'path = ["s3://b/x?a=secret"]', 5, "expected a text, got a list"),
        ('to = "mcap"', 'to = "s3://u:secret@b/x?a=secret"', 13, 'got "b/x"'),
        ('path = "data/*"', 'path = "s3://b/x.bag?X-Amz-Signature=secret"', 5, "a query"),
        ('path = "data/*"', 'path = "s3://b/x.bag?versionId&a=secret"', 5, "a query"),
        ('destination = "out"', 'destination = "s3://b/x?a=secret"', 1, "a query"),
        ('destination = "out"', 'destination = "gs://b/x?secret"', 1, "a query"),
        ('destination = "out"', 'destination = "out\\u0000x"', 1, "NUL"),
        ('path = "data/*"', 'path = "data\\u0000/*"', 5, "NUL"),
        ('path = "data/*"', 'path = "s3://[b/x"', 5, "cannot be one"),
        ('path = "data/*"', 'path = "data/*"\nfetch = true', 6, "fetch has no effect on a path"),
        ('destination = "out"', 'destination = "out"\njobs = 100000', 2, "expected 1 to 256, got 100000"),
        ('start = "0.5"', 'start = "0.5"\nend = "0.4"', 21, "the end 0.4 is before the start 0.5"),
        ('start = "0.5"', 'start = "1305031912"\nend = "1305031910"', 21, "is before the start"),
        ('  "fr1/xyz",', "  7,", 7, "expected a text or a list of texts"),
        ('"lz4"', '"bz2"', 14, "compression bz2 is not possible for mcap"),
        ('compression = "lz4"', 'storage = "mcap"', 14, "storage has no meaning for mcap"),
        ('rgb = "/color"', 'red = "/color"', 15, "table of streams"),
        ('to = "tum"', 'to = "tun"', 18, "expected one of tum"),
        ('to = "tum"', 'to = "mcap"', 19, "mcap has no suffix 'tgz'"),
        ('"0.5"', "0.5", 20, "so that no digit is lost"),
        ('ext = "tgz"\n', 'ext = "tgz"\nlabel = "mcap"\n', 17, "a second target 'mcap'"),
    ],
)
def test_errors_name_the_line(tmp_path: Path, old: str, new: str, line: int, message: str) -> None:
    assert old in GOOD
    with pytest.raises(InputError) as caught:
        read(tmp_path, GOOD.replace(old, new))
    assert message in caught.value.message
    assert caught.value.location == f"line {line}"
    assert "secret" not in str(caught.value)


@pytest.mark.parametrize("missing", ["destination", "source", "target"])
def test_each_part_is_needed(tmp_path: Path, missing: str) -> None:
    lines = {
        "destination": 'destination = "out"',
        "source": '[[source]]\npath = "x"',
        "target": '[[target]]\nto = "tum"',
    }
    text = "\n".join(value for key, value in lines.items() if key != missing)
    with pytest.raises(InputError, match=f"no {missing}"):
        read(tmp_path, text)


@pytest.mark.parametrize("template", ["{name", "name}", "{name}}{"])
def test_braces_that_do_not_pair_are_said_to_be_that(tmp_path: Path, template: str) -> None:
    with pytest.raises(InputError, match="its braces do not pair"):
        read(tmp_path, GOOD.replace("{camera}/{name}-{target}.{ext}", template))


def test_what_is_no_utf8_is_refused_with_its_place(tmp_path: Path) -> None:
    (tmp_path / "manifest.toml").write_bytes(b'destination = "\xff"\n')
    with pytest.raises(InputError, match="not UTF-8") as caught:
        read_manifest(tmp_path / "manifest.toml")
    assert caught.value.location == "byte 15"


def test_what_is_no_toml_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="not TOML"):
        read(tmp_path, "destination = ")


def test_lines_are_found_through_strings_comments_and_nested_tables() -> None:
    text = (
        'a = """\nb = 1\n[c]\n"""\n# d = 1\n"e.f".g = 2\n[[h]]\ni = [\n 1,\n]\n[h.j]\nk = 1\n[[h]]\ni = 2\n'
    )
    lines = key_lines(text)
    assert lines["a",] == 1
    assert ("b",) not in lines
    assert lines["e.f", "g"] == 6
    assert lines["h", 0, "i"] == 8
    assert lines["h", 0, "j", "k"] == 12
    assert lines["h", 1, "i"] == 14
    assert line_of(lines, ("h", 1, "unknown")) == 13


@pytest.mark.parametrize("end", ["0.5", "0.6", "1305031910"])
def test_a_selection_that_may_hold_something_is_taken(tmp_path: Path, end: str) -> None:
    assert read(tmp_path, f'{GOOD}end = "{end}"\n').targets[1].end == end


def test_an_end_counted_from_a_start_of_the_clock_is_taken(tmp_path: Path) -> None:
    text = GOOD.replace('"0.5"', '"1305031910"')
    assert read(tmp_path, f'{text}end = "20"\n').targets[1].end == "20"


@pytest.mark.parametrize(
    "path", ["s3://b/rec?.bag", "s3://b/?/day=1/x.bag", "s3://b/day=?/*.bag", "gs://b/[ab]?/x"]
)
def test_a_question_mark_in_a_pattern_of_a_store_is_no_query(tmp_path: Path, path: str) -> None:
    assert read(tmp_path, GOOD.replace("data/*", path)).sources[0].path == path


def test_schemes_are_written_in_small_letters(tmp_path: Path) -> None:
    manifest = read(tmp_path, GOOD.replace("data/*", "S3://Lab/X.bag").replace('"out"', '"S3://Lab/Out/"'))
    assert (manifest.sources[0].path, manifest.destination) == ("s3://Lab/X.bag", "s3://Lab/Out")


def test_a_mark_of_the_coding_at_the_beginning_is_no_part_of_the_text(tmp_path: Path) -> None:
    assert read(tmp_path, "\ufeff" + GOOD).destination == str(tmp_path / "out")
