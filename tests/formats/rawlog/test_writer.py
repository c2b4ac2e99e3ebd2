# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What is written is read back the same, in each dialect; what a dialect cannot hold is said."""

from __future__ import annotations

import errno
import shutil
import threading
import time
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.formats.rawlog import made
from tests.formats.rawlog.made import FIRST, FRAME_NS, Made, names_of, opened, written
from tumtools.convert import ConvertOptions, convert
from tumtools.digest import digest
from tumtools.errors import LossRefusedError, OutputError, UsageError
from tumtools.formats.options import ReadOptions, WriteOptions, no_progress
from tumtools.formats.rawlog import store, writer
from tumtools.formats.rawlog.archive import Record
from tumtools.formats.rawlog.objects import Objects
from tumtools.formats.tum import reader as tum_reader
from tumtools.images.codec import image_of_jpeg, image_of_pixels, pixels_of
from tumtools.model.camera import CameraInfo, calibration
from tumtools.model.text import TextLayout
from tumtools.model.time import format_stamp
from tumtools.sources import open_source

if TYPE_CHECKING:
    from pathlib import Path

    from tumtools.model.image import Image
    from tumtools.model.sequence import Sequence

LOSSLESS = [
    ("modern", "gzip"),
    ("modern", "zstd"),
    ("modern", "none"),
    ("legacy", "gzip"),
    ("legacy", "none"),
]


def _images(sequence: Sequence) -> dict[tuple[str, int], bytes]:
    return {(f.stream, f.row): pixels_of(f.load()).tobytes() for f in sequence.images()}


@pytest.mark.parametrize("fails", ["image file", "rawlog"])
def test_on_a_full_disk_no_thread_goes_on_writing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fails: str
) -> None:
    full = OSError(errno.ENOSPC, "No space left on device")
    lock, is_late = threading.Lock(), threading.Event()
    encode = store.png_of

    def png_of(image: Image) -> bytes | memoryview:
        if lock.acquire(blocking=False):  # the first image, and no other
            is_late.wait(10)
            if fails == "image file":
                raise full
        else:
            is_late.set()
            time.sleep(0.3)  # still at work when the first one fails
        return encode(image)

    def add(self: object, stored: object) -> None:
        raise full

    monkeypatch.setattr(store, "png_of", png_of)
    if fails == "rawlog":
        monkeypatch.setattr(writer._ScanWriter, "add", add)
    with pytest.raises(OutputError, match="No space left"):
        convert(made.typical(), tmp_path / "x", "rawlog", WriteOptions(jobs=4))
    assert [thread.name for thread in threading.enumerate() if thread.name.startswith("tumtools")] == []
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("dialect", "compression"), LOSSLESS)
def test_everything_comes_back(dialect: str, compression: str, tmp_path: Path) -> None:
    source = made.typical()
    path = written(source, tmp_path, dialect=dialect, compression=compression)
    assert sorted(file.name for file in path.parent.iterdir()) == [
        "groundtruth.txt",
        "made.rawlog",
        "made_Images",
    ]
    with opened(path) as sequence:
        assert digest(sequence).value == digest(source).value
        assert sequence.info.images["depth"].depth_units_per_metre == 5000
        assert sequence.info.not_carried == sequence.info.warnings == ()
        colour = {f.row: bytes(f.load().png or b"") for f in sequence.images(["rgb"])}
        assert colour == {f.row: bytes(f.load().png or b"") for f in source.images(["rgb"])}


STAMPS = st.lists(st.integers(FIRST - 10**8, FIRST + 10**8), max_size=6)


@settings(deadline=None, max_examples=40)
@given(rgb=STAMPS, depth=STAMPS, ir=STAMPS, rows=STAMPS, dialect=st.sampled_from(["modern", "legacy"]))
def test_any_stamps_in_any_order_come_back_to_the_nanosecond(
    tmp_path_factory: pytest.TempPathFactory,
    rgb: list[int],
    depth: list[int],
    ir: list[int],
    rows: list[int],
    dialect: str,
) -> None:
    source = Made(
        {
            "rgb": [(stamp, made.colour(row)) for row, stamp in enumerate(rgb)],
            "depth": [(stamp, made.depth(row)) for row, stamp in enumerate(depth)],
            "ir": [(stamp, made.colour(row + 100)) for row, stamp in enumerate(ir)],
        },
        made.accelerometer(rows),
    )
    folder = tmp_path_factory.mktemp("any")
    with opened(written(source, folder, dialect=dialect)) as sequence:
        assert names_of(sequence) == names_of(source)
        assert _images(sequence) == _images(source)
        assert sequence.accelerometer is not None
        assert sequence.accelerometer.stamps.tolist() == rows
        np.testing.assert_array_equal(sequence.accelerometer.values, made.accelerometer(rows).values)
    shutil.rmtree(folder)


