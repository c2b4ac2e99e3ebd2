# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The digest that a file keeps of its own content."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace
from typing import TYPE_CHECKING

import pytest
from click.testing import CliRunner

from tests.memory import START, Memory, accelerometer, full, groundtruth
from tumtools.cli.main import cli
from tumtools.convert import ConvertOptions, convert
from tumtools.digest import digest
from tumtools.errors import InputError, UsageError
from tumtools.formats.options import WriteOptions
from tumtools.formats.registry import FORMATS
from tumtools.kept_digest import Watch, check
from tumtools.model.digest import KeptDigest, from_strings, to_strings
from tumtools.sources import open_source

if TYPE_CHECKING:
    from pathlib import Path

    from tumtools.model.sequence import Sequence

KEEP = ConvertOptions(digest=True)
TARGETS = (
    ("mcap", {}),
    ("mcap", {"archive": True, "profile": "ros1"}),
    ("rosbag1", {}),
    ("rosbag1", {"archive": True, "compression": "bz2"}),
    ("rosbag2", {}),
    ("rosbag2", {"storage": "mcap", "archive": True}),
    ("rosbag2", {"ros_distro": "foxy"}),
    ("rawlog", {}),
    ("rawlog", {"compression": "none"}),
    ("rawlog", {"dialect": "legacy"}),
)
ABLE = tuple(name for name, entry in FORMATS.items() if entry.writer.needs(WriteOptions()).keeps_digest)


@pytest.mark.parametrize("jobs", [1, 3])
@pytest.mark.parametrize(("name", "options"), TARGETS, ids=str)
def test_what_was_written_is_what_is_there(
    name: str, options: dict[str, object], jobs: int, tmp_path: Path
) -> None:
    target = tmp_path / f"x{FORMATS[name].suffix}"
    convert(full(), target, name, WriteOptions(jobs=jobs, **options), KEEP)  # type: ignore[arg-type]  # as named
    with open_source(target) as result:
        assert result.info.not_carried == ()
        checks = check(result, jobs=jobs)
        assert {one.stream for one in checks} == {"rgb", "depth", "ir", "accelerometer", "groundtruth"}
        assert all(one.same for one in checks)


def test_pixels_are_hashed_as_in_the_digest_of_the_content(tmp_path: Path) -> None:
    options = WriteOptions(color_encoding="bgr8", depth_encoding="32FC1")
    convert(full(), tmp_path / "x.bag", "rosbag1", options, KEEP)
    with open_source(tmp_path / "x.bag") as result:
        kept, content = result.info.digest, digest(result)
        assert kept is not None
        assert {name: (one.count, one.value) for name, one in kept.items()} == {
            name: (one.count, one.value) for name, one in content.streams.items()
        }
        assert kept["rgb"].of == "pixels"


def test_files_that_are_passed_through_are_hashed_as_they_are(tmp_path: Path) -> None:
    sequence = full()
    convert(sequence, tmp_path / "x.mcap", "mcap", WriteOptions(archive=True), KEEP)
    sha = hashlib.sha256()
    for frame in sequence.images(["depth"]):
        file = frame.load().png
        assert file is not None
        sha.update(frame.stamp.to_bytes(8, "little") + hashlib.sha256(file).digest())
    with open_source(tmp_path / "x.mcap") as result:
        assert result.info.digest is not None
        assert result.info.digest["depth"] == KeptDigest(3, "files", sha.hexdigest())


def test_depth_of_another_unit_is_not_what_was_written(tmp_path: Path) -> None:
    """The same files mean other depths; metadata of a bag may get lost on its way."""
    convert(full(), tmp_path / "x.mcap", "mcap", WriteOptions(archive=True), KEEP)
    with open_source(tmp_path / "x.mcap") as result:
        kept = result.info.digest
        assert kept is not None
        frames = list(result.images(["depth"]))
        other = [
            replace(frame, load=lambda f=frame: replace(f.load(), depth_units_per_metre=1000.0))
            for frame in frames
        ]
        for given, same in ((frames, True), (other, False)):
            watch = Watch(result, kept)
            for frame in given:
                watch.frame(frame).load()
            assert next(one for one in watch.checks() if one.stream == "depth").same is same


def test_all_formats_but_that_of_the_benchmark_hold_one() -> None:
    assert set(FORMATS) - set(ABLE) == {"tum"}


@pytest.mark.parametrize("name", ABLE)
@pytest.mark.parametrize("verify", [True, False])
def test_a_file_holds_one_unless_told_otherwise(name: str, verify: bool, tmp_path: Path) -> None:
    for number, keep in enumerate((None, True, False)):
        target = tmp_path / str(number) / f"x{FORMATS[name].suffix}"
        convert(full(), target, name, options=ConvertOptions(verify=verify, digest=keep))
        with open_source(target) as result:
            assert (result.info.digest is None) == (keep is False)


