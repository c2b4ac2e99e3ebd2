# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`convert` from Python: what it refuses, what it reports, and that it leaves nothing half done."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from tests.formats.tum.archives import files_of
from tests.made import made
from tests.memory import Memory
from tumtools.convert import ConvertOptions, _merge, convert, default_target, refuse_source
from tumtools.errors import InputError, LossRefusedError, MissingInputError, UsageError
from tumtools.formats.options import WriteOptions
from tumtools.model.sequence import Loss, sum_losses
from tumtools.sources import open_source
from tumtools.transform import Selection

FULL = Path(__file__).parents[1] / "fixtures" / "full"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return shutil.copytree(FULL, tmp_path / "in" / "full")


def test_the_report_counts_what_was_written(tmp_path: Path) -> None:
    with open_source(FULL) as sequence:
        report = convert(sequence, tmp_path / "x.mcap", "mcap")
        signals = [sequence.groundtruth, sequence.accelerometer]
    assert (report.frames, report.rows) == (8, sum(len(signal) for signal in signals if signal))
    assert report.nbytes == (tmp_path / "x.mcap").stat().st_size
    assert (report.losses, report.verified, report.dry_run) == ((), True, False)


def test_progress_is_told_of_each_image(tmp_path: Path) -> None:
    written: list[int] = []
    verified: list[int] = []
    with open_source(FULL) as sequence:
        convert(
            sequence,
            tmp_path / "x.mcap",
            "mcap",
            progress=lambda frames, _: written.append(frames),
            verify_progress=lambda frames, _: verified.append(frames),
        )
    assert sum(written) == sum(verified) == 8


@pytest.mark.parametrize("to", ["tum", "mcap"])
def test_a_dry_run_writes_nothing_and_tells_size_and_losses(folder: Path, tmp_path: Path, to: str) -> None:
    (folder / "notes.md").write_text("hello")
    before = files_of(tmp_path)
    with open_source(folder) as sequence:
        dry = convert(sequence, tmp_path / "out", to, options=ConvertOptions(dry_run=True))
        assert files_of(tmp_path) == before
        real = convert(sequence, tmp_path / "out", to)
    assert dry.dry_run
    assert not dry.verified
    assert dry.losses == real.losses != ()
    assert (dry.frames, dry.rows) == (real.frames, real.rows)
    assert 0.5 < dry.nbytes / real.nbytes < 3


def test_strict_refuses_a_loss_before_anything_is_written(folder: Path, tmp_path: Path) -> None:
    (folder / "notes.md").write_text("hello")
    with open_source(folder) as sequence:
        for dry_run in (False, True):
            options = ConvertOptions(strict=True, dry_run=dry_run)
            with pytest.raises(LossRefusedError, match=r"notes\.md: file not carried over"):
                convert(sequence, tmp_path / "x.mcap", "mcap", options=options)
    assert [path.name for path in tmp_path.iterdir()] == ["in"]


def test_strict_passes_what_is_lossless(tmp_path: Path) -> None:
    with open_source(FULL) as sequence:
        report = convert(sequence, tmp_path / "x.mcap", "mcap", options=ConvertOptions(strict=True))
    assert report.verified


def test_strict_refuses_a_loss_that_shows_only_in_the_pixels(tmp_path: Path) -> None:
    with open_source(FULL) as sequence, pytest.raises(LossRefusedError, match="pixels"):
        convert(
            sequence,
            tmp_path / "x.mcap",
            "mcap",
            WriteOptions(depth_encoding="16UC1"),
            ConvertOptions(strict=True),
        )
    assert list(tmp_path.iterdir()) == []


def test_an_existing_target_is_refused_before_the_work_and_replaced_with_force(tmp_path: Path) -> None:
    target = tmp_path / "x.mcap"
    target.write_text("old")
    with open_source(FULL) as sequence:
        for dry_run in (False, True):
            with pytest.raises(UsageError, match="the target exists"):
                convert(sequence, target, "mcap", options=ConvertOptions(dry_run=dry_run))
        assert target.read_text() == "old"
        convert(sequence, target, "mcap", options=ConvertOptions(force=True))
    assert target.read_bytes().startswith(b"\x89MCAP0")
    assert [path.name for path in tmp_path.iterdir()] == ["x.mcap"]


