# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A writer that changes anything is found out before its result gets its name."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from tests.memory import START, Memory, groundtruth
from tumtools.convert import ConvertOptions, convert
from tumtools.errors import InternalError
from tumtools.formats import registry
from tumtools.formats.options import WriteOptions
from tumtools.images import codec, depth
from tumtools.images.codec import image_of_pixels, pixels_of
from tumtools.model.sequence import Frame, Sequence
from tumtools.sources import open_source

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator

    from tumtools.formats.options import Progress
    from tumtools.model.image import Image
    from tumtools.model.sequence import Loss

FULL = Path(__file__).parents[1] / "fixtures" / "full"


class Tampered(Sequence):
    """What a broken writer makes of a sequence."""

    def __init__(self, inner: Sequence) -> None:
        self._inner = inner
        self.info = inner.info
        self.groundtruth = inner.groundtruth
        self.accelerometer = inner.accelerometer
        self.stamps = {stream: inner.image_stamps(stream).copy() for stream in inner.info.images}
        self.change_image: Callable[[Frame, Image], Image] = lambda _, image: image

    def image_stamps(self, stream: str) -> np.ndarray:
        return self.stamps.get(stream, np.empty(0, np.int64))

    def images(
        self, streams: Collection[str] | None = None, start: int | None = None, end: int | None = None
    ) -> Iterator[Frame]:
        for frame in self._inner.images(streams, start, end):
            if frame.row < len(self.stamps[frame.stream]):
                stamp = int(self.stamps[frame.stream][frame.row])
                yield replace(frame, stamp=stamp, load=partial(self._load, frame))
            else:
                frame.load()

    def _load(self, frame: Frame) -> Image:
        return self.change_image(frame, frame.load())


def _one_pixel(sequence: Tampered, stream: str) -> None:
    def change(frame: Frame, image: Image) -> Image:
        if (frame.stream, frame.row) != (stream, 2):
            return image
        pixels = pixels_of(image).copy()
        pixels[-1, -1] = pixels[-1, -1] ^ 1 if pixels.dtype.kind == "u" else np.float32(0.0002)
        return image_of_pixels(pixels, image.encoding, image.depth_units_per_metre)

    sequence.change_image = change


def _swapped_images(sequence: Tampered) -> None:
    frames = {frame.row: frame for frame in sequence._inner.images(["rgb"])}
    swap = {0: 1, 1: 0}

    def change(frame: Frame, image: Image) -> Image:
        return frames[swap[frame.row]].load() if frame.stream == "rgb" and frame.row in swap else image

    sequence.change_image = change


def _one_nanosecond(sequence: Tampered, stream: str) -> None:
    sequence.stamps[stream][1] += 1


def _one_image_less(sequence: Tampered) -> None:
    sequence.stamps["rgb"] = sequence.stamps["rgb"][:-1]
    images = dict(sequence.info.images)
    images["rgb"] = replace(images["rgb"], count=3)
    sequence.info = replace(sequence.info, images=images)


def _one_nanosecond_of_groundtruth(sequence: Tampered) -> None:
    trajectory = sequence.groundtruth
    assert trajectory is not None
    stamps = trajectory.stamps.copy()
    stamps[7] -= 1
    sequence.groundtruth = replace(trajectory, stamps=stamps)


def _one_bit_of_a_position(sequence: Tampered) -> None:
    trajectory = sequence.groundtruth
    assert trajectory is not None
    positions = trajectory.positions.copy()
    positions[7, 1] = np.nextafter(positions[7, 1], 10)
    sequence.groundtruth = replace(trajectory, positions=positions)


def _one_row_less(sequence: Tampered) -> None:
    assert sequence.accelerometer is not None
    sequence.accelerometer = sequence.accelerometer.take(slice(0, -1))


def _no_accelerometer(sequence: Tampered) -> None:
    sequence.accelerometer = None


def _another_header(sequence: Tampered) -> None:
    text = dict(sequence.info.text)
    text["rgb"] = replace(text["rgb"], head="# colour images\n")
    sequence.info = replace(sequence.info, text=text)


FAULTS: dict[str, tuple[Callable[[Tampered], None], str]] = {
    "one pixel of colour": (partial(_one_pixel, stream="rgb"), "the rgb image at .* differs"),
    "one count of depth": (partial(_one_pixel, stream="depth"), "the depth image at .* differs"),
    "two images swapped": (_swapped_images, "the rgb image at .* differs"),
    "one nanosecond of colour": (
        partial(_one_nanosecond, stream="rgb"),
        "stamps of rgb differ in 1 row|text of rgb",
    ),
    "one nanosecond of depth": (partial(_one_nanosecond, stream="depth"), "stamps of depth differ in 1 row"),
    "one image less": (_one_image_less, "rgb has 3 rows, 4 were written"),
    "one nanosecond of ground truth": (
        _one_nanosecond_of_groundtruth,
        "stamps of groundtruth differ in 1 row",
    ),
    "one bit of a position": (_one_bit_of_a_position, "values of groundtruth differ in 1 row"),
    "one row less": (_one_row_less, r"accelerometer has \d+ rows"),
    "no accelerometer": (_no_accelerometer, "accelerometer is missing"),
    "another header": (_another_header, "the text of rgb would not come back"),
}


