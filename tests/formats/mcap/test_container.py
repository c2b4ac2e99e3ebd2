# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""MCAP files of ours as the reference library sees them."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
import pytest
from mcap.reader import NonSeekingReader, SeekingReader
from mcap.records import Attachment, Channel, ChunkIndex, DataEnd, Message, MessageIndex, Schema, Statistics
from mcap.stream_reader import StreamReader

from tests.memory import SECOND, START, Memory, accelerometer, full, groundtruth
from tumtools.convert import ConvertOptions, convert
from tumtools.errors import OutputError
from tumtools.formats.mcap import chunks
from tumtools.formats.mcap.container import Packing, write_mcap
from tumtools.formats.mcap.recording import McapRecording
from tumtools.formats.options import WriteOptions, no_progress
from tumtools.formats.registry import FORMATS
from tumtools.formats.ros import messages
from tumtools.formats.ros.outgoing import outgoing
from tumtools.formats.ros.style import make_style

if TYPE_CHECKING:
    from pathlib import Path

OPTIONS = [
    WriteOptions(),
    WriteOptions(archive=True),
    WriteOptions(compression="lz4", color_encoding="rgb8"),
    WriteOptions(compression="none", depth_encoding="16UC1", color_encoding="bgr8"),
]
IDS = ["default", "archive", "lz4", "none"]


def _write(path: Path, options: WriteOptions | None = None, sequence: Memory | None = None) -> Path:
    convert(sequence or full(), path, "mcap", options or WriteOptions(), ConvertOptions(force=True))
    return path


@pytest.mark.parametrize("options", OPTIONS, ids=IDS)
def test_every_record_passes_the_checks_of_the_reference_library(
    tmp_path: Path, options: WriteOptions
) -> None:
    path = _write(tmp_path / "x.mcap", options)
    with path.open("rb") as file:
        records = list(StreamReader(file, emit_chunks=False, validate_crcs=True).records)
        file.seek(0)
        with_chunks = list(StreamReader(file, emit_chunks=True).records)
    seen = [record for record in records if isinstance(record, Message)]
    data_end = next(record for record in records if isinstance(record, DataEnd))
    assert data_end.data_section_crc
    statistics = next(record for record in records if isinstance(record, Statistics))
    assert statistics.message_count == len(seen)
    assert statistics.message_start_time == START
    assert statistics.message_end_time == START + SECOND
    assert statistics.metadata_count == 2
    assert statistics.chunk_count == sum(isinstance(record, ChunkIndex) for record in records)
    assert statistics.channel_count == len({one.id for one in records if isinstance(one, Channel)})
    assert statistics.schema_count == len({one.id for one in records if isinstance(one, Schema)})
    assert all(message.log_time == message.publish_time for message in seen)
    by_channel: dict[int, list[int]] = {}
    for message in seen:
        by_channel.setdefault(message.channel_id, []).append(message.sequence)
    assert {
        number: len(sequences) for number, sequences in by_channel.items()
    } == statistics.channel_message_counts
    assert all(sequences == list(range(len(sequences))) for sequences in by_channel.values())
    assert any(isinstance(record, MessageIndex) for record in with_chunks)


@pytest.mark.parametrize("options", OPTIONS, ids=IDS)
def test_readers_by_index_and_from_the_beginning_see_the_same(tmp_path: Path, options: WriteOptions) -> None:
    path = _write(tmp_path / "x.mcap", options)
    seen = []
    for reader in (SeekingReader, NonSeekingReader):
        with path.open("rb") as file:
            found = reader(file, validate_crcs=True).iter_messages()
            seen.append([(channel.topic, message.log_time, message.data) for _, channel, message in found])
    assert sorted(seen[0]) == sorted(seen[1])
    with_recording = McapRecording(path)
    ours = [
        (one.channel.topic, one.log_time, bytes(one.data))
        for one in with_recording.messages(with_recording.channels)
    ]
    assert ours == seen[1]


