# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Each kind of loss where it happens, with its count and size, and where it does not."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from tests.memory import SECOND, START, Memory, accelerometer, groundtruth
from tests.roundtrip.contents import Made
from tumtools.convert import ConvertOptions, convert
from tumtools.errors import LossRefusedError
from tumtools.formats.options import WriteOptions
from tumtools.images.codec import image_of_pixels
from tumtools.model.camera import CALIBRATIONS
from tumtools.model.sequence import DATA_CITATION, DATA_LICENCE
from tumtools.sources import open_source
from tumtools.transform import Selection

if TYPE_CHECKING:
    from collections.abc import Callable

    from tumtools.model.sequence import Loss, Sequence

NAME = "synthetic_freiburg1_loss"
OFFICIAL = "rgbd_dataset_freiburg3_none"
FIXTURES = Path(__file__).parents[2] / "fixtures"
MILLIMETRES = WriteOptions(depth_encoding="16UC1")
CONVERTER = WriteOptions(dialect="converter")
FRAME = SECOND // 30


def losses(sequence: Sequence, target: Path, to: str, options: WriteOptions | None = None) -> list[Loss]:
    return list(convert(sequence, target, to, options).losses)


def depth(*counts: int) -> Sequence:
    """Return two depth images with these counts of 1/5000 m, side by side."""
    image = image_of_pixels(np.array([counts], np.uint16), "16UC1", 5000.0)
    return _named(Made(depth=[(START, image), (START + FRAME, image)]))


def metres(*values: float) -> Sequence:
    image = image_of_pixels(np.array([values], np.float32), "32FC1", 1.0)
    return _named(Made(depth=[(START, image)]))


def _named(sequence: Sequence) -> Sequence:
    sequence.info = replace(sequence.info, name=NAME)
    return sequence


def pictures(rgb: list[int], depths: list[int], **content: object) -> Memory:
    return Memory({"rgb": rgb, "depth": depths}, name=NAME, **content)


# --- depth --------------------------------------------------------------------------------------------


def test_millimetres_round_what_is_no_multiple_of_five_counts(tmp_path: Path) -> None:
    (loss,) = losses(depth(0, 5, 6, 8, 5000, 5002), tmp_path / "x.mcap", "mcap", MILLIMETRES)
    assert (loss.stream, loss.what, loss.count, loss.unit) == ("depth", "pixels rounded", 6, "m")
    assert loss.largest_error == pytest.approx(0.0004)


def test_millimetres_keep_what_is_a_multiple(tmp_path: Path) -> None:
    assert losses(depth(0, 5, 5000, 65535), tmp_path / "x.mcap", "mcap", MILLIMETRES) == []


def test_counts_round_metres_in_between(tmp_path: Path) -> None:
    (loss,) = losses(metres(1.0, 1.00005, 2.00008), tmp_path / "x", "tum")
    assert (loss.what, loss.count) == ("pixels rounded", 2)
    assert loss.largest_error == pytest.approx(0.00008, abs=1e-6)


def test_counts_have_no_place_for_what_is_far_or_behind(tmp_path: Path) -> None:
    (loss,) = losses(metres(13.107, 13.2, -1.0, 1e30), tmp_path / "x", "tum")
    assert (loss.what, loss.count) == ("pixels out of range, now without a reading", 3)
    with open_source(tmp_path / "x") as result:
        pixels = next(iter(result.images())).load()
        assert pixels.png is not None


def test_counts_keep_metres_that_are_multiples_and_no_reading(tmp_path: Path) -> None:
    assert losses(metres(0.0, np.nan, 0.0002, 1.0, 13.107), tmp_path / "x", "tum") == []


def test_metres_are_kept_as_metres(tmp_path: Path) -> None:
    assert losses(metres(1.00005, 1e-9, 100.0), tmp_path / "x.bag", "rosbag1") == []