def _break_writer(monkeypatch: pytest.MonkeyPatch, to: str, break_it: Callable[[Tampered], None]) -> None:
    writer = registry.get(to).writer
    write = writer.write

    def write_wrong(
        sequence: Sequence, target: Path, options: WriteOptions, progress: Progress
    ) -> tuple[Loss, ...]:
        tampered = Tampered(sequence)
        break_it(tampered)
        return write(tampered, target, options, progress)

    monkeypatch.setattr(writer, "write", write_wrong)


@pytest.mark.parametrize("to", ["tum", "mcap"])
@pytest.mark.parametrize("fault", FAULTS)
def test_a_broken_writer_is_caught_before_the_rename(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fault: str, to: str
) -> None:
    break_it, said = FAULTS[fault]
    _break_writer(monkeypatch, to, break_it)
    with open_source(FULL) as sequence, pytest.raises(InternalError, match=f"verification failed: {said}"):
        convert(sequence, tmp_path / "out", to)
    assert list(tmp_path.iterdir()) == []


def _negative_zeros(sequence: Tampered) -> None:
    trajectory = sequence.groundtruth
    assert trajectory is not None
    sequence.groundtruth = replace(trajectory, positions=-trajectory.positions)


def _invented_frame(sequence: Tampered) -> None:
    sequence.info = replace(sequence.info, frame_ids={"rgb": "invented"})


@pytest.mark.parametrize(
    ("break_it", "to", "said"),
    [
        (_negative_zeros, "tum", "values of groundtruth differ in 2 rows"),
        (_negative_zeros, "mcap", "values of groundtruth differ in 2 rows"),
        (_invented_frame, "mcap", "the frame id of rgb is 'invented', None was written"),
    ],
)
def test_what_equal_numbers_and_absent_names_would_hide_is_caught(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, break_it: Callable[[Tampered], None], to: str, said: str
) -> None:
    given = Memory({"rgb": [START]}, groundtruth=groundtruth(START, START + 1))
    assert given.groundtruth is not None
    given.groundtruth.positions[:] = 0.0
    _break_writer(monkeypatch, to, break_it)
    with pytest.raises(InternalError, match=f"verification failed: {said}"):
        convert(given, tmp_path / "out", to)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("to", "name"), [("tum", "out.tgz"), ("mcap", "out.mcap")])
def test_a_result_that_cannot_be_read_is_a_bug_and_no_damaged_input(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, to: str, name: str
) -> None:
    def write_nothing(_: Sequence, target: Path, __: WriteOptions, ___: Progress) -> tuple[Loss, ...]:
        target.write_bytes(b"\x89MCAP0\r\n")
        return ()

    monkeypatch.setattr(registry.get(to).writer, "write", write_nothing)
    with open_source(FULL) as sequence, pytest.raises(InternalError, match="what was written cannot be read"):
        convert(sequence, tmp_path / name, to)
    assert list(tmp_path.iterdir()) == []


def _one_bit_off(metres: np.ndarray) -> np.ndarray:
    return np.nextafter(metres, np.float32(99))


def _one_pixel_off(metres: np.ndarray) -> np.ndarray:
    if metres.ndim == 2:  # an image, and not the list of all counts
        metres[0, 0] = 0.5
    return metres


@pytest.fixture(params=[_one_bit_off, _one_pixel_off])
def wrong_metres(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Metres that are wrong wherever they are made."""
    right = depth.to_metres
    for module in (depth, codec):
        monkeypatch.setattr(module, "to_metres", lambda counts, units: request.param(right(counts, units)))
    depth.is_reversible.cache_clear()
    yield
    depth.is_reversible.cache_clear()


@pytest.mark.usefixtures("wrong_metres")
@pytest.mark.parametrize("to", ["mcap", "rosbag1"])
def test_wrong_metres_are_caught_also_if_what_is_recorded_has_them(tmp_path: Path, to: str) -> None:
    options = WriteOptions(depth_encoding="32FC1")
    with open_source(FULL) as sequence, pytest.raises(InternalError, match=r"the depth image at .* differs"):
        convert(sequence, tmp_path / "out", to, options)
    assert list(tmp_path.iterdir()) == []


def test_without_verification_nothing_is_read_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with open_source(FULL) as sequence:
        monkeypatch.setattr(registry.get("tum").reader, "open", None)
        report = convert(sequence, tmp_path / "out", "tum", options=ConvertOptions(verify=False))
    assert not report.verified