def test_empty_streams_are_told_from_absent_ones(tmp_path: Path) -> None:
    with opened(written(Made({"rgb": []}, made.accelerometer([])), tmp_path)) as sequence:
        assert list(sequence.info.images) == ["rgb"]
        assert sequence.accelerometer is not None
        assert sequence.groundtruth is None


def test_the_same_input_gives_the_same_bytes_whatever_the_number_of_jobs(tmp_path: Path) -> None:
    files = []
    for jobs in (1, 2, 5):
        folder = written(made.typical(10), tmp_path / str(jobs), jobs=jobs).parent
        files.append({str(f.relative_to(folder)): f.read_bytes() for f in folder.rglob("*") if f.is_file()})
    assert files[0] == files[1] == files[2]
    assert len(files[0]) == 22


def test_text_layouts_frame_ids_and_names_travel_along(tmp_path: Path) -> None:
    literal = "# why\n" + format_stamp(FIRST + made.FRAME_NS) + "\t rgb/other.png"
    layout = TextLayout("# my head\n", 7, "%.3f", "\t", "\r\n", {1: literal}, "# tail\n", final_newline=False)
    source = made.typical()
    source.info = replace(
        source.info,
        camera="fr2",
        licence="CC BY 4.0",
        citation="Somebody",
        text={"rgb": layout, "accelerometer": TextLayout(value_format="%r")},
        frame_ids={"rgb": "openni_rgb_optical_frame"},
    )
    with opened(written(source, tmp_path)) as sequence:
        info = sequence.info
        assert (info.name, info.camera, info.licence, info.citation) == (
            "made",
            "fr2",
            "CC BY 4.0",
            "Somebody",
        )
        assert info.text["rgb"] == layout
        assert info.text["accelerometer"] == TextLayout(value_format="%r")
        assert info.frame_ids == {"rgb": "openni_rgb_optical_frame"}
        assert next(sequence.images(["rgb"])).frame_id == "openni_rgb_optical_frame"


def test_own_intrinsics_come_back_whole_and_defaults_are_not_taken_for_them(tmp_path: Path) -> None:
    source = made.typical()
    with opened(written(source, tmp_path / "a")) as sequence:
        assert sequence.cameras == {}
    own = CameraInfo(8, 6, (7.0,) * 9, (0.1,) * 4, (2.0,) * 9, (3.0,) * 12, "equidistant")
    source.cameras = {"rgb": own}
    with opened(written(source, tmp_path / "b")) as sequence:
        assert sequence.cameras == {"rgb": own}
    with opened(written(source, tmp_path / "c", camera="fr1")) as sequence:
        assert (sequence.info.camera, sequence.cameras) == ("fr1", {})


@pytest.mark.parametrize("dialect", ["modern", "legacy", "converter"])
@pytest.mark.parametrize("camera", ["fr1", None])
def test_intrinsics_that_follow_from_the_camera_are_none_of_its_own_as_in_mcap(
    dialect: str, camera: str | None, tmp_path: Path
) -> None:
    """What a conversion loses would otherwise hang on the way that it took."""
    source = made.typical()
    source.info = replace(source.info, camera=camera)
    source.cameras = {"rgb": calibration(camera or "ros-default", "rgb", 8, 6)}
    path = written(source, tmp_path, dialect=dialect)
    if dialect == "converter":  # its one calibration is for images of 640x480
        source.cameras = {
            "rgb": calibration("ros-default", "rgb"),
            "depth": calibration("ros-default", "rgb"),
        }
    else:
        source.cameras = {}
    with opened(path) as sequence:
        assert sequence.cameras == source.cameras
        convert(sequence, tmp_path / "x.mcap", "mcap", WriteOptions(archive=True))
    with open_source(tmp_path / "x.mcap") as sequence:
        assert sequence.cameras == source.cameras


