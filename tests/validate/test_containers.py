# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Recordings are checked like folders, with the rules for containers on top."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import Writer

from tumtools.convert import ConvertOptions, convert
from tumtools.formats.options import ReadOptions, WriteOptions
from tumtools.formats.ros.inspection import RecordingFacts, TimeFacts
from tumtools.model.camera import CameraInfo, calibration
from tumtools.model.image import Image
from tumtools.model.sequence import Frame, ImageStreamInfo, SequenceInfo
from tumtools.sources import open_source
from tumtools.validate.engine import check, validate
from tumtools.validate.finding import Finding, Severity
from tumtools.validate.frames import measure
from tumtools.validate.settings import Settings
from tumtools.validate.subject import Subject

FIXTURES = Path(__file__).parents[2] / "fixtures"
SMALL = {"TUM202"}  # the fixtures have 64x48 pixels


def _convert(tmp_path: Path, to: str, name: str, **options: str) -> Path:
    with open_source(FIXTURES / "full") as sequence:
        convert(sequence, tmp_path / name, to, WriteOptions(**options), ConvertOptions(verify=False))  # type: ignore[arg-type]  # strings only
    return tmp_path / name


def _codes(findings: tuple[Finding, ...]) -> set[str]:
    return {finding.code for finding in findings}


@pytest.mark.parametrize(
    ("to", "name"),
    [("mcap", "a.mcap"), ("rosbag1", "a.bag"), ("rosbag2", "a"), ("rawlog", "a.rawlog"), ("tum", "a.tgz")],
)
def test_our_own_containers_are_as_clean_as_the_folder(tmp_path: Path, to: str, name: str) -> None:
    result = validate(_convert(tmp_path, to, name))
    assert _codes(result.findings) == SMALL
    assert result.images == 8


def test_content_that_is_not_what_was_written_is_found(tmp_path: Path) -> None:
    """A sqlite3 bag has no checksums: one changed pixel is an image like any other."""
    path = _convert(tmp_path, "rosbag2", "a", color_encoding="rgb8")
    with open_source(path) as sequence:
        pixels = next(iter(sequence.images(["rgb"]))).load().pixels
        assert pixels is not None
        data = pixels.tobytes()
    file = next(path.glob("*.db3"))
    content = bytearray(file.read_bytes())
    content[content.index(data[:60])] ^= 1
    file.write_bytes(content)
    (finding,) = [one for one in validate(path).findings if one.code not in SMALL]
    assert (finding.code, finding.severity, finding.place.stream) == ("TUM707", Severity.ERROR, "rgb")
    assert "TUM707" not in _codes(validate(path, full=False).findings)


def test_streams_and_rows_that_are_gone_or_new_differ_from_the_digest(tmp_path: Path) -> None:
    path = _convert(tmp_path, "rawlog", "a")
    (path / "groundtruth.txt").unlink()
    assert [one.message for one in validate(path).findings if one.code == "TUM707"] == ["the stream is gone"]


@pytest.mark.parametrize(("to", "name"), [("mcap", "a.mcap"), ("rosbag1", "a.bag"), ("tum", "a.tgz")])
def test_a_file_that_was_cut_off_is_named(tmp_path: Path, to: str, name: str) -> None:
    path = _convert(tmp_path, to, name)
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 2 // 3])
    findings = validate(path).findings
    assert "TUM701" in _codes(findings)
    assert {f.code for f in findings if f.severity is Severity.ERROR} <= {"TUM701", "TUM001", "TUM005"}


def test_a_recording_with_nothing_of_a_sequence_does_not_pass(tmp_path: Path) -> None:
    """A bag of other topics, or one whose recorder saw no message."""
    with (tmp_path / "a.mcap").open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2", library="test")
        writer.finish()
    findings = validate(tmp_path / "a.mcap").findings
    assert [(one.code, one.severity) for one in findings] == [("TUM001", Severity.ERROR)]
    assert "no images" in findings[0].message