def test_force_replaces_a_sequence_but_no_other_folder(folder: Path, tmp_path: Path) -> None:
    results = tmp_path / "results"
    results.mkdir()
    (results / "thesis.tex").write_text("years of work")
    force = ConvertOptions(force=True)
    with open_source(FULL) as sequence:
        with pytest.raises(UsageError, match="a folder that holds no sequence") as caught:
            convert(sequence, results, "tum", options=force)
        assert caught.value.path == str(results)
        assert (results / "thesis.tex").exists()
        (results / "thesis.tex").unlink()
        convert(sequence, results, "tum", options=force)
        convert(sequence, folder, "tum", options=force)
    assert files_of(results) == files_of(folder) == files_of(FULL)


def test_files_that_are_not_carried_are_all_counted_once(folder: Path, tmp_path: Path) -> None:
    for name in ("sub/a.txt", "sub/a/1", "sub/a/2", "sub/b.txt", "sub/b/1", "sub/c.txt", "own.md"):
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    counts = [("own.md", 1), ("sub/", 3), ("sub/a/", 2), ("sub/b/", 1)]
    with open_source(folder) as sequence:
        assert [(loss.stream, loss.count) for loss in sequence.info.not_carried] == counts
        report = convert(sequence, tmp_path / "x", "tum")
    assert [(loss.stream, loss.count) for loss in report.losses] == counts


@pytest.mark.parametrize("dry_run", [True, False])
@pytest.mark.parametrize(
    ("selection", "is_part"),
    [
        (Selection(), False),
        (Selection(streams=("rgb", "depth")), False),
        (Selection(every=2), True),
        (Selection(start=0), True),
        (Selection(streams=("depth",), end=2**62), True),
    ],
)
def test_what_is_counted_in_the_whole_source_though_a_part_was_asked_for_is_said_so(
    folder: Path, tmp_path: Path, selection: Selection, is_part: bool, dry_run: bool
) -> None:
    (folder / "notes.md").write_text("hello")
    options = ConvertOptions(selection, dry_run=dry_run)
    with open_source(folder) as sequence:
        (before,) = sequence.info.not_carried
        report = convert(sequence, tmp_path / "x.mcap", "mcap", WriteOptions(depth_encoding="16UC1"), options)
    of_source, of_pixels = report.losses
    assert of_source.why == ("counted in the whole source: " if is_part else "") + before.why
    assert (of_source.stream, of_source.count) == ("notes.md", 1)
    assert "whole source" not in of_pixels.why, "the writer has seen no more than the part"


def test_strict_says_that_what_it_refuses_may_lie_outside_of_the_part(folder: Path, tmp_path: Path) -> None:
    (folder / "notes.md").write_text("hello")
    options = ConvertOptions(Selection(every=2), strict=True)
    with (
        open_source(folder) as sequence,
        pytest.raises(LossRefusedError, match="counted in the whole source"),
    ):
        convert(sequence, tmp_path / "x.mcap", "mcap", options=options)


def test_equal_losses_are_added_and_those_told_twice_are_not() -> None:
    one, worse = Loss("x", "w", 1, "y", 0.1, "m"), Loss("x", "w", 2, "y", 0.5, "m")
    assert sum_losses([one, worse, one]) == (Loss("x", "w", 4, "y", 0.5, "m"),)
    assert _merge((one, one), (sum_losses([one, one])[0],)) == sum_losses([one, one])


@pytest.mark.parametrize("target", ["full", ".", "..", "full/../full", "link"])
def test_a_target_that_is_the_source_or_holds_it_is_refused(folder: Path, target: str) -> None:
    (folder.parent / "link").symlink_to(folder)
    with pytest.raises(UsageError, match=r"is the source|holds the source"):
        refuse_source(folder, folder.parent / target)