@pytest.mark.parametrize("dialect", ["modern", "legacy", "converter"])
@pytest.mark.parametrize("dry_run", [False, True])
def test_the_report_counts_what_the_target_holds(dialect: str, dry_run: bool, tmp_path: Path) -> None:
    """The dialect `converter` drops a colour image here, stores a depth image twice, and few rows."""
    source = made.typical()
    depths, target = source._images["depth"], tmp_path / "made"
    source._images["depth"] = [(FIRST + FRAME_NS // 2, depths[0][1])]
    source.info.images["depth"] = replace(source.info.images["depth"], count=1)
    options = WriteOptions(dialect=dialect)
    report = convert(source, target, "rawlog", options, ConvertOptions(dry_run=dry_run))
    convert(source, target, "rawlog", options, ConvertOptions(force=True))
    with opened(target) as sequence:
        signals = [sequence.groundtruth, sequence.accelerometer]
        assert report.frames == len(list(sequence.images())) == 4
        assert report.rows == sum(len(signal) for signal in signals if signal is not None)


@pytest.mark.parametrize("to", ["rawlog", "mcap", "rosbag1", "rosbag2"])
def test_intrinsics_that_are_no_numbers_are_kept_where_they_can_be(to: str, tmp_path: Path) -> None:
    source = made.typical()
    source.cameras = {"rgb": replace(calibration("fr1", "rgb"), d=(float("nan"),) * 5)}
    target = tmp_path / {"mcap": "out.mcap", "rosbag1": "out.bag"}.get(to, "out")
    assert convert(source, target, to).verified


def test_depth_in_other_units_is_kept_as_it_is(tmp_path: Path) -> None:
    source = Made({"depth": [(FIRST, made.depth(units=1000.0))]})
    for dialect in ("modern", "legacy"):
        with opened(written(source, tmp_path / dialect, dialect=dialect)) as sequence:
            image = next(sequence.images()).load()
            assert image.depth_units_per_metre == 1000
            assert _images(sequence) == _images(source)


def test_float_depth_is_kept_where_it_is_exact_and_its_rounding_is_told(tmp_path: Path) -> None:
    counts = pixels_of(made.depth())
    exact = np.where(counts == 0, np.nan, counts / 5000).astype(np.float32)
    between = exact.copy()
    between[1, 1] = 1.00005
    for metres, changed in ((exact, 0), (between, 1)):
        source = Made({"depth": [(FIRST, image_of_pixels(metres, "32FC1", 1.0))]})
        losses = writer.write(source, tmp_path / f"m{changed}", WriteOptions(), no_progress)
        assert [(loss.what, loss.count) for loss in losses] == [("depth rounded to 1/5000 m", 1)] * changed
        assert all(loss.largest_error == pytest.approx(5e-5, rel=0.01) for loss in losses)
        options = WriteOptions(dialect="legacy")
        assert writer.write(source, tmp_path / f"l{changed}", options, no_progress) == ()
        with opened(tmp_path / f"l{changed}") as sequence:
            np.testing.assert_array_equal(pixels_of(next(sequence.images()).load()), metres)


def test_jpeg_and_raw_pixels(tmp_path: Path) -> None:
    import io

    from PIL import Image as PillowImage

    out = io.BytesIO()
    pixels = pixels_of(made.colour()).astype(np.uint8)
    PillowImage.fromarray(pixels).save(out, "JPEG")
    jpeg = image_of_jpeg(out.getvalue())
    raw = image_of_pixels(pixels, "bgr8")
    path = written(Made({"rgb": [(FIRST, jpeg), (FIRST + FRAME_NS, raw)]}), tmp_path)
    with opened(path) as sequence:
        first, second = (frame.load() for frame in sequence.images())
    assert first.compressed == out.getvalue()
    np.testing.assert_array_equal(pixels_of(second), pixels[:, :, ::-1])


def test_objects_are_ordered_by_time_after_the_comment(tmp_path: Path) -> None:
    records = list(Objects(written(made.typical(), tmp_path)))
    assert records[0].type == "CObservationComment"
    times = [record.integer("time") for record in records]
    assert times == sorted(times)
    assert [record.version for record in records if record.type == "CObservation3DRangeScan"] == [10] * 3


def test_a_rawlog_that_was_cut_since_is_read_with_a_warning(tmp_path: Path) -> None:
    source = made.typical()
    source.info = replace(source.info, text={"rgb": TextLayout(overrides={2: "literal"})})
    path = written(source, tmp_path, compression="none")
    records = list(Objects(path))
    made.save(path, *(r for r in records if r.integer("time") < records[-1].integer("time") - 600_000))
    with opened(path) as sequence:
        assert sequence.info.images["rgb"].count < 3
        assert sequence.info.text["rgb"].overrides == {}
        assert any("rows of rgb are there" in text for text in sequence.info.warnings)


@pytest.mark.parametrize("is_known", [True, False])
def test_a_legacy_rawlog_has_one_calibration_whatever_lacks_a_partner(is_known: bool, tmp_path: Path) -> None:
    images = made.typical()._images
    source = made.Made({"rgb": images["rgb"], "depth": images["depth"][1:2]}, camera="fr1")
    path = written(source, tmp_path, dialect="legacy", compression="none")
    records = list(Objects(path))
    assert [record.integer("has_range") for record in records[1:]] == [0, 1, 0]
    if not is_known:  # what somebody else wrote
        made.save(path, *records[1:])
    with opened(path) as sequence:
        assert (sequence.info.camera == "fr1") == is_known
        assert (sequence.info.not_carried, sequence.info.warnings) == ((), ())
        if not is_known:
            assert sequence.cameras["rgb"] == calibration("fr1", "rgb", 8, 6)


def test_images_of_several_sizes_have_calibrations_of_their_own_that_are_no_change(tmp_path: Path) -> None:
    images = [(FIRST, made.colour(0)), (FIRST + FRAME_NS, made.colour(1, 16, 12))]
    with opened(written(made.Made({"rgb": images}, camera="fr1"), tmp_path)) as sequence:
        assert (sequence.info.not_carried, sequence.info.warnings) == ((), ())


def test_a_salvage_tells_how_many_rows_of_each_stream_it_leaves_out(tmp_path: Path) -> None:
    source = made.typical()
    path = written(source, tmp_path, compression="none")
    data = path.read_bytes()
    with opened(path, salvage=True) as sequence:
        assert (sequence.info.not_carried, sequence.info.warnings) == ((), ())
    assert source.accelerometer is not None
    for share in (0.3, 0.6, 0.9):
        path.write_bytes(data[: int(share * len(data))])
        with opened(path, salvage=True) as sequence:
            told = {loss.stream: loss.count for loss in sequence.info.not_carried}
            found = {stream: len(sequence.image_stamps(stream)) for stream in ("rgb", "depth")}
            found["accelerometer"] = 0 if sequence.accelerometer is None else len(sequence.accelerometer)
        whole = {"rgb": 3, "depth": 3, "accelerometer": len(source.accelerometer)}
        assert told == {name: whole[name] - found[name] for name in whole if whole[name] > found[name]}
        assert told
        with opened(path, salvage=True) as sequence, pytest.raises(LossRefusedError):
            convert(sequence, tmp_path / "y", "tum", options=ConvertOptions(strict=True))


def test_a_comment_of_others_beside_ours_is_told_and_does_no_harm(tmp_path: Path) -> None:
    path = written(made.typical(), tmp_path, compression="none")
    note = Record("CObservationComment", 0, {"text": "rain", "time": made.TICKS})
    records = list(Objects(path))
    made.save(path, note, *records, note)
    with opened(path) as sequence:
        assert sequence.info.name == "made"
        assert [(loss.stream, loss.what, loss.count) for loss in sequence.info.not_carried] == [
            ("comment", "comment text", 2)
        ]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"dialect": "old"}, "modern, legacy, converter"),
        ({"compression": "lz4"}, "gzip, zstd, none"),
        ({"dialect": "legacy", "compression": "zstd"}, "only MRPT 3"),
    ],
)
def test_options_without_a_meaning_are_refused(options: dict[str, str], message: str, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=message):
        writer.write(made.typical(), tmp_path / "x", WriteOptions(**options), no_progress)
    assert not (tmp_path / "x").exists()