@pytest.mark.parametrize("dialect", ["modern", "converter"])
def test_a_rawlog_rounds_metres_too(dialect: str, tmp_path: Path) -> None:
    found = losses(metres(1.00005, 1.0), tmp_path / "x", "rawlog", WriteOptions(dialect=dialect))
    rounded = [loss for loss in found if "rounded" in loss.what]
    assert [loss.stream for loss in rounded] == ["depth"]
    assert rounded[0].largest_error == pytest.approx(0.00005, abs=1e-6)


# --- headers ------------------------------------------------------------------------------------------


def test_a_calibration_of_its_own_has_no_place_in_the_benchmarks_layout(tmp_path: Path) -> None:
    sequence = pictures([START], [START])
    sequence.cameras = {"depth": CALIBRATIONS["fr3", "rgb"]}
    assert [(loss.stream, loss.what, loss.alters) for loss in losses(sequence, tmp_path / "x", "tum")] == [
        ("depth", "calibration", ("calibration",))
    ]
    assert losses(sequence, tmp_path / "x.mcap", "mcap") == []
    assert losses(pictures([START], [START]), tmp_path / "y", "tum") == []


def test_frame_ids_have_no_place_in_the_benchmarks_layout(tmp_path: Path) -> None:
    sequence = pictures([START], [], frame_ids={"rgb": "left_eye"})
    assert [(loss.stream, loss.what) for loss in losses(sequence, tmp_path / "x", "tum")] == [
        ("rgb", "frame id left_eye")
    ]
    assert losses(sequence, tmp_path / "x.mcap", "mcap") == []


def test_a_camera_is_lost_when_no_name_tells_it(tmp_path: Path) -> None:
    sequence = Memory({"rgb": [START]}, name="kitchen", camera="fr2")
    dry = convert(sequence, tmp_path / "x", "tum", options=ConvertOptions(dry_run=True))
    (loss,) = losses(sequence, tmp_path / "x", "tum")
    assert (loss.stream, loss.what, loss.alters) == ("rgb", "camera fr2", ("camera",))
    assert dry.losses == (loss,)
    with open_source(tmp_path / "x") as result:
        assert result.info.camera is None
    sequence = Memory({"rgb": [START]}, name="my_freiburg2_kitchen", camera="fr2")
    assert losses(sequence, tmp_path / "y", "tum") == []
    with open_source(tmp_path / "y") as result:
        assert result.info.camera == "fr2"


def test_files_that_no_list_names_are_not_carried(tmp_path: Path) -> None:
    convert(pictures([START], [START]), tmp_path / "x", "tum")
    with open_source(tmp_path / "x") as sequence:
        assert losses(sequence, tmp_path / "a.mcap", "mcap") == []
    (tmp_path / "x" / "notes.md").write_text("hello")
    with open_source(tmp_path / "x") as sequence:
        assert [(loss.stream, loss.count) for loss in losses(sequence, tmp_path / "b.mcap", "mcap")] == [
            ("notes.md", 1)
        ]


# --- MRPT's converter ---------------------------------------------------------------------------------


def by_kind(found: list[Loss]) -> dict[tuple[str, str], Loss]:
    return {(loss.stream, loss.what): loss for loss in found}


def converted(sequence: Sequence, tmp_path: Path) -> dict[tuple[str, str], Loss]:
    return by_kind(losses(sequence, tmp_path / "x", "rawlog", CONVERTER))


def test_the_converter_moves_stamps_to_the_mean(tmp_path: Path) -> None:
    times = [START, START + FRAME]
    found = converted(pictures(times, [time + 4_000_000 for time in times]), tmp_path)
    for stream in ("rgb", "depth"):
        loss = found[stream, "stamps replaced"]
        assert (loss.count, loss.unit) == (2, "s")
        assert loss.largest_error == pytest.approx(0.002, abs=1e-6)


def test_the_converter_keeps_stamps_that_are_equal(tmp_path: Path) -> None:
    found = converted(pictures([START], [START]), tmp_path)
    assert not [key for key in found if key[1] == "stamps replaced"]


