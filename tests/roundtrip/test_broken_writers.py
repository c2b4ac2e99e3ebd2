# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A writer that changes anything without saying so is caught before its result gets its name."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from tests.memory import START, Memory, accelerometer, full, groundtruth
from tests.roundtrip.variants import awkward_variants
from tumtools.cli.main import run
from tumtools.convert import convert
from tumtools.errors import InternalError
from tumtools.formats.options import WriteOptions
from tumtools.formats.registry import FORMATS
from tumtools.images.codec import image_of_pixels, image_of_png, pixels_of, png_of
from tumtools.model.camera import CameraInfo
from tumtools.model.digest import KeptDigest
from tumtools.model.sequence import Frame, Sequence

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator, Mapping
    from pathlib import Path

    import numpy.typing as npt

    from tests.roundtrip.variants import Variant
    from tumtools.formats.options import Needs, Plan, Progress
    from tumtools.model.image import Image
    from tumtools.model.sequence import Loss
    from tumtools.model.signals import Accelerometer, Trajectory


LAST = np.array([0, 0, 1])
"""A nanosecond for the last of three rows."""


class Tampered(Sequence):
    """A sequence as a broken writer sees it."""

    def __init__(self, sequence: Sequence) -> None:
        self._inner = sequence
        self.info = sequence.info
        self.groundtruth = sequence.groundtruth
        self.accelerometer = sequence.accelerometer
        self.cameras = sequence.cameras

    def image_stamps(self, stream: str) -> npt.NDArray[np.int64]:
        return self._inner.image_stamps(stream)

    def images(
        self, streams: Collection[str] | None = None, start: int | None = None, end: int | None = None
    ) -> Iterator[Frame]:
        return self._inner.images(streams, start, end)

    def noted_digest(self) -> Mapping[str, KeptDigest] | None:
        return self._inner.noted_digest()


