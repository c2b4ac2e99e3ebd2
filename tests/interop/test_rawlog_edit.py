# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""MRPT's own rawlog-edit reads what we write, and writes it again the same."""

from __future__ import annotations

import re
import shutil
import subprocess
from contextlib import closing
from typing import TYPE_CHECKING

import numpy as np
import pytest

from tests.formats.rawlog import made
from tests.formats.rawlog.made import opened
from tests.interop.programs import program
from tumtools.convert import convert
from tumtools.formats.options import WriteOptions
from tumtools.formats.rawlog.compression import Pieces
from tumtools.formats.rawlog.objects import Objects
from tumtools.images import depth
from tumtools.images.codec import pixels_of
from tumtools.model.time import format_stamp, parse_stamp

if TYPE_CHECKING:
    from pathlib import Path

pytestmark = pytest.mark.interop

FRAMES = 10
DIALECTS = ("modern", "legacy", "converter")


def _edit(rawlog: Path, *arguments: str | Path) -> str:
    """Run rawlog-edit where it finds external files: in the folder of the rawlog, on its bare name."""
    command = [program("rawlog-edit"), *arguments, "-w", "-i", rawlog.name]
    done = subprocess.run(
        command, cwd=rawlog.parent, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def _inflated(path: Path) -> bytes:
    with closing(Pieces(path)) as pieces:
        return b"".join(iter(pieces.next, b""))


@pytest.fixture(scope="module", params=DIALECTS)
def dialect(request: pytest.FixtureRequest) -> str:
    program("rawlog-edit")
    return str(request.param)


@pytest.fixture(scope="module")
def rawlog(dialect: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A rawlog of ours; depth within what MRPT rounds old depth files to (16 bits of millimetres)."""
    folder = tmp_path_factory.mktemp(dialect)
    convert(made.typical(FRAMES), folder / "made", "rawlog", WriteOptions(dialect=dialect))
    return folder / "made" / "made.rawlog"


def test_info_counts_labels_and_rates(rawlog: Path, dialect: str) -> None:
    text = _edit(rawlog, "--info")
    facts = dict(re.findall(r"^(\S[^:]*?)\s*: (.*)$", text, re.MULTILINE))
    with opened(rawlog) as sequence:
        stamps = sequence.image_stamps("rgb")
        assert sequence.accelerometer is not None
        rows = len(sequence.accelerometer)
    assert facts["Overall number of objects"] == str(FRAMES + rows + (0 if dialect == "converter" else 2))
    assert facts["Observations format"] == "Yes"
    assert f"KINECT /{FRAMES:>7} /30.0" in text
    assert re.search(rf"KINECT_ACC /\s*{rows} /", text)
    seconds = (int(stamps[-1]) - int(stamps[0])) / 1e9
    assert re.search(rf"KINECT /\s*{FRAMES} /[\d.]+ +/{seconds:.3f}", text)


def test_stamps_and_images_are_listed(rawlog: Path, tmp_path: Path) -> None:
    _edit(rawlog, "--list-timestamps", "--text-file-output", tmp_path / "stamps.txt")
    lines = [line.split() for line in (tmp_path / "stamps.txt").read_text().splitlines()]
    with opened(rawlog) as sequence:
        assert sequence.accelerometer is not None
        for label, stamps in (
            ("KINECT", sequence.image_stamps("rgb")),
            ("KINECT_ACC", sequence.accelerometer.stamps),
        ):
            listed = [parse_stamp(line[0]) for line in lines if line[1] == label]
            # rawlog-edit prints through a float64, to the microsecond.
            assert np.abs(np.array(listed) - stamps).max() <= 1000
            assert len(listed) == len(stamps)
        names = [f"{format_stamp(int(stamp))}_rgb.png" for stamp in sequence.image_stamps("rgb")]
    _edit(rawlog, "--list-images", "--text-file-output", tmp_path / "images.txt")
    assert (tmp_path / "images.txt").read_text().split() == names


def test_inertial_values_are_exported(rawlog: Path) -> None:
    _edit(rawlog, "--export-imu-txt")
    table = np.loadtxt(rawlog.parent / "made_KINECT_ACC.txt", comments="%")
    (rawlog.parent / "made_KINECT_ACC.txt").unlink()
    with opened(rawlog) as sequence:
        assert sequence.accelerometer is not None
        np.testing.assert_allclose(table[:, 1:4], sequence.accelerometer.values, atol=5.1e-9)
        np.testing.assert_allclose(table[:, 0], sequence.accelerometer.stamps / 1e9, atol=1e-6)
    assert not table[:, 4:].any()


def test_the_whole_is_written_again_to_identical_bytes(rawlog: Path, dialect: str, tmp_path: Path) -> None:
    _edit(rawlog, "--remove-label", "NONE", "-o", tmp_path / "again.rawlog")
    if dialect == "legacy":  # MRPT writes the classes of its own time
        objects = [(record.type, record.integer("time")) for record in Objects(rawlog)]
        assert objects == [(r.type, r.integer("time")) for r in Objects(tmp_path / "again.rawlog")]
    else:
        assert (tmp_path / "again.rawlog").read_bytes() == rawlog.read_bytes()


def test_the_observations_are_kept_by_label_to_identical_bytes(
    rawlog: Path, dialect: str, tmp_path: Path
) -> None:
    _edit(rawlog, "--keep-label", "KINECT,KINECT_ACC", "-o", tmp_path / "kept.rawlog")
    objects = [record for record in Objects(rawlog) if record.type != "CObservationComment"]
    kept, whole = _inflated(tmp_path / "kept.rawlog"), _inflated(rawlog)
    if dialect == "legacy":
        assert len(list(Objects(tmp_path / "kept.rawlog"))) == len(objects)
    else:
        comments = whole[: objects[0].offset], b"".join(whole.partition(kept)[2:])
        assert kept in whole  # all but the comments, which have no label
        assert all(b"tumtools" in text for text in comments if text)


def test_mrpt_embeds_the_pixels_that_we_wrote(rawlog: Path, dialect: str, tmp_path: Path) -> None:
    _edit(rawlog, "--de-externalize", "-o", tmp_path / "embedded.rawlog")
    with opened(rawlog) as ours, opened(tmp_path / "embedded.rawlog") as theirs:
        for mine, other in zip(ours.images(["rgb"]), theirs.images(["rgb"]), strict=True):
            image = other.load()
            assert image.encoding == "bgr8"
            np.testing.assert_array_equal(pixels_of(image)[:, :, ::-1], pixels_of(mine.load()))
        for mine, other in zip(ours.images(["depth"]), theirs.images(["depth"]), strict=True):
            expected = pixels_of(mine.load()).astype(np.uint16)
            if dialect == "legacy":  # MRPT rounds the metres of old scans to millimetres
                expected, _ = depth.rescale_counts(expected, 5000, 1000)
                assert np.abs(pixels_of(other.load()).astype(int) - expected).max() <= 1
            else:
                np.testing.assert_array_equal(pixels_of(other.load()), expected)


def test_times_that_mrpt_remaps_hold_for_images_as_for_accelerations(
    rawlog: Path, dialect: str, tmp_path: Path
) -> None:
    folder = tmp_path / "moved"
    shutil.copytree(rawlog.parent, folder)
    _edit(folder / "made.rawlog", "--remap-timestamps", "1;100", "-o", "moved.rawlog")
    (folder / "made.rawlog").unlink()
    (folder / "made_Images").rename(folder / "moved_Images")
    with opened(rawlog) as before, opened(folder / "moved.rawlog") as after:
        assert before.accelerometer is not None
        assert after.accelerometer is not None
        for one, other in (
            (before.image_stamps("rgb"), after.image_stamps("rgb")),
            (before.accelerometer.stamps, after.accelerometer.stamps),
        ):
            assert np.abs(other - one - 100 * 10**9).max() <= 1000  # it goes through a float64
        assert any("are not those that their files are named after" in text for text in after.info.warnings)
        assert convert(after, tmp_path / f"back_{dialect}", "tum").verified


def test_depth_that_mrpt_embeds_keeps_its_stamps(rawlog: Path, dialect: str, tmp_path: Path) -> None:
    _edit(rawlog, "--de-externalize", "-o", tmp_path / "embedded.rawlog")
    with opened(rawlog) as ours, opened(tmp_path / "embedded.rawlog") as theirs:
        for stream in ("rgb", "depth"):
            apart = np.abs(ours.image_stamps(stream) - theirs.image_stamps(stream)).max()
            # The other dialect has one time for both images, which went through a float64.
            assert apart <= (1000 if dialect == "converter" else 0)


@pytest.mark.real
def test_real_data_through_the_other_program(real_data: Path, tmp_path: Path) -> None:
    from tumtools.sources import open_source

    program("rawlog-edit")
    with open_source(real_data / "rgbd_dataset_freiburg1_rpy") as source:
        convert(source, tmp_path / "rpy", "rawlog", WriteOptions(compression="none"))
        text = _edit(tmp_path / "rpy" / "rpy.rawlog", "--info")
        assert re.search(r"KINECT /\s*90 /", text)
        assert re.search(r"KINECT_ACC /\s*1997 /", text)
        _edit(
            tmp_path / "rpy" / "rpy.rawlog",
            "--cut",
            "--to-index",
            "99",
            "-o",
            tmp_path / "rpy" / "cut.rawlog",
        )
    (tmp_path / "rpy" / "rpy_Images").rename(tmp_path / "rpy" / "cut_Images")
    with opened(tmp_path / "rpy" / "cut.rawlog") as cut:
        assert any("has been edited since" in text for text in cut.info.warnings)
        assert cut.accelerometer is not None
        assert len(cut.accelerometer) < 101