def test_the_plan_tells_the_losses_and_a_size_without_writing(tmp_path: Path) -> None:
    plan = writer.plan(made.typical(), tmp_path / "x", WriteOptions())
    assert plan.losses == ()
    assert plan.nbytes > 0
    assert "the camera is unknown" in plan.warnings[0]
    assert writer.plan(made.typical(), tmp_path / "x", WriteOptions(camera="fr1")).warnings == ()
    losses = writer.plan(made.typical(), tmp_path / "x", WriteOptions(dialect="converter")).losses
    assert {loss.what for loss in losses} >= {"stamps replaced", "rows dropped"}


def test_the_converter_dialect_through_a_conversion(tmp_path: Path) -> None:
    report = convert(made.typical(), tmp_path / "made", "rawlog", WriteOptions(dialect="converter"))
    rounded = {loss.what: loss for loss in report.losses}["pixels rounded"]
    assert rounded.largest_error == pytest.approx(0.0004)
    with opened(tmp_path / "made") as sequence:
        # Depth is in millimetres and right, which that program's is not.
        found = pixels_of(next(sequence.images(["depth"])).load())
        np.testing.assert_array_equal(found, np.rint(pixels_of(made.depth()) / 5))
        assert sequence.image_stamps("rgb")[0] == FIRST + 18_000
        assert sequence.groundtruth is not None


