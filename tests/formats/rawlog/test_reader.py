# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Rawlogs of other people become sequences; what they hold besides is listed."""

from __future__ import annotations

import gzip
import os
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from tests.formats.rawlog import made
from tests.formats.rawlog.made import TICKS, image_record, imu, names_of, opened, save, scan, with_depth
from tumtools.convert import convert
from tumtools.errors import InputError, MissingInputError, UnsupportedInputError, UsageError
from tumtools.formats.rawlog import archive, embedded, reader
from tumtools.formats.rawlog import survey as survey_module
from tumtools.formats.rawlog.archive import Record
from tumtools.formats.rawlog.classes import CODEC
from tumtools.formats.rawlog.observations import imu_of
from tumtools.formats.rawlog.survey import survey
from tumtools.images.codec import pixels_of
from tumtools.model.text import TextLayout
from tumtools.model.time import format_stamp, ticks_to_stamp
from tumtools.sources import open_source
from tumtools.validate.engine import validate

if TYPE_CHECKING:
    from pathlib import Path

STAMP = ticks_to_stamp(TICKS)
FRAME_TICKS = 333_333
PIXELS = np.arange(144, dtype=np.uint8).reshape(6, 8, 3)
COUNTS = np.arange(48, dtype="<u2").reshape(6, 8)


def _comment(text: str) -> Record:
    return Record("CObservationComment", 0, {"text": text, "time": TICKS})


def test_a_scan_gives_depth_and_colour_at_its_time(tmp_path: Path) -> None:
    colour = {"has_intensity": 1, "intensity": image_record(PIXELS)}
    path = save(tmp_path / "a.rawlog", scan(**with_depth(COUNTS), **colour))
    with opened(path) as sequence:
        assert names_of(sequence) == {"rgb": [(STAMP, 0)], "depth": [(STAMP, 0)]}
        images = {frame.stream: frame.load() for frame in sequence.images()}
        assert sequence.info.name == "a"
        assert sequence.info.images["depth"].depth_units_per_metre == 1000
        assert sequence.info.images["rgb"].source == "CAM"
        assert sequence.cameras["rgb"].k[:6] == (7.0, 0.0, 3.5, 0.0, 7.5, 2.5)
    np.testing.assert_array_equal(pixels_of(images["depth"]), COUNTS)
    np.testing.assert_array_equal(pixels_of(images["rgb"]), PIXELS)


def test_a_camera_image_is_colour(tmp_path: Path) -> None:
    image = {"image": image_record(PIXELS), "camera": made.camera(), "sensor_pose": made.pose()}
    record = Record("mrpt::obs::CObservationImage", 4, {**image, "time": TICKS, "label": "CAM"})
    with opened(save(tmp_path / "a.rawlog", record)) as sequence:
        assert names_of(sequence) == {"rgb": [(STAMP, 0)]}


def test_images_inside_of_sensory_frames_are_found(tmp_path: Path) -> None:
    frame = Record("CSensoryFrame", 2, {"objects": [imu(), scan(**with_depth(COUNTS))]})
    actions = Record("CActionCollection", 0, {"objects": []})
    with opened(save(tmp_path / "a.rawlog", actions, frame)) as sequence:
        assert names_of(sequence) == {"depth": [(STAMP, 0)]}
        assert sequence.accelerometer is not None
        assert sequence.accelerometer.stamps.tolist() == [STAMP]


def test_a_file_that_is_one_object_is_streamed_like_any_other(tmp_path: Path) -> None:
    whole = Record("CRawlog", 1, {"objects": [imu(), imu(TICKS + 10)], "comment": _comment("by hand")})
    with opened(save(tmp_path / "a.rawlog", whole)) as sequence:
        assert sequence.accelerometer is not None
        assert len(sequence.accelerometer) == 2
    assert survey(tmp_path / "a.rawlog").comments == ["by hand"]


