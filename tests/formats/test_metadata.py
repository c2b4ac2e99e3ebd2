# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What containers have no field for comes back from strings, and hostile strings do no harm."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.memory import SECOND, START, Memory, accelerometer, groundtruth
from tumtools.convert import ConvertOptions, convert
from tumtools.errors import InputError
from tumtools.formats import metadata
from tumtools.formats.mcap.container import Packing, write_mcap
from tumtools.formats.mcap.recording import McapRecording
from tumtools.formats.metadata import Metadata, from_strings, to_strings
from tumtools.formats.options import WriteOptions, no_progress
from tumtools.formats.registry import FORMATS
from tumtools.formats.ros.outgoing import outgoing
from tumtools.formats.ros.style import make_style
from tumtools.formats.tum.text import parse, render
from tumtools.model.text import TextLayout
from tumtools.sources import open_source

if TYPE_CHECKING:
    from pathlib import Path

LAYOUT = TextLayout(
    head="# \udcff head\n", overrides={0: "# before\n1\t2", 3: "x"}, tail="end", final_newline=False
)
FULL = Metadata(
    name="a",
    camera="fr2",
    depth_units_per_metre=5000.0,
    licence="CC BY 4.0",
    citation="somebody",
    streams={"rgb": "/a", "groundtruth": "/b"},
    text={"rgb": LAYOUT},
    row_order={"rgb": (2, 0, 1)},
)
TEXT = st.text(st.characters(exclude_categories=()), max_size=8)


def _signed(strings: dict[str, str]) -> dict[str, str]:
    """Return the strings with the checksum that somebody who knows the format would give them."""
    return strings | {"crc32": metadata._crc(strings)}


@pytest.mark.parametrize("kept", [FULL, Metadata(name="b")])
def test_it_comes_back(kept: Metadata) -> None:
    assert from_strings(to_strings(kept)) == kept


@given(
    st.builds(
        TextLayout,
        head=TEXT,
        stamp_decimals=st.integers(0, 9),
        value_format=st.sampled_from(["%r", "%.4f", "%.12e"]),
        separator=TEXT,
        newline=TEXT,
        overrides=st.dictionaries(st.integers(0, 10**6), TEXT),
        tail=TEXT,
        final_newline=st.booleans(),
    )
)
def test_any_text_comes_back(layout: TextLayout) -> None:
    strings = to_strings(Metadata(name="a", text={"rgb": layout}))
    assert all(text.isascii() for text in strings.values())
    assert from_strings(strings).text == {"rgb": layout}


def test_a_name_that_is_no_utf_8_is_written_in_words() -> None:
    strings = to_strings(Metadata(name="a\udcff"))
    assert strings["name"] == "a\\udcff"
    assert strings["name"].encode()


def test_the_order_of_rows_is_kept_only_where_it_is_not_that_of_the_stamps() -> None:
    assert metadata.order_by_stamp(np.array([], np.int64)) is None
    assert metadata.order_by_stamp(np.array([3, 3, 4])) is None
    assert metadata.order_by_stamp(np.array([3, 1, 1])) == (1, 2, 0)
    # What lies between these does not fit into 64 bits.
    assert metadata.order_by_stamp(np.array([2**63 - 1, -(2**63)])) == (1, 0)
    assert metadata.order_by_stamp(np.array([-(2**63), 2**63 - 1])) is None


def _text(**changes: object) -> str:
    values = {name: getattr(LAYOUT, name) for name in LAYOUT.__dataclass_fields__}
    return json.dumps({"rgb": values | changes})