def _with_one_changed(image: Image) -> Image:
    pixels = pixels_of(image).copy()
    flat = pixels.reshape(-1)
    flat[len(flat) // 2] = 1 if flat[len(flat) // 2] != 1 else 2
    changed = image_of_pixels(pixels, image.encoding, image.depth_units_per_metre)
    if image.png is None:
        return changed
    packed = image_of_png(png_of(changed), image.depth_units_per_metre)
    return packed if image.pixels is None else replace(packed, pixels=pixels)


class OnePixel(Tampered):
    """Changes one value of one pixel of the last image of a stream, by one level."""

    def __init__(self, sequence: Sequence, stream: str) -> None:
        super().__init__(sequence)
        self._stream = stream

    def images(
        self, streams: Collection[str] | None = None, start: int | None = None, end: int | None = None
    ) -> Iterator[Frame]:
        last = self._inner.info.images[self._stream].count - 1
        for frame in self._inner.images(streams, start, end):
            if (frame.stream, frame.row) == (self._stream, last):
                yield replace(frame, load=lambda load=frame.load: _with_one_changed(load()))
            else:
                yield frame


class OneNanosecond(Tampered):
    """Moves the last image of a stream by a nanosecond."""

    def __init__(self, sequence: Sequence, stream: str) -> None:
        super().__init__(sequence)
        self._stream = stream

    def image_stamps(self, stream: str) -> npt.NDArray[np.int64]:
        stamps = self._inner.image_stamps(stream).copy()
        if stream == self._stream:
            stamps[-1] += 1
        return stamps

    def images(
        self, streams: Collection[str] | None = None, start: int | None = None, end: int | None = None
    ) -> Iterator[Frame]:
        for frame in self._inner.images(streams, start, end):
            stamps = self.image_stamps(frame.stream)
            yield replace(frame, stamp=int(stamps[frame.row]))


class OneImageLess(Tampered):
    """Drops the last image of a stream."""

    def __init__(self, sequence: Sequence, stream: str) -> None:
        super().__init__(sequence)
        self._stream = stream
        images = dict(sequence.info.images)
        images[stream] = replace(images[stream], count=images[stream].count - 1)
        self.info = replace(sequence.info, images=images)

    def image_stamps(self, stream: str) -> npt.NDArray[np.int64]:
        stamps = self._inner.image_stamps(stream)
        return stamps[:-1] if stream == self._stream else stamps

    def images(
        self, streams: Collection[str] | None = None, start: int | None = None, end: int | None = None
    ) -> Iterator[Frame]:
        for frame in self._inner.images(streams, start, end):
            if frame.row < len(self.image_stamps(frame.stream)):
                yield frame


def _poses(sequence: Sequence, change: Callable[[Trajectory], Trajectory]) -> Sequence:
    found = Tampered(sequence)
    assert sequence.groundtruth is not None
    found.groundtruth = change(sequence.groundtruth)
    return found


def _accelerations(sequence: Sequence, change: Callable[[Accelerometer], Accelerometer]) -> Sequence:
    found = Tampered(sequence)
    assert sequence.accelerometer is not None
    found.accelerometer = change(sequence.accelerometer)
    return found


def _bit(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Change the last bit of one number."""
    changed = values.copy()
    changed[-1, 0] = np.nextafter(changed[-1, 0], np.inf)
    return changed


FAULTS: dict[str, Callable[[Sequence], Sequence]] = {
    "one pixel of colour": lambda s: OnePixel(s, "rgb"),
    "one pixel of depth": lambda s: OnePixel(s, "depth"),
    "one pixel of infrared": lambda s: OnePixel(s, "ir"),
    "one nanosecond of colour": lambda s: OneNanosecond(s, "rgb"),
    "one nanosecond of depth": lambda s: OneNanosecond(s, "depth"),
    "one image of colour": lambda s: OneImageLess(s, "rgb"),
    "one image of depth": lambda s: OneImageLess(s, "depth"),
    "one nanosecond of a pose": lambda s: _poses(s, lambda t: replace(t, stamps=t.stamps + LAST)),
    "one bit of a pose": lambda s: _poses(s, lambda t: replace(t, positions=_bit(t.positions))),
    "one bit of a rotation": lambda s: _poses(s, lambda t: replace(t, quaternions=_bit(t.quaternions))),
    "one pose": lambda s: _poses(s, lambda t: t.take(slice(0, 2))),
    "the order of poses": lambda s: _poses(s, lambda t: t.take(np.array([0, 2, 1]))),
    "one nanosecond of an acceleration": lambda s: _accelerations(
        s, lambda a: replace(a, stamps=a.stamps + LAST)
    ),
    "one bit of an acceleration": lambda s: _accelerations(s, lambda a: replace(a, values=_bit(a.values))),
    "one acceleration": lambda s: _accelerations(s, lambda a: a.take(slice(1, 3))),
}


def _header(sequence: Sequence, **changes: object) -> Sequence:
    found = Tampered(sequence)
    found.info = replace(sequence.info, **changes)  # type: ignore[arg-type]  # as named
    return found


def _calibrations(sequence: Sequence, cameras: dict[str, CameraInfo]) -> Sequence:
    found = Tampered(sequence)
    found.cameras = cameras
    return found


class NoDigest(Tampered):
    """Keeps no digest, or that of something else."""

    def __init__(self, sequence: Sequence, kept: Mapping[str, KeptDigest] | None) -> None:
        super().__init__(sequence)
        self._kept = kept

    def noted_digest(self) -> Mapping[str, KeptDigest] | None:
        return self._kept


OWN = CameraInfo.pinhole(7.0, 7.25, 3.5, 2.5, width=8, height=6)
HEADER_FAULTS: dict[str, Callable[[Sequence], Sequence]] = {
    "the name": lambda s: _header(s, name="another"),
    "the licence": lambda s: _header(s, licence=None),
    "the citation": lambda s: _header(s, citation="somebody else"),
    "the camera": lambda s: _header(s, camera="fr2"),
    "a frame id": lambda s: _header(s, frame_ids={}),
    "another frame id": lambda s: _header(s, frame_ids={"rgb": "right_eye"}),
    "a calibration": lambda s: _calibrations(s, {}),
    "another calibration": lambda s: _calibrations(s, {"depth": replace(OWN, d=(0.1, 0, 0, 0, 0))}),
    "the digest": lambda s: NoDigest(s, None),
    "another digest": lambda s: NoDigest(s, {"rgb": KeptDigest(3, "files", "0" * 64)}),
}


@dataclass(frozen=True)
class BrokenWriter:
    """A writer that is given something else than it should be."""

    inner: Any
    fault: Callable[[Sequence], Sequence]

    def write(
        self, sequence: Sequence, target: Path, options: WriteOptions, progress: Progress
    ) -> tuple[Loss, ...]:
        losses: tuple[Loss, ...] = self.inner.write(self.fault(sequence), target, options, progress)
        return losses

    def needs(self, options: WriteOptions) -> Needs:
        needs: Needs = self.inner.needs(options)
        return needs

    def plan(self, sequence: Sequence, target: Path, options: WriteOptions) -> Plan:
        plan: Plan = self.inner.plan(sequence, target, options)
        return plan


def _break(monkeypatch: pytest.MonkeyPatch, name: str, fault: Callable[[Sequence], Sequence]) -> None:
    entry = FORMATS[name]
    monkeypatch.setitem(entry.__dict__, "writer", BrokenWriter(entry.writer, fault))


def _sequence() -> Memory:
    sequence = full()
    sequence.info = replace(sequence.info, name="synthetic_freiburg1_full")
    return sequence


@pytest.mark.parametrize("variant", awkward_variants(), ids=str)
@pytest.mark.parametrize("fault", FAULTS)
def test_a_broken_writer_is_caught_and_leaves_nothing(
    fault: str, variant: Variant, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _break(monkeypatch, variant.format, FAULTS[fault])
    with pytest.raises(InternalError, match="verification failed") as caught:
        convert(_sequence(), tmp_path / f"x{variant.suffix}", variant.format, variant.write_options)
    assert caught.value.exit_code == 70
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("variant", [one for one in awkward_variants() if one.format != "tum"], ids=str)
@pytest.mark.parametrize("fault", [None, *HEADER_FAULTS])
def test_what_is_beside_the_data_is_compared_too(
    fault: str | None, variant: Variant, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _break(monkeypatch, variant.format, Tampered if fault is None else HEADER_FAULTS[fault])
    sequence = _sequence()
    sequence.cameras = {"depth": OWN}
    sequence.info = replace(
        sequence.info, licence="CC0-1.0", citation="nobody", frame_ids={"rgb": "left_eye"}
    )
    target = tmp_path / f"x{variant.suffix}"
    if fault is None:
        assert convert(sequence, target, variant.format, variant.write_options).losses == ()
        return
    with pytest.raises(InternalError, match="verification failed"):
        convert(sequence, target, variant.format, variant.write_options)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("fault", ["the licence", "a calibration"])
def test_a_writer_that_drops_without_saying_so_what_the_layout_cannot_hold_is_caught(
    fault: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sequence = _sequence()
    sequence.cameras = {"depth": OWN}
    sequence.info = replace(sequence.info, licence="CC0-1.0")
    _break(monkeypatch, "tum", HEADER_FAULTS[fault])
    with pytest.raises(InternalError, match="verification failed"):
        convert(sequence, tmp_path / "x", "tum")


CONVERTER = WriteOptions(dialect="converter")


@pytest.mark.parametrize(
    "fault",
    [
        "one pixel of colour",
        "one pixel of depth",
        "one image of colour",
        "one nanosecond of a pose",
        "one bit of a pose",
        "one bit of an acceleration",
    ],
)
def test_a_stream_that_is_said_to_be_altered_is_compared_as_far_as_it_is_not(
    fault: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The dialect moves stamps and drops rows, and its streams were not looked at for that."""
    _break(monkeypatch, "rawlog", Tampered)
    report = convert(_altered(), tmp_path / "fine", "rawlog", CONVERTER)
    altered = {(loss.stream, part) for loss in report.losses for part in loss.alters}
    assert altered >= {("rgb", "stamps"), ("rgb", "rows dropped"), ("depth", "stamps")}
    assert altered >= {("accelerometer", "stamps"), ("accelerometer", "rows dropped")}
    _break(monkeypatch, "rawlog", FAULTS[fault])
    with pytest.raises(InternalError, match="verification failed"):
        convert(_altered(), tmp_path / "broken", "rawlog", CONVERTER)
    assert [path.name for path in tmp_path.iterdir()] == ["fine"]


def test_stamps_may_be_off_by_what_was_said_and_no_more(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from tumtools.formats.rawlog import plan

    true = plan._Moved.add
    monkeypatch.setattr(plan._Moved, "add", lambda self, change: true(self, change // 2))
    with pytest.raises(InternalError, match=r"what \w+ has at [\d.]+ was not written there"):
        convert(_altered(), tmp_path / "x", "rawlog", CONVERTER)


def test_a_loss_that_is_not_told_is_a_bug(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from tumtools.formats.rawlog import writer

    monkeypatch.setattr(writer, "converter_name_losses", lambda *_: ())
    with pytest.raises(InternalError, match="the name is 'x', 'memory' was written"):
        convert(_altered(), tmp_path / "x", "rawlog", CONVERTER)


def _altered() -> Memory:
    """Return a sequence of which the converter drops an image and rows, and moves the others."""
    step = 100_000_000
    times = [START, START + step, START + 2 * step, START + 3 * step]
    rows = [time + 2_000_000 * number for time in times[1:] for number in (-1, 0, 1)]
    depths = [time + 3_000_000 for time in times[1:]]
    return Memory(
        {"rgb": times, "depth": depths},
        accelerometer=accelerometer(*rows),
        groundtruth=groundtruth(*times[:3]),
    )


@pytest.mark.parametrize("variant", awkward_variants(), ids=str)
def test_the_same_writer_passes_when_it_changes_nothing(
    variant: Variant, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _break(monkeypatch, variant.format, Tampered)
    report = convert(_sequence(), tmp_path / f"x{variant.suffix}", variant.format, variant.write_options)
    assert (report.verified, report.losses) == (True, ())


@pytest.mark.parametrize("name", FORMATS)
def test_a_replaced_target_survives_a_broken_writer(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from tumtools.convert import ConvertOptions

    target = tmp_path / f"x{FORMATS[name].suffix}"
    convert(_sequence(), target, name)
    before = _content(target)
    _break(monkeypatch, name, FAULTS["one pixel of colour"])
    with pytest.raises(InternalError):
        convert(_sequence(), target, name, options=ConvertOptions(force=True))
    assert _content(target) == before
    assert list(tmp_path.iterdir()) == [target]


def _content(target: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in (target, *target.rglob("*")) if path.is_file()}


def test_a_calibration_without_a_place_does_not_spare_the_pixels(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A stream for which only its header is lost was not compared at all."""
    from tumtools.model.camera import CALIBRATIONS

    sequence = _sequence()
    sequence.cameras = {"rgb": CALIBRATIONS["fr3", "rgb"]}
    _break(monkeypatch, "tum", FAULTS["one pixel of colour"])
    with pytest.raises(InternalError, match="the rgb image"):
        convert(sequence, tmp_path / "x", "tum")


def test_the_command_ends_with_70_and_says_that_it_is_a_bug(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    convert(_sequence(), tmp_path / "x.mcap", "mcap")
    _break(monkeypatch, "rosbag1", FAULTS["one nanosecond of depth"])
    code = run(["convert", str(tmp_path / "x.mcap"), str(tmp_path / "x.bag"), "--to", "rosbag1"])
    assert code == 70
    assert "please report this" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["x.mcap"]


def test_accelerations_and_poses_alone_are_compared(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sequence = Memory({}, accelerometer=accelerometer(START, START + 5, START + 9), groundtruth=groundtruth())
    _break(monkeypatch, "mcap", FAULTS["one bit of an acceleration"])
    with pytest.raises(InternalError, match="values of accelerometer differ in 1 rows"):
        convert(sequence, tmp_path / "x.mcap", "mcap")