def test_the_order_of_messages_at_equal_stamps(tmp_path: Path) -> None:
    path = _write(tmp_path / "x.mcap")
    with path.open("rb") as file:
        records = list(StreamReader(file, validate_crcs=True).records)
    topics = {record.id: record.topic for record in records if isinstance(record, Channel)}
    found = [
        (record.log_time, topics[record.channel_id]) for record in records if isinstance(record, Message)
    ]
    assert [time for time, _ in found] == sorted(time for time, _ in found)
    assert [topic for time, topic in found if time == START] == [
        "/camera/rgb/camera_info",
        "/camera/rgb/image_color/compressed",
        "/camera/depth/camera_info",
        "/camera/depth/image",
        "/camera/ir/camera_info",
        "/camera/ir/image_raw/compressed",
        "/imu",
        "/tf",
        "/groundtruth/pose",
    ]


def test_the_index_finds_metadata_and_every_message(tmp_path: Path) -> None:
    path = _write(tmp_path / "x.mcap")
    with path.open("rb") as file:
        reader = SeekingReader(file, validate_crcs=True)
        metadata, digest = reader.iter_metadata()
        summary = reader.get_summary()
        header = reader.get_header()
    assert header.profile == "ros2"
    assert metadata.name == "tumtools"
    assert metadata.metadata["name"] == "memory"
    assert digest.name == "tumtools.digest"
    assert json.loads(metadata.metadata["streams"])["depth"] == "/camera/depth/image"
    assert summary is not None
    assert summary.statistics is not None
    assert all(schema.encoding == "ros2msg" for schema in summary.schemas.values())
    assert all(channel.message_encoding == "cdr" for channel in summary.channels.values())
    data = path.read_bytes()
    for index in summary.chunk_indexes:
        for channel, offset in index.message_index_offsets.items():
            assert data[offset] == 7
            assert int.from_bytes(data[offset + 9 : offset + 11], "little") == channel


def test_pngs_are_kept_in_chunks_that_are_not_compressed_again(tmp_path: Path) -> None:
    with _write(tmp_path / "x.mcap").open("rb") as file:
        summary = SeekingReader(file).get_summary()
        assert summary is not None
        numbers = {channel.topic: number for number, channel in summary.channels.items()}
        for index in summary.chunk_indexes:
            if numbers["/camera/rgb/image_color/compressed"] in index.message_index_offsets:
                assert index.compression == ""
            if numbers["/camera/depth/image"] in index.message_index_offsets:
                assert index.compression == "zstd"


@pytest.mark.parametrize("stamp", [-1, 2**31 * SECOND])
@pytest.mark.parametrize("stream", ["rgb", "accelerometer", "groundtruth"])
def test_stamps_that_no_message_can_hold_are_refused(tmp_path: Path, stream: str, stamp: int) -> None:
    sequence = Memory(
        {"rgb": [stamp if stream == "rgb" else START]},
        accelerometer=accelerometer(stamp if stream == "accelerometer" else START),
        groundtruth=groundtruth(stamp if stream == "groundtruth" else START),
    )
    with pytest.raises(OutputError, match=f"of {stream} .row 0. does not fit"):
        convert(sequence, tmp_path / "x.mcap", "mcap")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("stamp", [0, 2**31 * SECOND - 1])
def test_the_first_and_the_last_stamp_that_fit(tmp_path: Path, stamp: int) -> None:
    sequence = Memory({"rgb": [stamp]}, accelerometer=accelerometer(stamp), groundtruth=groundtruth(stamp))
    report = convert(sequence, tmp_path / "x.mcap", "mcap")
    assert report.verified


def test_streams_without_rows_are_still_streams(tmp_path: Path) -> None:
    sequence = Memory({"rgb": [], "depth": []}, accelerometer=accelerometer(), groundtruth=groundtruth())
    path = _write(tmp_path / "x.mcap", sequence=sequence)
    with path.open("rb") as file:
        summary = SeekingReader(file, validate_crcs=True).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.message_count == 0
    assert {channel.topic for channel in summary.channels.values()} >= {"/imu", "/tf", "/camera/depth/image"}


def test_messages_larger_than_a_chunk_get_one_of_their_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(chunks, "CHUNK_BYTES", 100)
    path = _write(tmp_path / "x.mcap")
    with path.open("rb") as file:
        reader = SeekingReader(file, validate_crcs=True)
        count = sum(1 for _ in reader.iter_messages())
        summary = reader.get_summary()
    assert summary is not None
    assert count == 3 * 9
    assert len(summary.chunk_indexes) == count