@pytest.mark.parametrize(
    "change",
    [
        {"name": None},
        {"depth_units_per_metre": "0"},
        {"depth_units_per_metre": "-5"},
        {"depth_units_per_metre": "nan"},
        {"depth_units_per_metre": "inf"},
        {"depth_units_per_metre": "many"},
        {"streams": "[]"},
        {"streams": "{"},
        {"streams": "[" * 100_000},
        {"row_order": '{"rgb": [0, 0]}'},
        {"row_order": '{"rgb": [1, 2]}'},
        {"row_order": '{"rgb": [-1, 0]}'},
        {"row_order": '{"rgb": [99999999999999999999999]}'},
        {"row_order": '{"rgb": 5}'},
        {"row_order": '{"rgb": ["a"]}'},
        {"text": '{"rgb": {}}'},
        {"text": '{"rgb": 1}'},
        {"text": _text(value_format="%s")},
        {"text": _text(value_format="%.4f%n")},
        {"text": _text(value_format="%999999999.1f")},
        {"text": _text(value_format="%.999f")},
        {"text": _text(value_format="{0.__class__}")},
        {"text": _text(stamp_decimals=10)},
        {"text": _text(stamp_decimals=-1)},
        {"text": _text(overrides={"x": "y"})},
        {"text": _text(overrides=[])},
    ],
)
def test_hostile_strings_are_refused(change: dict[str, str | None]) -> None:
    strings = {key: value for key, value in (to_strings(FULL) | change).items() if value is not None}
    with pytest.raises(InputError, match="damaged"):
        from_strings(_signed(strings))


def test_a_later_version_is_named() -> None:
    with pytest.raises(InputError, match="version 2") as caught:
        from_strings(to_strings(FULL) | {"version": "2"})
    assert caught.value.hint == "update tumtools"


@pytest.mark.parametrize("key", [*to_strings(FULL)])
def test_a_changed_string_is_noticed(key: str) -> None:
    strings = to_strings(FULL)
    changed = chr(ord(strings[key][-1]) ^ 1)
    with pytest.raises(InputError):
        from_strings(strings | {key: strings[key][:-1] + changed})
    with pytest.raises(InputError):
        from_strings({name: text for name, text in strings.items() if name != key})


def test_what_others_add_changes_nothing() -> None:
    assert from_strings(to_strings(FULL) | {"operator": "Ada", "a": "1"}) == FULL


def test_a_camera_that_nobody_knows_is_none() -> None:
    assert from_strings(_signed(to_strings(FULL) | {"camera": "fr9"})).camera is None


def _hostile(path: Path, sequence: Memory, **changes: str) -> Path:
    """Write a MCAP file with strings of our choice."""
    style = make_style("cdr", FORMATS["mcap"], WriteOptions(archive=True))
    out = outgoing(sequence, style)
    strings = _signed(dict(out.metadata) | changes)
    packing = Packing("cdr", out.compressed_channels, "none")
    write_mcap(path, out.channels, out.messages(), strings, packing=packing, jobs=1, progress=no_progress)
    return path


def _layout_text(stream: str, **changes: object) -> str:
    layout = TextLayout()
    values = {name: getattr(layout, name) for name in layout.__dataclass_fields__}
    return json.dumps({stream: values | changes})


@pytest.mark.parametrize("name", ["../../evil.png", "/evil.png", "rgb/../../../evil.png", "..\\..\\evil.png"])
@pytest.mark.parametrize("target", ["out", "out.tgz"])
def test_file_names_cannot_leave_the_target(tmp_path: Path, name: str, target: str) -> None:
    text = _layout_text("rgb", overrides={0: f"1305031102 {name}"})
    path = _hostile(tmp_path / "x.mcap", Memory({"rgb": [START]}), text=text)
    with open_source(path) as sequence, pytest.raises(InputError, match="leads outside"):
        convert(sequence, tmp_path / "deep" / target, "tum")
    assert not [file for file in tmp_path.rglob("*") if file.is_file() and file != path]


@pytest.mark.parametrize("name", ["../../evil", "/evil", "a/b", "..", ""])
def test_a_name_cannot_lead_out_of_an_archive(tmp_path: Path, name: str) -> None:
    import tarfile

    path = _hostile(tmp_path / "x.mcap", Memory({"rgb": [START]}), name=name)
    with open_source(path) as sequence:
        convert(sequence, tmp_path / "out.tgz", "tum")
    with tarfile.open(tmp_path / "out.tgz") as archive:
        for member in archive.getnames():
            assert ".." not in member.split("/")
            assert not member.startswith("/")
            assert len(member.split("/")) <= 3