def test_a_target_inside_of_the_source_is_all_right(folder: Path) -> None:
    refuse_source(folder, folder / "x.mcap")
    for target, to in (("x.mcap", "mcap"), ("copy", "tum")):
        with open_source(folder) as sequence:
            convert(sequence, folder / target, to)
    with open_source(folder / "copy") as sequence:
        assert len(list(sequence.images())) == 8


def test_a_selection_that_leaves_nothing_is_refused(tmp_path: Path) -> None:
    with open_source(FULL) as sequence, pytest.raises(UsageError, match="nothing of the sequence"):
        convert(sequence, tmp_path / "x", "tum", options=ConvertOptions(Selection(start=2**62)))


@pytest.mark.parametrize("to", ["tum", "mcap", "rosbag1", "rosbag2", "rawlog"])
def test_a_source_without_any_stream_is_refused(tmp_path: Path, to: str) -> None:
    with pytest.raises(InputError, match="nothing to convert"):
        convert(Memory({}), tmp_path / "x", to)
    assert not list(tmp_path.iterdir())


def test_a_part_is_written_with_the_text_of_its_rows(tmp_path: Path) -> None:
    with open_source(FULL) as sequence:
        stamps = sequence.image_stamps("rgb")
        options = ConvertOptions(Selection(("rgb", "depth"), int(stamps[1]), int(stamps[2])))
        convert(sequence, tmp_path / "x", "tum", options=options)
    whole = (FULL / "rgb.txt").read_text().splitlines(keepends=True)
    assert (tmp_path / "x" / "rgb.txt").read_text() == "".join(whole[:3] + whole[4:6])
    assert sorted(path.name for path in (tmp_path / "x").iterdir()) == [
        "depth",
        "depth.txt",
        "rgb",
        "rgb.txt",
    ]


@pytest.mark.parametrize("to", ["tum", "mcap"])
@pytest.mark.parametrize("dry_run", [False, True])
def test_a_missing_image_stops_it_and_nothing_is_left(
    folder: Path, tmp_path: Path, to: str, dry_run: bool
) -> None:
    gone = max((folder / "depth").iterdir())
    gone.unlink()
    with open_source(folder) as sequence, pytest.raises(MissingInputError, match=f"depth/{gone.name}"):
        convert(sequence, tmp_path / "x", to, options=ConvertOptions(dry_run=dry_run))
    assert [path.name for path in tmp_path.iterdir()] == ["in"]


@pytest.mark.parametrize("to", ["tum", "mcap"])
@pytest.mark.parametrize("jobs", [1, 4])
def test_a_damaged_image_stops_it_and_is_named(folder: Path, tmp_path: Path, to: str, jobs: int) -> None:
    path = sorted((folder / "rgb").iterdir())[2]
    data = bytearray(path.read_bytes())
    data[100] ^= 4
    path.write_bytes(data)
    with open_source(folder) as sequence, pytest.raises(InputError, match="CRC") as caught:
        convert(sequence, tmp_path / "x", to, WriteOptions(jobs=jobs))
    assert caught.value.path == str(path)
    assert [path.name for path in tmp_path.iterdir()] == ["in"]


def test_the_first_of_two_damaged_images_is_named_with_any_number_of_threads(
    folder: Path, tmp_path: Path
) -> None:
    for path in sorted((folder / "rgb").iterdir())[1:3]:
        path.write_bytes(path.read_bytes()[:200])
    for jobs in (1, 2, 8):
        with open_source(folder) as sequence, pytest.raises(InputError) as caught:
            convert(sequence, tmp_path / "x", "mcap", WriteOptions(jobs=jobs))
        assert caught.value.path == str(sorted((folder / "rgb").iterdir())[1])


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (WriteOptions(dialect="modern"), "--dialect has no meaning for mcap"),
        (WriteOptions(archive=True, color_encoding="bgr8"), "--archive keeps PNG files, --color-encoding"),
        (WriteOptions(archive=True, depth_encoding="16UC1"), "--archive keeps PNG files, --depth-encoding"),
        (WriteOptions(color_encoding="yuv"), "--color-encoding yuv is not possible for mcap"),
    ],
)
def test_options_of_other_formats_are_refused(tmp_path: Path, options: WriteOptions, said: str) -> None:
    with open_source(FULL) as sequence, pytest.raises(UsageError, match=said):
        convert(sequence, tmp_path / "x", "mcap", options)


