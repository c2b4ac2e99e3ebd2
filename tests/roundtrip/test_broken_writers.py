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
from tumtools.formats.registry import FORMATS
from tumtools.images.codec import image_of_pixels, image_of_png, pixels_of, png_of
from tumtools.model.sequence import Frame, Sequence

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator
    from pathlib import Path

    import numpy.typing as npt

    from tests.roundtrip.variants import Variant
    from tumtools.formats.options import Needs, Plan, Progress, WriteOptions
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

    def plan(self, sequence: Sequence, options: WriteOptions) -> Plan:
        plan: Plan = self.inner.plan(sequence, options)
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