@pytest.mark.parametrize("content", [b"", b"no format at all", b"\x89MCAP0\r\n", b"#ROSBAG V2.0\n"])
def test_what_is_no_recording_is_a_finding_and_no_traceback(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "x.bag"
    path.write_bytes(content)
    assert "TUM701" in _codes(validate(path).findings)


def test_a_missing_source_is_a_finding(tmp_path: Path) -> None:
    assert _codes(validate(tmp_path / "nothing").findings) == {"TUM001"}


def test_frame_ids_of_the_published_layout_are_named_in_ros_2(tmp_path: Path) -> None:
    result = validate(_convert(tmp_path, "mcap", "a.mcap", layout="published"))
    assert _codes(result.findings) == {"TUM703", *SMALL}


def _recorded(**changes: object) -> Subject:
    """Return an MCAP recording of colour images with nothing wrong, and with changes."""
    info = SequenceInfo("made up", "mcap", images={"rgb": ImageStreamInfo(2, "rgb8", 640, 480)})
    facts = RecordingFacts(
        {"rgb": "camera"}, {"rgb": calibration("fr1", "rgb")}, (), {"rgb": TimeFacts(0, 0, 0)}
    )
    stamps = {"rgb": np.array([1305031102175304000, 1305031102211214000])}
    return Subject("x", "x", format="mcap", info=info, stamps=stamps, recording=replace(facts, **changes))  # type: ignore[arg-type]  # as named


def _found(subject: Subject) -> tuple[Finding, ...]:
    return check(subject, Settings()).findings


def test_a_good_recording_has_no_findings() -> None:
    assert _found(_recorded()) == ()


def test_messages_out_of_order_are_found() -> None:
    (finding,) = _found(_recorded(times={"rgb": TimeFacts(3, 7, 0)}))
    assert (finding.code, finding.severity, finding.place.row) == ("TUM702", Severity.WARNING, 7)


@pytest.mark.parametrize(
    ("milliseconds", "severity"), [(0.5, None), (30, Severity.INFO), (2500, Severity.WARNING)]
)
def test_the_time_of_recording_may_lag_a_little(milliseconds: float, severity: Severity | None) -> None:
    findings = _found(_recorded(times={"rgb": TimeFacts(0, 0, round(milliseconds * 1e6))}))
    assert [finding.severity for finding in findings] == ([] if severity is None else [severity])


@pytest.mark.parametrize(
    ("camera", "severity"),
    [
        (None, Severity.WARNING),
        (CameraInfo.pinhole(525, 525, 319.5, 239.5, width=320, height=240), Severity.ERROR),
        (CameraInfo.pinhole(0, 0, 0, 0), Severity.ERROR),
        (CameraInfo.pinhole(525, 525, 900, 239.5), Severity.ERROR),
    ],
)
def test_calibrations_that_cannot_be_right_are_found(camera: CameraInfo | None, severity: Severity) -> None:
    (finding,) = _found(_recorded(cameras={"rgb": camera}))
    assert (finding.code, finding.severity) == ("TUM705", severity)


def test_a_calibration_that_changes_is_warned_of() -> None:
    (finding,) = _found(_recorded(other_cameras={"rgb": 3}))
    assert (finding.code, finding.severity, finding.measured) == ("TUM705", Severity.WARNING, "3")


def test_damage_that_is_known_is_a_warning(tmp_path: Path) -> None:
    path = _convert(tmp_path, "mcap", "a.mcap")
    path.write_bytes(path.read_bytes()[:-100])
    (error,) = (f for f in validate(path).findings if f.code == "TUM701")
    (known,) = (f for f in validate(path, options=ReadOptions(salvage=True)).findings if f.code == "TUM701")
    assert (error.severity, known.severity) == (Severity.ERROR, Severity.WARNING)
    assert "--salvage" in error.hint
    assert not known.hint


def test_damage_is_reported_once_and_not_its_consequences(tmp_path: Path) -> None:
    path = _convert(tmp_path, "rosbag2", "a")
    for file in path.glob("*.db3"):
        file.unlink()
    assert [finding.code for finding in validate(path).findings] == ["TUM001"]
    (path / "metadata.yaml").write_text("}{")
    assert [finding.code for finding in validate(path).findings] == ["TUM701"]
    cut = _convert(tmp_path, "mcap", "b.mcap")
    cut.write_bytes(cut.read_bytes()[:3000])
    assert {finding.code for finding in validate(cut).findings} == {"TUM701"}


def test_definitions_in_the_spelling_of_ros_1_are_found() -> None:
    (finding,) = _found(_recorded(old_definitions=("/camera/rgb/camera_info",)))
    assert finding.code == "TUM705"
    assert "/camera/rgb/camera_info" in finding.message


def _depth_recorded(
    pixels: np.ndarray[tuple[int, int], np.dtype[np.generic]], encoding: str, units: float
) -> Subject:
    """Return an MCAP recording of one depth image."""
    subject = _recorded()
    image = Image(pixels.shape[1], pixels.shape[0], encoding, units, pixels=pixels)
    facts, histogram = measure(Frame("depth", 1305031102175304000, 0, lambda: image), decode=True)
    assert histogram is not None
    subject.stamps = {**subject.stamps, "depth": np.array([facts.stamp])}
    subject.frames["depth"] = [facts]
    subject.depth_histogram += histogram
    return subject


def _kinect_metres() -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Return depths on the sensor's grid, from 0.9 to 4.4 m, with holes."""
    steps = np.arange(80, 386)
    metres = 580 * 0.075 * 8 / np.repeat(steps, 640 * 480 // len(steps) + 1)[: 640 * 480].reshape(480, 640)
    metres[:40] = 0
    return metres


@pytest.mark.parametrize(
    ("encoding", "units", "factor", "code"),
    [
        ("16UC1", 1000.0, 1000.0, None),
        ("16UC1", 1000.0, 5000.0, "TUM704"),
        ("32FC1", 1.0, 1.0, None),
        ("32FC1", 1.0, 1000.0, "TUM704"),
        ("32FC1", 1.0, 0.2, "TUM704"),
    ],
)
def test_depth_is_in_the_unit_of_its_encoding(
    encoding: str, units: float, factor: float, code: str | None
) -> None:
    values = _kinect_metres() * factor
    pixels = np.rint(values).astype(np.uint16) if encoding == "16UC1" else values.astype(np.float32)
    errors = [
        f.code for f in _found(_depth_recorded(pixels, encoding, units)) if f.severity is Severity.ERROR
    ]
    assert errors == ([] if code is None else [code])


@pytest.mark.parametrize("full", [True, False])
@pytest.mark.parametrize("salvage", [True, False])
def test_every_missing_file_of_a_rawlog_is_named_and_the_others_are_checked(
    full: bool, salvage: bool, tmp_path: Path
) -> None:
    path = _convert(tmp_path, "rawlog", "a")
    folder = path / "a_Images"
    gone = sorted(folder.glob("*_depth.bin"))[:2]
    for file in gone:
        file.unlink()
    broken = max(folder.glob("*_depth.bin"))
    broken.write_bytes(broken.read_bytes()[:-30])
    result = validate(path, full=full, options=ReadOptions(salvage=salvage))
    missing = [finding for finding in result.findings if finding.code == "TUM001"]
    assert [finding.message for finding in missing] == [
        f"the external file {f.name} is missing" for f in gone
    ]
    assert {finding.severity for finding in missing} == {Severity.WARNING if salvage else Severity.ERROR}
    assert result.images == (6 if full else 0)
    assert _codes(result.findings) == {"TUM001", *(SMALL | {"TUM201"} if full else set())}
