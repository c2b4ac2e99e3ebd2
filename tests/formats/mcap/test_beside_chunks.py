# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A writer may put messages into chunks and beside them; no index names the latter, statistics count them."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from mcap.reader import NonSeekingReader

from tests.formats.mcap.by_hand import ByHand, One, in_order, value_of
from tests.formats.mcap.foreign import Foreign
from tests.memory import START
from tumtools.cli.main import run
from tumtools.convert import convert
from tumtools.errors import InputError
from tumtools.formats.mcap.file import McapFile
from tumtools.formats.mcap.recording import McapRecording
from tumtools.sources import open_source

if TYPE_CHECKING:
    from pathlib import Path

    from tumtools.formats.ros.recording import Recording


def _imu(time: int, x: float, channel: int = 1) -> One:
    return One(channel, START + time, x)


MIXED = ByHand(
    [
        _imu(30, 0),
        [_imu(10, 1), _imu(30, 2), _imu(0, 3)],
        _imu(30, 4),
        _imu(5, 5),
        [_imu(30, 6), _imu(60, 7)],
        [_imu(20, 8)],
        _imu(30, 9),
        _imu(50, 10),
    ]
)
"""Several messages of one time, in chunks and beside them; the summary names the chunks in reverse order."""
TWO = ByHand(
    [_imu(4, 0, 2), [_imu(3, 1), _imu(9, 2)], _imu(4, 3), _imu(1, 4, 2), [_imu(4, 5), _imu(8, 6)]],
    channels={1: (1, "/imu"), 2: (1, "/other")},
)
"""A channel that is in no chunk."""


def _read(recording: Recording) -> list[tuple[int, float]]:
    found = recording.messages(recording.channels)
    return [(one.log_time, value_of(one.data)) for one in found]


@pytest.mark.parametrize("message_index", [True, False])
@pytest.mark.parametrize("by_channel", [True, False])
@pytest.mark.parametrize("file", [MIXED, TWO], ids=["mixed", "two"])
def test_all_messages_are_found_in_order_of_time_and_place(
    tmp_path: Path, file: ByHand, by_channel: bool, message_index: bool
) -> None:
    """As the reference library finds them, when it reads from the beginning; by its index it misses some."""
    path = replace(file, by_channel=by_channel, message_index=message_index).write(tmp_path / "x.mcap")
    with path.open("rb") as stream:
        theirs = [
            (one.log_time, value_of(one.data)) for _, _, one in NonSeekingReader(stream).iter_messages()
        ]
    assert theirs == in_order(file)
    recording = McapRecording(path)
    assert _read(recording) == theirs
    assert sum(channel.count or 0 for channel in recording.channels) == len(theirs)
    assert sorted(np.concatenate([recording.log_times(one) for one in recording.channels])) == [
        time for time, _ in theirs
    ]
    assert recording.warnings == ()
    batched = [(b.log_times.tolist(), b.channel.id) for b in recording.batches(recording.channels)]
    assert sum(len(times) for times, _ in batched) == len(theirs)
    part = recording.messages(recording.channels, START + 4, START + 30)
    assert [one.log_time for one in part] == [time for time, _ in theirs if 4 <= time - START <= 30]


@pytest.mark.parametrize("file", [MIXED, TWO], ids=["mixed", "two"])
@pytest.mark.parametrize("changed", [{"summary": False}, {"chunk_index": 0}], ids=["scanned", "no index"])
def test_the_order_is_the_same_without_an_index(
    tmp_path: Path, file: ByHand, changed: dict[str, int]
) -> None:
    recording = McapRecording(replace(file, **changed).write(tmp_path / "x.mcap"))  # type: ignore[arg-type]  # of any field
    assert _read(recording) == in_order(file)


def test_a_salvage_of_such_a_file_leaves_nothing_out(tmp_path: Path) -> None:
    recording = McapRecording(MIXED.write(tmp_path / "x.mcap"), salvage=True)
    assert _read(recording) == in_order(MIXED)
    assert (recording.left_out, recording.warnings) == ((), ())


@pytest.mark.parametrize("by_channel", [True, False])
def test_statistics_need_not_count_by_channel(tmp_path: Path, by_channel: bool) -> None:
    """An empty map says so; it made channels look empty, and a file without chunks, too."""
    chunked = ByHand([[_imu(0, 1), _imu(1, 2)]], by_channel=by_channel).write(tmp_path / "chunked.mcap")
    loose = ByHand([_imu(0, 1), _imu(1, 2)], by_channel=by_channel).write(tmp_path / "loose.mcap")
    for path in (chunked, loose):
        with open_source(path) as sequence:
            assert sequence.accelerometer is not None
            assert sequence.accelerometer.values[:, 0].tolist() == [1, 2]