# --- real data ----------------------------------------------------------------------------------------

RPY = "rgbd_dataset_freiburg1_rpy"


@pytest.mark.real
def test_fr1_rpy_to_rawlog_and_back(real_data: Path, tmp_path: Path) -> None:
    with open_source(real_data / RPY) as source:
        report = convert(source, tmp_path / "there" / RPY, "rawlog")
        assert report.losses == ()
        assert report.verified
    with open_source(tmp_path / "there" / RPY) as rawlog:
        convert(rawlog, tmp_path / "back" / RPY, "tum")
    for path in sorted(path for path in (real_data / RPY).rglob("*") if path.is_file()):
        name = path.relative_to(real_data)
        if name.parts[1] != "depth":
            assert (tmp_path / "back" / name).read_bytes() == path.read_bytes(), name
    streams = [digest(open_source(folder / RPY)) for folder in (real_data, tmp_path / "back")]
    assert streams[0].value == streams[1].value


@pytest.fixture
def first_twelve(real_data: Path, tmp_path: Path) -> Path:
    """The first twelve rows of rgb.txt and depth.txt, with the files they name."""
    folder = tmp_path / "twelve"
    for stream in ("rgb", "depth"):
        (folder / stream).mkdir(parents=True)
        lines = (real_data / RPY / f"{stream}.txt").read_text().splitlines(keepends=True)[:15]
        (folder / f"{stream}.txt").write_text("".join(lines))
        for line in lines[3:]:
            name = line.split()[1]
            (folder / name).write_bytes((real_data / RPY / name).read_bytes())
    (folder / "accelerometer.txt").write_bytes((real_data / RPY / "accelerometer.txt").read_bytes())
    return folder


@pytest.mark.real
def test_the_converter_dialect_is_byte_for_byte_what_mrpt_wrote(
    first_twelve: Path, real_data: Path, tmp_path: Path
) -> None:
    source = tum_reader.open(first_twelve, ReadOptions())
    convert(source, tmp_path / "ref", "rawlog", WriteOptions(dialect="converter"))
    reference = real_data / "rawlog" / "converter_output"
    assert (tmp_path / "ref" / "ref.rawlog").read_bytes() == (reference / "ref.rawlog").read_bytes()
    names = [
        sorted(f.name for f in (folder / "ref_Images").iterdir()) for folder in (reference, tmp_path / "ref")
    ]
    assert names[0] == names[1]


@pytest.mark.real
def test_the_legacy_dialect_has_the_depth_files_of_old_readers(
    first_twelve: Path, real_data: Path, tmp_path: Path
) -> None:
    source = tum_reader.open(first_twelve, ReadOptions())
    writer.write(source, tmp_path / "new", WriteOptions(dialect="legacy"), no_progress)
    with opened(real_data / "rawlog" / "legacy6.rawlog") as old, opened(tmp_path / "new") as new:
        for one, other in zip(old.images(["depth"]), new.images(["depth"]), strict=False):
            metres = pixels_of(one.load())
            counts = pixels_of(other.load())
            np.testing.assert_array_equal(np.nan_to_num(metres), (counts / 5000).astype(np.float32))