@pytest.mark.parametrize("chunk_bytes", [100, 3000, 20_000, 1 << 20])
@pytest.mark.parametrize("block", [1, 7, 2048])
@pytest.mark.parametrize("images", [True, False])
def test_runs_of_small_messages_are_laid_out_as_single_ones(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, chunk_bytes: int, block: int, images: bool
) -> None:
    monkeypatch.setattr(chunks, "CHUNK_BYTES", chunk_bytes)
    monkeypatch.setattr(chunks, "_BLOCK", block)
    random = np.random.default_rng(block)
    # Unsorted, some before the first image and after the last, and some at the stamp of one.
    stamps = [START] * 20 + (START + random.integers(-SECOND, 2 * SECOND, 200)).tolist()
    times = [START, START + 100, START + SECOND] if images else []
    sequence = Memory(
        {"rgb": times, "depth": times} if images else {},
        accelerometer=accelerometer(*stamps),
        groundtruth=groundtruth(*stamps[10:150]),
    )
    style = make_style("cdr", FORMATS["mcap"], WriteOptions(archive=True, groundtruth="both"))
    out = outgoing(sequence, style)
    packing = Packing("cdr", out.compressed_channels, "zstd")
    write = partial(write_mcap, metadata={}, packing=packing, jobs=1, progress=no_progress)
    write(tmp_path / "single", out.channels, out.messages())
    write(tmp_path / "runs", out.channels, out.images(), rows=out.rows())
    assert (tmp_path / "runs").read_bytes() == (tmp_path / "single").read_bytes()


def test_writes_that_the_system_cuts_short_are_completed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = _write(tmp_path / "whole.mcap").read_bytes()
    writev = os.writev

    def grudging(descriptor: int, parts: list[bytes]) -> int:
        return writev(descriptor, [bytes(parts[0])[:7]])

    monkeypatch.setattr(os, "writev", grudging)
    assert _write(tmp_path / "cut.mcap").read_bytes() == whole


SCRIPT = """
import sys
from pathlib import Path
from tumtools.convert import convert
from tumtools.formats.options import WriteOptions
from tumtools.sources import open_source
with open_source(sys.argv[1]) as sequence:
    convert(sequence, Path(sys.argv[2]), "mcap", WriteOptions(jobs=int(sys.argv[3])))
"""


def test_the_bytes_depend_on_nothing_but_the_sequence(tmp_path: Path) -> None:
    """Hash seed, time zone, number of jobs, folder, and the day."""
    convert(full(), tmp_path / "source", "tum")
    for number, (seed, zone, jobs, folder) in enumerate(
        [("0", "UTC", "1", "a"), ("1", "Asia/Kathmandu", "2", "b"), ("2", "America/Lima", "5", "c/d")]
    ):
        environment = os.environ | {"PYTHONHASHSEED": seed, "TZ": zone}
        target = tmp_path / folder / f"{number}.mcap"
        command = [sys.executable, "-c", SCRIPT, tmp_path / "source", target, jobs]
        subprocess.run(command, check=True, env=environment)
    first, *others = [path.read_bytes() for path in sorted(tmp_path.rglob("*.mcap"))]
    assert len(others) == 2
    assert all(data == first for data in others)


def test_sensor_values_are_exact(tmp_path: Path) -> None:
    """All float64 bits, and all depth values by way of float32 metres."""
    sequence = full()
    path = _write(tmp_path / "x.mcap", sequence=sequence)
    recording = McapRecording(path)
    kind = messages.message_type(messages.IMU, "cdr")
    (channel,) = [channel for channel in recording.channels if channel.topic == "/imu"]
    found = [kind.decode(one.data) for one in recording.messages([channel])]
    values = [[one["linear_acceleration"][axis] for axis in "xyz"] for one in found]  # type: ignore[index]
    assert sequence.accelerometer is not None
    np.testing.assert_array_equal(values, sequence.accelerometer.values)
    for one in found:
        assert one["orientation_covariance"].tolist() == [-1.0] + [0.0] * 8  # type: ignore[attr-defined]
        assert one["angular_velocity_covariance"].tolist() == [-1.0] + [0.0] * 8  # type: ignore[attr-defined]


def test_nothing_is_attached(tmp_path: Path) -> None:
    with _write(tmp_path / "x.mcap").open("rb") as file:
        assert not any(isinstance(record, Attachment) for record in StreamReader(file).records)