def test_the_converter_drops_images_without_a_partner(tmp_path: Path) -> None:
    found = converted(
        pictures([START, START + SECOND], [START, START + 2 * SECOND, START + 3 * SECOND]), tmp_path
    )
    assert found["rgb", "images dropped"].count == 1
    assert found["depth", "images dropped"].count == 2
    assert ("rgb", "images dropped") not in by_kind(
        losses(pictures([START], [START]), tmp_path / "y", "rawlog", CONVERTER)
    )


def test_the_converter_stores_a_depth_image_again(tmp_path: Path) -> None:
    found = converted(pictures([START, START + 5_000_000], [START + 1_000_000]), tmp_path)
    assert found["depth", "images stored again"].count == 1


def test_the_converter_keeps_one_acceleration_per_scan(tmp_path: Path) -> None:
    rows = accelerometer(*(START + number * 2_000_000 for number in range(20)))
    found = converted(pictures([START], [START], accelerometer=rows), tmp_path)
    assert found["accelerometer", "rows dropped"].count == 19


def test_the_converter_gives_two_scans_the_same_acceleration(tmp_path: Path) -> None:
    rows = accelerometer(START + 2_000_000)
    sequence = pictures([START, START + 5_000_000], [START, START + 5_000_000], accelerometer=rows)
    found = converted(sequence, tmp_path)
    assert found["accelerometer", "rows stored again"].count == 1


def test_the_converter_tells_name_and_camera_by_the_name_of_the_file_only(tmp_path: Path) -> None:
    found = converted(pictures([START], [START], licence="CC0-1.0", frame_ids={"rgb": "left_eye"}), tmp_path)
    assert found["sequence", f"name {NAME}"].alters == ("name",)
    assert found["rgb", "camera fr1"].alters == ("camera",)
    assert found["sequence", "licence and citation"].alters == ("licence",)
    assert found["rgb", "frame id left_eye"].alters == ("frame id",)
    told = losses(pictures([START], [START]), tmp_path / "y" / NAME, "rawlog", CONVERTER)
    assert not [loss for loss in told if "name" in loss.alters or "camera" in loss.alters]


def test_a_licence_has_no_place_in_the_benchmarks_layout_but_by_its_name(tmp_path: Path) -> None:
    with open_source(FIXTURES / "fr3") as sequence:
        own = replace(sequence.info, licence="CC0-1.0", citation="nobody")
        official = replace(
            sequence.info, name=OFFICIAL, licence=DATA_LICENCE, citation=DATA_CITATION, text={}
        )
        for number, (info, expected) in enumerate(((own, ["licence and citation"]), (official, []))):
            sequence.info = info
            found = losses(sequence, tmp_path / str(number) / OFFICIAL, "tum")
            assert [loss.what for loss in found if loss.stream == "sequence"] == expected


def test_the_converter_has_no_infrared(tmp_path: Path) -> None:
    found = converted(
        Memory({"rgb": [START], "depth": [START], "ir": [START, START + 1]}, name=NAME), tmp_path
    )
    assert found["ir", "images dropped"].count == 2


def test_the_converter_writes_its_own_calibration_unless_it_is_the_same(tmp_path: Path) -> None:
    found = converted(pictures([START], [START]), tmp_path)
    assert {stream for stream, what in found if what == "calibration replaced"} == {"rgb", "depth"}
    unknown = pictures([START], [START], camera=None)
    assert not [
        loss for loss in losses(unknown, tmp_path / "y", "rawlog", CONVERTER) if "calibration" in loss.what
    ]


def test_the_converter_has_no_place_for_header_lines(tmp_path: Path) -> None:
    convert(pictures([START], [START], groundtruth=groundtruth(START)), tmp_path / "t", "tum")
    with open_source(tmp_path / "t") as sequence:
        found = converted(sequence, tmp_path)
    dropped = [loss for (_, what), loss in found.items() if what == "text layout dropped"]
    assert {loss.stream for loss in dropped} == {"rgb", "depth"}