@pytest.mark.parametrize(
    ("name", "to", "hint"),
    [
        ("x.zip", "tum", "ends with .tgz or .tar.gz, or a name without such a suffix, for a folder"),
        ("x.tar", "tum", "ends with .tgz or .tar.gz, or a name without such a suffix, for a folder"),
        ("x.tar.zst", "tum", "ends with .tgz or .tar.gz, or a name without such a suffix, for a folder"),
        ("q.TGZ", "tum", "ends with .tgz or .tar.gz, or a name without such a suffix, for a folder"),
        ("w.bag", "mcap", "give a name that ends with .mcap$"),
        ("w.mcap", "rosbag1", "give a name that ends with .bag$"),
        ("w.db3", "rosbag2", "give a name without such a suffix, for a folder$"),
        ("w.tgz", "rawlog", "give a name without such a suffix, for a folder$"),
    ],
)
def test_a_suffix_that_promises_another_container_is_refused(
    tmp_path: Path, name: str, to: str, hint: str
) -> None:
    with (
        open_source(FULL) as sequence,
        pytest.raises(UsageError, match=f"{to} is not written to a target that ends with") as caught,
    ):
        convert(sequence, tmp_path / name, to)
    assert re.search(hint, str(caught.value.hint))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "to"),
    [("x", "mcap"), ("x.MCAP", "mcap"), ("x.v1.0", "tum"), ("x.rawlog", "rawlog"), ("x", "rosbag1")],
)
def test_other_names_of_the_target_are_free(tmp_path: Path, name: str, to: str) -> None:
    with open_source(FULL) as sequence:
        convert(sequence, tmp_path / name, to)
    open_source(tmp_path / name).close()


def test_an_unknown_format_is_refused_with_those_there_are(tmp_path: Path) -> None:
    with open_source(FULL) as sequence, pytest.raises(UsageError, match="no format 'bag'") as caught:
        convert(sequence, tmp_path / "x", "bag")
    assert "mcap" in str(caught.value.hint)


def test_empty_streams_stay_there(tmp_path: Path) -> None:
    sequence = made(rgb=[], depth=[], accelerometer=[], groundtruth=[])
    for target, to in (("x", "tum"), ("x.mcap", "mcap")):
        convert(sequence, tmp_path / target, to)
        with open_source(tmp_path / target) as again:
            assert list(again.info.images) == ["rgb", "depth"]
            assert again.accelerometer is not None
            assert again.groundtruth is not None


@pytest.mark.parametrize(
    ("source", "is_folder", "to", "target"),
    [
        ("seq", True, "mcap", "seq.mcap"),
        ("seq.tgz", False, "mcap", "seq.mcap"),
        ("seq.tar.zst", False, "mcap", "seq.mcap"),
        ("seq.mcap", False, "mcap", "seq_mcap.mcap"),
        ("seq.mcap", True, "mcap", "seq.mcap.mcap"),
        ("seq.tgz", False, "tum", "seq"),
        ("seq", True, "tum", "seq_tum"),
        ("a.b", True, "mcap", "a.b.mcap"),
    ],
)
def test_the_target_is_named_after_the_source(
    tmp_path: Path, source: str, is_folder: bool, to: str, target: str
) -> None:
    path = tmp_path / source
    path.mkdir() if is_folder else path.touch()
    assert default_target(path, to) == tmp_path / target


@pytest.mark.real
def test_the_incomplete_sequence_names_its_first_missing_file(real_data: Path, tmp_path: Path) -> None:
    source = real_data / "malformed" / "incomplete"
    with open_source(source) as sequence:
        assert sequence.info.warnings
        with pytest.raises(MissingInputError, match="there is no image") as caught:
            convert(sequence, tmp_path / "x.mcap", "mcap")
    assert "line" in str(caught.value.location)
    assert list(tmp_path.iterdir()) == []
