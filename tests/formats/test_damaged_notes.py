# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What a container keeps beside its messages is ours: where it is damaged nobody takes it for another's."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import pytest

from tests.formats.rosbag1.samples import CONNECTIONS, bag_bytes, string
from tests.memory import SECOND, START, Memory
from tumtools.convert import ConvertOptions, convert
from tumtools.errors import InputError, LossRefusedError
from tumtools.formats.options import ReadOptions, WriteOptions
from tumtools.formats.registry import FORMATS
from tumtools.formats.ros.recording import OutMessage
from tumtools.sources import open_source

if TYPE_CHECKING:
    from pathlib import Path

FILES = {"mcap": "x.mcap", "rosbag1": "x.bag", "rosbag2": "x/metadata.yaml", "rawlog": "x/x.rawlog"}
NAME = (b"memory", b"memorz")
"""Of the sequence; only the checksum tells."""
BRACE = (b'"crc32":', b'"crc32"{')
"""In the JSON of a bag or a rawlog."""
HASH = (b" pixels ", b" pixelz ")
CASES = [
    *((name, NAME, "metadata") for name in FILES),
    ("rosbag1", BRACE, "metadata"),
    ("rawlog", BRACE, "metadata"),
    *((name, HASH, "digest") for name in FILES),
    ("rosbag1", (b'"version":"2"}', b'"version":"2"]'), "digest"),
    ("rosbag2", (rb"\"version\":\"2\"}", rb"\"version\":\"2\"]"), "digest"),
    ("rawlog", (b'"version":"2"}}', b'"version":"2"]}'), "digest"),
]


def damaged(folder: Path, name: str, change: tuple[bytes, bytes]) -> Path:
    """Write a sequence and change it."""
    options = WriteOptions(compression="none") if name in {"rosbag1", "rawlog"} else WriteOptions()
    path = folder / f"x{FORMATS[name].suffix}"
    sequence = Memory({"rgb": [START], "depth": [START, START + SECOND]})
    convert(sequence, path, name, options, ConvertOptions(digest=True))
    file = folder / FILES[name]
    data = file.read_bytes()
    assert change[0] in data
    file.write_bytes(data.replace(*change))
    return path


@pytest.mark.parametrize(("name", "change", "what"), CASES)
def test_it_is_an_error_that_a_salvage_passes_over_and_tells(
    name: str, change: tuple[bytes, bytes], what: str, tmp_path: Path
) -> None:
    path = damaged(tmp_path, name, change)
    with pytest.raises(InputError) as caught:
        open_source(path)
    assert caught.value.path
    if name == "rawlog" or (name == "rosbag1" and b"memory" not in change and b" pixels " not in change):
        assert "offset" in (caught.value.location or "")
    with open_source(path, ReadOptions(salvage=True)) as sequence:
        assert {stream: info.count for stream, info in sequence.info.images.items()} == {"rgb": 1, "depth": 2}
        (loss,) = sequence.info.not_carried
        assert (loss.what, loss.count) == ("left out as damaged", 1)
        assert any("this is left out" in text for text in sequence.info.warnings)
        assert (sequence.info.digest is None) == (what == "digest")
        assert (sequence.info.name == "memory") == (what == "digest")
        with pytest.raises(LossRefusedError):
            convert(sequence, tmp_path / "y", "tum", options=ConvertOptions(strict=True))


@pytest.mark.parametrize("name", FILES)
def test_nothing_is_told_where_nothing_is_damaged(name: str, tmp_path: Path) -> None:
    path = damaged(tmp_path, name, (NAME[0], NAME[0]))
    with open_source(path, ReadOptions(salvage=True)) as sequence:
        assert sequence.info.name == "memory"
        assert (sequence.info.not_carried, sequence.info.warnings) == ((), ())


@pytest.mark.parametrize("name", FILES)
def test_a_digest_of_another_version_proves_nothing_and_harms_nothing(name: str, tmp_path: Path) -> None:
    quote = b'\\"' if name == "rosbag2" else b'"'
    change = quote.join([b"", b"version", b":", b"2", b""]), quote.join([b"", b"version", b":", b"9", b""])
    if name == "mcap":
        change = b"version\1\0\0\0002", b"version\1\0\0\0009"
    with open_source(damaged(tmp_path, name, change)) as sequence:
        assert sequence.info.digest is None
        assert (sequence.info.not_carried, sequence.info.warnings) == ((), ())


def test_what_others_say_on_our_topic_of_a_bag_is_told(tmp_path: Path) -> None:
    """A topic of another type is nobody's metadata; two bags that were joined have it twice."""
    ours = [OutMessage(0, START + n, (string(f'{{"a":"{n}"}}'),)) for n in range(3)]
    path = tmp_path / "x.bag"
    path.write_bytes(bag_bytes(ours, connections=[replace(CONNECTIONS[0], topic="/tumtools/digest")]))
    with pytest.raises(InputError, match="digest is damaged"):
        open_source(path)
    with open_source(path, ReadOptions(salvage=True)) as sequence:
        assert [(loss.what, loss.count) for loss in sequence.info.not_carried] == [
            ("left out as damaged", 1),
            ("messages besides the first not carried over", 2),
        ]
    other = replace(CONNECTIONS[0], topic="/tumtools/sequence", type="std_msgs/Empty", definition="")
    path.write_bytes(bag_bytes(ours, connections=[other]))
    with open_source(path) as sequence:
        assert [(loss.stream, loss.count) for loss in sequence.info.not_carried] == [
            ("/tumtools/sequence", 3)
        ]