@pytest.mark.parametrize("dialect", ["modern", "legacy"])
def test_the_other_dialects_lose_nothing_of_all_this(dialect: str, tmp_path: Path) -> None:
    rows = accelerometer(*(START + number for number in range(20)))
    sequence = Memory(
        {"rgb": [START, START + SECOND], "depth": [START + 3, START + 5 * SECOND], "ir": [START]},
        name=NAME,
        accelerometer=rows,
        groundtruth=groundtruth(START, START),
    )
    assert losses(sequence, tmp_path / "x", "rawlog", WriteOptions(dialect=dialect)) == []


# --- what is asked for is no loss; what is lost is refused when it must not be --------------------------


def test_what_was_asked_for_is_no_loss(tmp_path: Path) -> None:
    sequence = pictures([START, START + 1], [START], groundtruth=groundtruth(START))
    options = ConvertOptions(Selection(streams=("rgb",), end=START))
    report = convert(sequence, tmp_path / "x.mcap", "mcap", WriteOptions(groundtruth="none"), options)
    assert (report.losses, report.frames) == ((), 1)


@pytest.mark.parametrize(
    ("make", "to", "options"),
    [
        (lambda: depth(1), "mcap", MILLIMETRES),
        (lambda: metres(1.00005), "tum", WriteOptions()),
        (lambda: metres(1.00005), "rawlog", WriteOptions()),
        (lambda: pictures([START], []), "rawlog", CONVERTER),
        (lambda: Memory({"rgb": [START]}, name="kitchen"), "tum", WriteOptions()),
    ],
)
def test_strict_refuses_and_leaves_nothing(
    make: Callable[[], Sequence], to: str, options: WriteOptions, tmp_path: Path
) -> None:
    with pytest.raises(LossRefusedError) as caught:
        convert(make(), tmp_path / "x", to, options, ConvertOptions(strict=True))
    assert caught.value.exit_code == 3
    assert not list(tmp_path.iterdir())


def test_a_dry_run_counts_the_same_pixels(tmp_path: Path) -> None:
    dry = convert(depth(1, 2, 5), tmp_path / "x.mcap", "mcap", MILLIMETRES, ConvertOptions(dry_run=True))
    assert dry.losses == convert(depth(1, 2, 5), tmp_path / "x.mcap", "mcap", MILLIMETRES).losses
    assert dry.losses[0].count == 4


@pytest.mark.parametrize(
    ("to", "name", "options"),
    [
        ("tum", "x", WriteOptions()),
        ("tum", "rgbd_dataset_freiburg1_x", WriteOptions()),
        ("mcap", "x.mcap", MILLIMETRES),
        ("rawlog", "x", WriteOptions()),
        ("rawlog", "x", WriteOptions(dialect="legacy")),
        ("rawlog", "x", CONVERTER),
    ],
)
def test_a_dry_run_tells_what_the_conversion_will_lose(
    to: str, name: str, options: WriteOptions, tmp_path: Path
) -> None:
    """The converter drops images, whose pixels were counted all the same; a name was not looked at."""
    values = np.array([[1.00005, 1.0, 20.0, np.nan]], np.float32)
    depths = [(START + n * SECOND, image_of_pixels(values * np.float32(n + 1), "32FC1", 1.0)) for n in (0, 1)]
    colour = image_of_pixels(np.ones((1, 4, 3), np.uint8), "rgb8")
    sequence = _named(Made(depth=depths, rgb=[(START, colour)]))
    sequence.info = replace(sequence.info, licence="CC0-1.0", frame_ids={"rgb": "left_eye"}, camera="fr1")
    foretold = convert(sequence, tmp_path / name, to, options, ConvertOptions(dry_run=True)).losses
    assert foretold == convert(sequence, tmp_path / name, to, options).losses
    assert bool(foretold) == (options.dialect != "legacy")