@pytest.mark.parametrize(
    "overrides",
    [
        {0: "1305031199 rgb/other.png"},
        {0: "nonsense"},
        {0: "1305031102"},
        {5: "1305031102 rgb/1305031102.png"},
        {-1: "1305031102 rgb/1305031102.png"},
    ],
)
def test_rows_that_do_not_say_what_the_messages_say_are_left_out(
    tmp_path: Path, overrides: dict[int, str]
) -> None:
    path = _hostile(
        tmp_path / "x.mcap", Memory({"rgb": [START]}), text=_layout_text("rgb", overrides=overrides)
    )
    with open_source(path) as sequence:
        assert sequence.info.text["rgb"].overrides == {}
        assert any("1 rows of rgb" in text for text in sequence.info.warnings)
        convert(sequence, tmp_path / "out", "tum")
    assert (tmp_path / "out" / "rgb.txt").read_text() == "1305031102.000000 rgb/1305031102.000000.png\n"


def test_values_in_a_literal_row_are_those_of_the_message(tmp_path: Path) -> None:
    sequence = Memory({}, groundtruth=groundtruth(START, START + SECOND), accelerometer=accelerometer(START))
    assert sequence.groundtruth is not None
    row = " ".join(map(repr, sequence.groundtruth.values[1].tolist()))
    good, bad = f"# a remark\n1305031103.000,{row}", "1305031102 9 9 9 0 0 0 1"
    text = _layout_text("groundtruth", overrides={1: good, 0: bad})
    with open_source(_hostile(tmp_path / "x.mcap", sequence, text=text)) as result:
        assert result.info.text["groundtruth"].overrides == {1: good}


def test_an_order_of_rows_that_does_not_fit_is_left_out(tmp_path: Path) -> None:
    """As when another tool has cut the recording."""
    path = _hostile(tmp_path / "x.mcap", Memory({"rgb": [START, START + 1]}), row_order='{"rgb": [2, 0, 1]}')
    with open_source(path) as sequence:
        assert sequence.image_stamps("rgb").tolist() == [START, START + 1]
        assert any("3 rows of rgb" in text for text in sequence.info.warnings)


def test_a_layout_gets_the_decimals_that_data_moved_by_others_needs() -> None:
    layout = TextLayout(stamp_decimals=6, value_format="%.4f", overrides={0: "1.5 1 2 3", 1: "9.5 1 2 3"})
    stamps, values = np.array([1_500_000_000, 2_500_000_100]), np.array([[1.0, 2.0, 3.0], [1.0, 2.0, 1 / 3]])
    found = metadata.fitting(layout, "accelerometer", stamps, values)
    assert found.overrides == {0: "1.5 1 2 3"}
    table = parse(render(found, "accelerometer", stamps, values), "accelerometer", "x")
    assert table.stamps.tolist() == stamps.tolist()
    assert np.array_equal(table.values, values)


def test_a_topic_that_is_gone_is_named(tmp_path: Path) -> None:
    path = _hostile(tmp_path / "x.mcap", Memory({"rgb": [START]}), streams='{"rgb": "/a", "depth": "/b"}')
    with open_source(path) as sequence:
        assert {text.split("topic ")[1].split()[0] for text in sequence.info.warnings} == {"/a", "/b"}


def test_our_record_is_there_once(tmp_path: Path) -> None:
    convert(Memory({"rgb": [START]}), tmp_path / "x.mcap", "mcap", None, ConvertOptions())
    kept = McapRecording(tmp_path / "x.mcap").metadata
    assert kept is not None
    assert replace(from_strings(kept), text={}) == Metadata(
        name="memory", camera="fr1", streams={"rgb": "/camera/rgb/image_color/compressed"}
    )