@pytest.mark.parametrize("by_channel", [True, False])
def test_the_data_section_is_not_read_if_the_counts_agree(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, by_channel: bool
) -> None:
    chunks = [[_imu(10 * n + m, 0) for m in range(10)] for n in range(10)]
    path = ByHand([*chunks], by_channel=by_channel).write(tmp_path / "x.mcap")
    read, record = [], McapFile.record
    monkeypatch.setattr(McapFile, "record", lambda *args: read.append(args[1]) or record(*args))
    recording = McapRecording(path)
    assert recording.channels[0].count == 100
    first = next(offset for offset in sorted(read))
    assert first > max(place.offset for place in recording._file.chunks)


WRONG = {
    "a message is missing beside the chunks": (replace(MIXED, counted={1: 12}), 1),
    "it is not counted by channel": (replace(MIXED, counted={1: 12}, by_channel=False), 1),
    "a message too many": (replace(MIXED, counted={1: 10}), 0),
    "a chunk is missing": (ByHand([_imu(0, 0), [_imu(1, 1)]], counted={1: 5}), 3),
    "a chunk is in no index": (replace(MIXED, chunk_index=2), 0),
    "a chunk is missing, and there is no index": (replace(MIXED, counted={1: 15}, chunk_index=0), 4),
    "messages are counted for another channel": (replace(TWO, counted={1: 7}), 2),
}


@pytest.mark.parametrize(("file", "missing"), WRONG.values(), ids=WRONG)
def test_counts_that_do_not_agree_with_index_and_data_section_are_damage(
    tmp_path: Path, file: ByHand, missing: int
) -> None:
    path = file.write(tmp_path / "x.mcap")
    with pytest.raises(InputError, match="the statistics count") as caught:
        McapRecording(path)
    assert caught.value.exit_code == 4
    assert (caught.value.location or "").startswith("offset ")
    assert "--salvage" in (caught.value.hint or "")
    recording = McapRecording(path, salvage=True)
    assert _read(recording) == in_order(file)
    lost = {(loss.stream, loss.what): loss.count for loss in recording.left_out}
    stream = "/imu" if file.by_channel else "recording"
    assert lost == ({(stream, "messages left out as damaged"): missing} if missing else {})


def test_a_record_beside_the_chunks_whose_length_lies_is_damage(tmp_path: Path) -> None:
    path = MIXED.write(tmp_path / "x.mcap")
    data = bytearray(path.read_bytes())
    at = data.rindex(_imu(30, 9).record())
    data[at + 1 : at + 9] = b"\xff" * 8
    path.write_bytes(data)
    with pytest.raises(InputError, match="says it has") as caught:
        McapRecording(path)
    assert caught.value.location == f"offset {at}"
    recording = McapRecording(path, salvage=True)
    assert [x for _, x in _read(recording)] == [x for _, x in in_order(MIXED) if x not in {9, 10}]
    (loss,) = recording.left_out
    assert (loss.stream, loss.what, loss.count) == ("/imu", "messages left out as damaged", 2)


def test_a_chunk_that_is_said_to_be_far_beyond_the_file_is_damage(tmp_path: Path) -> None:
    path = MIXED.write(tmp_path / "x.mcap")
    data = bytearray(path.read_bytes())
    place = McapFile(path).chunks[0].offset
    at = data.rindex(place.to_bytes(8, "little"))
    data[at : at + 8] = b"\xff" * 8
    path.write_bytes(data)
    with pytest.raises(InputError, match="cut off"):
        _read(McapRecording(path))
    assert run(["info", str(path)]) == 4


def _write_images(folder: Path, *, mixed: bool) -> Path:
    folder.mkdir()
    with Foreign(folder / "x.mcap") as file:
        for row in range(6):
            file.image("/camera/color/image_raw", START + row * 10**7, row)
            with file.beside_the_chunks() if mixed else nullcontext():
                file.image("/camera/depth/image_raw", START + row * 10**7, row, encoding="16UC1")
                file.imu(START + row, float(row))
            file.pose(START + row, float(row))
    return folder / "x.mcap"


def test_images_beside_the_chunks_are_converted_with_all_others(tmp_path: Path) -> None:
    made = {}
    for mixed in (True, False):
        with open_source(_write_images(tmp_path / f"{mixed}", mixed=mixed)) as sequence:
            assert sequence.info.images["depth"].count == 6
            convert(sequence, tmp_path / f"{mixed}" / "y", "tum")
        files = [path for path in (tmp_path / f"{mixed}" / "y").rglob("*") if path.is_file()]
        made[mixed] = {path.relative_to(tmp_path / f"{mixed}"): path.read_bytes() for path in files}
    assert len(made[True]) > 12
    assert made[True] == made[False]


def test_a_channel_that_no_summary_describes_is_found(tmp_path: Path) -> None:
    """It repeats the channels of chunks; those of other messages only where it counts messages by channel."""
    file = replace(TWO, by_channel=False, repeated=frozenset({1}))
    recording = McapRecording(file.write(tmp_path / "x.mcap"))
    assert [(channel.topic, channel.count) for channel in recording.channels] == [("/imu", 5), ("/other", 2)]
    assert _read(recording) == in_order(file)