def test_embedded_images_in_any_order_come_in_time_order(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    order = [3, 1, 4, 0, 2]
    scans = [scan(TICKS + FRAME_TICKS * number, **with_depth(COUNTS + number)) for number in order]
    path = save(tmp_path / "a.rawlog", *scans)
    expected = [(ticks_to_stamp(TICKS + FRAME_TICKS * number), order.index(number)) for number in range(5)]
    for held in (2**20, 0):  # kept until their turn, or read again from the beginning
        monkeypatch.setattr(embedded, "_HELD_BYTES", held)
        with opened(path) as sequence:
            frames = list(sequence.images())
            assert [(frame.stamp, frame.row) for frame in frames] == expected
            for number, frame in enumerate(frames):
                np.testing.assert_array_equal(pixels_of(frame.load()), COUNTS + number)
                np.testing.assert_array_equal(pixels_of(frame.load()), COUNTS + number)


@pytest.mark.parametrize("order", ["forward", "backward", "shuffled"])
def test_there_are_no_more_passes_through_the_file_than_images_can_be_held(
    order: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    numbers = list(range(40))
    if order == "shuffled":
        np.random.default_rng(0).shuffle(numbers)
    colour = {"has_intensity": 1, "intensity": image_record(PIXELS)}
    scans = [
        scan(TICKS + FRAME_TICKS * number, **with_depth(COUNTS + number), **colour) for number in numbers
    ]
    path = save(tmp_path / "a.rawlog", *(scans[::-1] if order == "backward" else scans))
    passes = []
    monkeypatch.setattr(embedded, "_HELD_BYTES", 10 * (COUNTS.nbytes + PIXELS.nbytes))
    original = embedded.pictures_in
    monkeypatch.setattr(embedded, "pictures_in", lambda found: passes.append(1) or original(found))
    with opened(path) as sequence:
        for number, frame in enumerate(sequence.images(["depth"])):
            np.testing.assert_array_equal(pixels_of(frame.load()), COUNTS + number)
        assert len(passes) <= (1 if order == "forward" else 3)
        passes.clear()
        assert sum(1 for _ in sequence.images()) == 80
        assert len(passes) <= (1 if order == "forward" else 6)


def test_the_first_image_need_not_be_held_to_be_described(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(survey_module, "_HELD_BYTES", 1)
    with opened(save(tmp_path / "a.rawlog", imu(), scan(**with_depth(COUNTS)))) as sequence:
        assert (sequence.info.images["depth"].width, sequence.info.images["depth"].encoding) == (8, "16UC1")


def test_a_choice_of_times_reads_only_these(tmp_path: Path) -> None:
    scans = [scan(TICKS + FRAME_TICKS * number, **with_depth(COUNTS)) for number in range(5)]
    with opened(save(tmp_path / "a.rawlog", *scans)) as sequence:
        stamps = sequence.image_stamps("depth")
        assert [frame.row for frame in sequence.images(["depth"], int(stamps[1]), int(stamps[3]))] == [
            1,
            2,
            3,
        ]
        assert list(sequence.images(["rgb"])) == []


def test_several_sensors_for_one_stream_are_listed_and_one_can_be_chosen(tmp_path: Path) -> None:
    scans = [scan(TICKS + n, label, **with_depth(COUNTS)) for n, label in enumerate(["L", "R", "R"])]
    path = save(tmp_path / "a.rawlog", *scans)
    with pytest.raises(
        UsageError, match=r"several sensors give depth: 'L' \(1\), 'R' \(2\)(?s:.*)--topic depth=L"
    ):
        opened(path)
    with opened(path, lenient=True) as sequence:
        assert sequence.info.images == {}
        assert "several sensors give depth" in sequence.info.warnings[0]
    with opened(path, topics={"depth": "R"}) as sequence:
        assert sequence.info.images["depth"].count == 2
        assert [(loss.stream, loss.what, loss.count) for loss in sequence.info.not_carried] == [
            ("L", "depth image", 1)
        ]
    with pytest.raises(UsageError, match="no sensor 'X' gives depth"):
        opened(path, topics={"depth": "X"})


def test_a_sensor_without_a_label_can_be_chosen(tmp_path: Path) -> None:
    scans = [scan(TICKS + n, label, **with_depth(COUNTS)) for n, label in enumerate(["", "my R", "my R"])]
    path = save(tmp_path / "a.rawlog", *scans)
    with pytest.raises(UsageError) as caught:
        opened(path)
    assert (
        caught.value.hint == "choose one: --topic 'depth=my R', or --topic depth= for the one without a label"
    )
    with opened(path, topics={"depth": ""}) as sequence:
        assert sequence.info.images["depth"].count == 1
        assert [(loss.stream, loss.count) for loss in sequence.info.not_carried] == [("my R", 2)]
    with opened(path, topics={"depth": "my R"}) as sequence:
        assert [(loss.stream, loss.count) for loss in sequence.info.not_carried] == [("rawlog", 1)]
    named = save(tmp_path / "b.rawlog", *scans[1:])
    with pytest.raises(UsageError, match=r"no sensor '' gives depth; there are 'my R' \(2\)"):
        opened(named, topics={"depth": ""})


def test_a_sensor_without_a_label_that_is_not_chosen_is_not_warned_of(tmp_path: Path) -> None:
    scans = [
        scan(TICKS, label, range_is_depth=0, range_units=0.0, **with_depth(COUNTS)) for label in ("", "R")
    ]
    path = save(tmp_path / "a.rawlog", *scans)
    with opened(path, streams=frozenset({"rgb"})) as sequence:
        assert sequence.info.warnings == ()
    with opened(path, topics={"depth": ""}) as sequence:
        assert len(sequence.info.warnings) == 2


def test_names_of_external_files_that_no_file_can_have_are_cut_in_messages(tmp_path: Path) -> None:
    image = Record("CImage", 9, {"external": 1, "file": "x" * 5000})
    scans = [scan(TICKS + n, has_intensity=1, intensity=image) for n in range(2)]
    path = save(tmp_path / "a.rawlog", *scans)
    for _ in range(2):  # without the folder and with it
        with opened(path) as sequence:
            assert len(sequence.info.warnings) == 2
            assert all("xxx..." in warning and len(warning) < 500 for warning in sequence.info.warnings)
            with pytest.raises(MissingInputError, match=r"xxx\.\.\.") as caught:
                list(sequence.images())
            assert len(str(caught.value)) < 700
        (finding,) = {found.message for found in validate(path).findings if found.code == "TUM001"}
        assert len(finding) < 200
        (tmp_path / "a_Images").mkdir(exist_ok=True)


def test_thousands_of_sensors_are_not_all_listed(tmp_path: Path) -> None:
    labels = [f"{number:04}" + "x" * 99 for number in range(1000)]
    path = save(tmp_path / "a.rawlog", *(imu(TICKS + n, label) for n, label in enumerate(labels)))
    with pytest.raises(UsageError, match=r"several sensors give accelerometer: .* and 995 more") as caught:
        opened(path)
    assert len(str(caught.value)) < 1000


def test_what_a_sequence_has_no_place_for_is_listed_with_counts(tmp_path: Path) -> None:
    points = {"has_points": 1, "point_count": 0, "points_external": 1, "points_file": "p.bin"}
    nothing = np.empty(0, "<f4")
    points |= dict.fromkeys("xyz", nothing) | dict.fromkeys(["pixel_column", "pixel_row"], np.empty(0, "<u2"))
    odometry = {"odometry": Record("CPose2D", 1, {"values": np.zeros(3)}), "label": "ODO", "time": TICKS}
    records = [
        _comment("a note"),
        scan(**points),
        scan(has_confidence=1, confidence=image_record(PIXELS)),
        imu(channels=6),
        imu(channels=2),
        Record("CObservationOdometry", 2, {**odometry, "has_encoders": 0, "has_velocity": 0}),
    ]
    with opened(save(tmp_path / "a.rawlog", *records)) as sequence:
        found = {(loss.stream, loss.what): loss.count for loss in sequence.info.not_carried}
    assert found == {
        ("CAM", "point cloud"): 1,
        ("CAM", "confidence image"): 1,
        ("IMU", "inertial values besides acceleration"): 1,
        ("IMU", "inertial values without acceleration"): 1,
        ("ODO", "CObservationOdometry"): 1,
        ("comment", "comment text"): 1,
    }


def test_distances_along_the_ray_are_warned_of(tmp_path: Path) -> None:
    with opened(save(tmp_path / "a.rawlog", scan(range_is_depth=0, **with_depth(COUNTS)))) as sequence:
        assert "1 depth images hold distances along the ray" in sequence.info.warnings[0]


def test_observations_without_a_time_are_left_out_and_told(tmp_path: Path) -> None:
    path = save(tmp_path / "a.rawlog", scan(0, **with_depth(COUNTS)), scan(**with_depth(COUNTS)), imu(0))
    with opened(path) as sequence:
        assert sequence.info.images["depth"].count == 1
        assert sequence.accelerometer is None
        assert [(loss.stream, loss.what, loss.count) for loss in sequence.info.not_carried] == [
            ("CAM", "observations without a time", 1),
            ("IMU", "observations without a time", 1),
        ]


def test_a_time_beyond_the_range_is_damage(tmp_path: Path) -> None:
    path = save(tmp_path / "a.rawlog", imu(), imu(2**64 - 1))
    with pytest.raises(InputError, match=r"object 1, offset.*not within the years 1678 to 2262"):
        opened(path)


def test_swapped_sizes_of_old_scans_are_undone(tmp_path: Path) -> None:
    matrix = Record(
        "CMatrixD", 0, {"rows": 3, "columns": 3, "values": np.array([7, 0, 3, 0, 8, 2, 0, 0, 1.0])}
    )
    camera = {"focal_length_metres": 0.0, "distortion": np.zeros(5, "<f8"), "intrinsics": matrix}
    swapped = Record("TCamera", 2, {**camera, "rows": 640, "columns": 480})
    fields = scan(has_range=1, range_external=1, range_file="d.bin", camera=swapped).fields
    empty = Record("CMatrix", 0, {"rows": 0, "columns": 0, "values": np.empty(0, "<f4")})
    old = Record("CObservation3DRangeScan", 6, {**fields, "range_matrix": empty})
    with opened(save(tmp_path / "a.rawlog", old)) as sequence:
        camera_info = sequence.cameras["depth"]
        assert (camera_info.width, camera_info.height) == (640, 480)
        assert camera_info.k == (7, 0, 3, 0, 8, 2, 0, 0, 1)


def test_calibrations_that_change_are_counted(tmp_path: Path) -> None:
    def scans(label: str, *rows: int) -> list[Record]:
        cameras = [made.camera(count) for count in rows]
        return [scan(TICKS + n, label, camera=c, **with_depth(COUNTS)) for n, c in enumerate(cameras)]

    path = save(tmp_path / "a.rawlog", *scans("L", 7, 7, 8, 9), *scans("R", 5, 5))
    for label, expected in {"L": [("depth", 2)], "R": []}.items():
        with opened(path, topics={"depth": label}) as sequence:
            what = "calibrations that differ from the first"
            assert [(o.stream, o.count) for o in sequence.info.not_carried if o.what == what] == expected


@pytest.mark.parametrize(
    "changes",
    [
        {"distortion": np.array([np.nan, *[0.0] * 7])},
        {"fx_fy_cx_cy": np.array([np.inf, 7.5, 3.5, 2.5])},
        {"rows": 2**32 - 1, "columns": 2**32 - 1},
    ],
)
@pytest.mark.parametrize("to", ["rawlog", "mcap", "tum"])
def test_intrinsics_that_are_no_cameras_are_left_out_and_told(
    changes: dict[str, object], to: str, tmp_path: Path
) -> None:
    camera = made.camera()
    camera.fields |= changes
    record = scan(**with_depth(COUNTS), camera=camera)
    with opened(save(tmp_path / "a.rawlog", record)) as sequence:
        assert sequence.cameras == {}
        assert "the intrinsics of depth in 1 observations are no camera's" in sequence.info.warnings[0]
        report = convert(sequence, tmp_path / f"out{'.mcap' if to == 'mcap' else ''}", to)
    assert report.verified
    assert [loss.what for loss in report.losses if loss.stream == "depth"] == ["intrinsics"]


def test_a_missing_external_file_is_warned_of_and_refused_when_images_are_wanted(tmp_path: Path) -> None:
    path = made.written(made.typical(), tmp_path)
    victim = next((tmp_path / "made" / "made_Images").glob("*_rgb.png"))
    victim.unlink()
    with opened(path) as sequence:
        assert any("1 external file is missing" in text for text in sequence.info.warnings)
        assert sum(1 for _ in sequence.images(["depth"])) == 3
        with pytest.raises(MissingInputError, match=victim.name):
            sequence.images()


@pytest.mark.parametrize("victim", [0, 1])
def test_a_salvage_goes_on_without_the_files_that_are_missing(victim: int, tmp_path: Path) -> None:
    source = made.typical()
    stamp = int(source.image_stamps("rgb")[1])
    literal = {
        row: f"{format_stamp(int(t))} rgb/{row}.png" for row, t in enumerate(source.image_stamps("rgb"))
    }
    source.info = replace(source.info, text={"rgb": TextLayout(overrides=literal)})
    path = made.written(source, tmp_path)
    files = sorted((tmp_path / "made" / "made_Images").glob("*_rgb.png"))
    files[victim].unlink()
    with opened(path, salvage=True) as sequence:
        assert sequence.info.images["rgb"].count == 2
        assert sequence.info.images["rgb"].width == 8
        assert (stamp in sequence.image_stamps("rgb").tolist()) is (victim == 0)
        report = convert(sequence, tmp_path / "back", "tum")
    assert report.verified
    assert [(loss.stream, loss.what, loss.count) for loss in report.losses] == [
        ("rgb", "images without their file", 1)
    ]
    assert sorted(file.name for file in (tmp_path / "back" / "rgb").iterdir()) == [
        f"{row}.png" for row in range(3) if row != victim
    ]


def test_a_hostile_name_is_refused(tmp_path: Path) -> None:
    image = Record("CImage", 9, {"external": 1, "file": "../../secret.png"})
    with pytest.raises(InputError, match="leads out of the folder"):
        opened(save(tmp_path / "a.rawlog", scan(has_intensity=1, intensity=image)))


def test_a_damaged_file_is_refused_or_read_up_to_the_damage(tmp_path: Path) -> None:
    path = save(
        tmp_path / "a.rawlog", imu(), scan(**with_depth(COUNTS)), scan(TICKS + 5, **with_depth(COUNTS))
    )
    path.write_bytes(path.read_bytes()[:-40])
    with pytest.raises(InputError, match="object 2, offset"):
        opened(path)
    with opened(path, salvage=True) as sequence:
        assert names_of(sequence) == {"depth": [(STAMP, 0)]}
        assert "what is before it (2 objects) is read" in sequence.info.warnings[0]
        (loss,) = sequence.info.not_carried
        assert (loss.stream, loss.what, loss.count) == ("recording", "end missing", 1)
        assert "offset" in loss.why


def test_an_unknown_class_ends_the_reading_with_what_is_before_it(tmp_path: Path) -> None:
    path = save(tmp_path / "a.rawlog", scan(**with_depth(COUNTS)))
    path.write_bytes(path.read_bytes() + b"\x8fCObservationGPS\x08" + bytes(99))
    with pytest.raises(UnsupportedInputError, match=r"object 1.*CObservationGPS version 8"):
        opened(path)
    with opened(path, salvage=True) as sequence:
        np.testing.assert_array_equal(pixels_of(next(sequence.images()).load()), COUNTS)


@pytest.mark.parametrize("name", [archive.NULL, archive.EMPTY])
@pytest.mark.parametrize("old", [False, True])
def test_a_rawlog_may_begin_with_nothing(name: str, old: bool, tmp_path: Path) -> None:
    nothing = Record(name, 0, old_framing=old)
    path = save(tmp_path / "a.rawlog", nothing, scan(**with_depth(COUNTS)))
    with open_source(path) as sequence:
        assert sequence.info.format == "rawlog"
        assert names_of(sequence) == {"depth": [(STAMP, 0)]}


def test_a_wrong_checksum_loses_nothing_that_was_read_before_it(tmp_path: Path) -> None:
    path = made.written(made.typical(), tmp_path)
    data = bytearray(path.read_bytes())
    data[-5] ^= 1
    path.write_bytes(data)
    with pytest.raises(InputError, match=r"before offset \d+ of the file: damaged gzip data"):
        opened(path)
    with opened(path, salvage=True) as sequence:
        assert names_of(sequence) == names_of(made.typical())
        assert not any("edited" in text for text in sequence.info.warnings)
        assert [loss.what for loss in sequence.info.not_carried] == ["end missing"]


def test_a_second_member_that_was_hit_is_not_lost_in_silence(tmp_path: Path) -> None:
    path = made.written(made.typical(), tmp_path)
    more = bytearray(gzip.compress(CODEC.encode(imu())))
    more[0] ^= 1
    path.write_bytes(path.read_bytes() + more)
    with pytest.raises(InputError, match="what follows a gzip member"):
        opened(path)
    with opened(path, salvage=True) as sequence:
        assert "what follows a gzip member" in sequence.info.warnings[0]
        assert [loss.what for loss in sequence.info.not_carried] == ["end missing"]


@pytest.mark.parametrize("victim", ["made_Images/{}", "groundtruth.txt"])
def test_a_pipe_in_the_place_of_a_file_is_refused_and_not_waited_for(victim: str, tmp_path: Path) -> None:
    path = made.written(made.typical(), tmp_path)
    image = next((path.parent / "made_Images").glob("*_rgb.png")).name
    file = path.parent / victim.format(image)
    file.unlink()
    os.mkfifo(file)
    with pytest.raises(InputError, match="no file but a pipe"), opened(path) as sequence:
        for frame in sequence.images():
            frame.load()


def test_the_folder_of_a_rawlog_will_do(tmp_path: Path) -> None:
    save(tmp_path / "a.rawlog", imu())
    assert reader.find(tmp_path) == tmp_path / "a.rawlog"
    save(tmp_path / "b.rawlog", imu())
    with pytest.raises(InputError, match=r"2 rawlogs in this folder: a\.rawlog, b\.rawlog"):
        reader.find(tmp_path)
    (tmp_path / "empty").mkdir()
    with pytest.raises(MissingInputError, match=r"no \.rawlog"):
        reader.find(tmp_path / "empty")


def test_rates_of_the_first_imu_versions_are_in_the_other_order() -> None:
    values = np.arange(15, dtype="<f4")
    present = np.ones(15, np.uint8)
    old = Record("CObservationIMU", 0, {"present": present, "values": values})
    assert imu_of(old).values[:6].tolist() == [0, 1, 2, 5, 4, 3]
    new = Record("CObservationIMU", 2, {"present": present, "values": values})
    assert imu_of(new).values[:6].tolist() == [0, 1, 2, 3, 4, 5]
    assert imu_of(new).present.tolist() == [True] * 15 + [False] * 16


@pytest.mark.real
@pytest.mark.parametrize("name", ["test-imu-obs-format3__f35c7482", "test-imu-obs-format4__530e29e2"])
def test_real_imu_files_give_their_known_rates(name: str, real_data: Path) -> None:
    path = real_data / "rawlog" / "mrpt_repository" / f"{name}.rawlog"
    found = survey(path)
    (record,) = list(found.objects)
    rates = imu_of(record).values[3:6]
    assert rates == pytest.approx([0.00222222, 0, 0.005555555], abs=1e-8)


@pytest.mark.real
def test_published_stamps_are_those_of_the_file_names(real_data: Path) -> None:
    # MRPT's converter stores times that went through float64; the names have them to the microsecond.
    for path in ("converter_output/ref.rawlog", "legacy6.rawlog"):
        with opened(real_data / "rawlog" / path) as sequence:
            stamps = sequence.image_stamps("rgb")
            assert stamps[0] == 1_305_031_229_528_766_000
            assert (stamps % 1000 == 0).all()
            assert sequence.accelerometer is not None
            np.testing.assert_array_equal(sequence.accelerometer.stamps, stamps)


@pytest.mark.real
def test_a_real_recording_of_another_sensor(real_data: Path) -> None:
    with opened(real_data / "rawlog" / "mrpt_repository" / "tests_rgbd__394744d4.rawlog") as sequence:
        images = {frame.stream: frame.load() for frame in sequence.images()}
        assert [(image.width, image.height) for image in images.values()] == [(640, 480)] * 2
        metres = pixels_of(images["depth"])
        assert images["depth"].encoding == "32FC1"
        assert 1.5 < np.nanmedian(metres) < 3
        assert np.isnan(metres).mean() == pytest.approx(0.11, abs=0.02)
        assert sequence.cameras["rgb"].k[0] == pytest.approx(521.179233)