def test_a_file_without_one_says_so(tmp_path: Path) -> None:
    convert(full(), tmp_path / "x.mcap", "mcap", options=ConvertOptions(digest=False))
    with open_source(tmp_path / "x.mcap") as result, pytest.raises(InputError, match="carries no digest"):
        check(result)


@pytest.mark.parametrize(
    ("name", "options"), [("tum", WriteOptions()), ("rawlog", WriteOptions(dialect="converter"))]
)
def test_a_target_without_a_place_for_it_refuses_to_be_asked(
    name: str, options: WriteOptions, tmp_path: Path
) -> None:
    with pytest.raises(UsageError, match="no meaning"):
        convert(full(), tmp_path / "x", name, options, KEEP)
    assert not list(tmp_path.iterdir())
    convert(full(), tmp_path / "x", name, options)


@pytest.mark.parametrize("name", ABLE)
def test_empty_streams_and_sequences_without_images(name: str, tmp_path: Path) -> None:
    sequence = Memory({"rgb": [], "depth": []}, accelerometer=accelerometer(START), groundtruth=groundtruth())
    target = tmp_path / f"x{FORMATS[name].suffix}"
    convert(sequence, target, name, options=KEEP)
    with open_source(target) as result:
        assert [(one.stream, one.same) for one in check(result)] == [
            (stream, True) for stream in ("accelerometer", "depth", "groundtruth", "rgb")
        ]


def test_what_was_changed_afterwards_is_found(tmp_path: Path) -> None:
    """A bag of tumtools has no checksum of its messages; the digest finds what a checksum would not."""
    target = tmp_path / "x"
    convert(full(), target, "rosbag2", WriteOptions(color_encoding="rgb8"), KEEP)
    file = next(target.glob("*.db3"))
    with open_source(target) as result:
        pixels = next(iter(result.images(["rgb"]))).load().pixels
        assert pixels is not None
        data = pixels.tobytes()
    content = bytearray(file.read_bytes())
    content[content.index(data)] ^= 1
    file.write_bytes(content)
    with open_source(target) as result:
        assert [one.stream for one in check(result) if not one.same] == ["rgb"]
    done = CliRunner().invoke(cli, ["digest", "--check", str(target)], standalone_mode=False)
    assert done.return_value == 1
    assert "different" in done.output


def test_a_stream_that_was_taken_out_or_is_of_another_kind_differs(tmp_path: Path) -> None:
    convert(full(), tmp_path / "x.mcap", "mcap", options=KEEP)
    with open_source(tmp_path / "x.mcap") as result:
        kept = result.info.digest
        assert kept is not None
    convert(full(), tmp_path / "raw.mcap", "mcap", WriteOptions(color_encoding="rgb8"))
    with open_source(tmp_path / "raw.mcap") as other:
        other.groundtruth = None
        other.info = replace(other.info, digest=kept)
        assert [one.stream for one in check(other) if not one.same] == ["groundtruth", "ir", "rgb"]


def test_strings_of_another_version_or_damaged_prove_nothing() -> None:
    strings = to_strings({"rgb": KeptDigest(1, "pixels", "0" * 64)})
    assert from_strings(strings) == {"rgb": KeptDigest(1, "pixels", "0" * 64)}
    assert from_strings(strings | {"version": "1"}) is None
    assert from_strings(strings | {"rgb": "1 pixels 00"}) is None


def test_the_command_tells_what_it_compared(tmp_path: Path) -> None:
    convert(full(), tmp_path / "x.mcap", "mcap", options=KEEP)
    done = CliRunner().invoke(
        cli, ["digest", "--check", "--json", str(tmp_path / "x.mcap")], standalone_mode=False
    )
    document = json.loads(done.stdout)
    assert done.return_value == 0
    assert document["same"]
    assert {one["stream"]: one["kept"]["of"] for one in document["streams"]} == {
        "accelerometer": "rows",
        "depth": "pixels",
        "groundtruth": "rows",
        "ir": "files",
        "rgb": "files",
    }


def test_the_same_content_gives_the_same_bytes_with_any_number_of_jobs(tmp_path: Path) -> None:
    sequence: Sequence = full()
    for jobs in (1, 2, 8):
        convert(sequence, tmp_path / f"{jobs}.mcap", "mcap", WriteOptions(jobs=jobs), KEEP)
    assert len({(tmp_path / f"{jobs}.mcap").read_bytes() for jobs in (1, 2, 8)}) == 1
