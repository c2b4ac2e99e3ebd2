# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The synthetic sequence has the published look, repeats itself exactly, and obeys physics."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING

import numpy as np
import pytest

from tumtools.errors import UsageError
from tumtools.synthetic import synthesize
from tumtools.validate.depth_scale import measure_depth_scale
from tumtools.validate.gravity import XYZW, estimate_offset, fit_gravity, fit_readings

if TYPE_CHECKING:
    from tumtools.model.sequence import Sequence


def _digest(sequence: Sequence) -> str:
    digest = hashlib.sha256()
    assert sequence.groundtruth is not None
    assert sequence.accelerometer is not None
    digest.update(sequence.groundtruth.values.tobytes() + sequence.accelerometer.values.tobytes())
    for frame in sequence.images():
        pixels = frame.load().pixels
        assert pixels is not None
        digest.update(frame.stamp.to_bytes(8, "big") + pixels.tobytes())
    return digest.hexdigest()


def test_same_seed_same_bytes() -> None:
    first = _digest(synthesize(3, seed=4, width=64, height=48))
    assert first == _digest(synthesize(3, seed=4, width=64, height=48))
    assert first != _digest(synthesize(3, seed=5, width=64, height=48))


def test_frames_do_not_depend_on_the_order_in_which_they_are_loaded() -> None:
    frames = list(synthesize(3, width=64, height=48).images(["depth"]))
    backwards = [frame.load().pixels for frame in reversed(frames)]
    forwards = [frame.load().pixels for frame in frames]
    for one, other in zip(forwards, reversed(backwards), strict=True):
        assert one is not None
        assert other is not None
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(("camera", "number"), [("fr1", 1), ("fr2", 2), ("fr3", 3)])
def test_it_is_named_and_headed_as_published(camera: str, number: int) -> None:
    sequence = synthesize(2, camera=camera, width=64, height=48)
    name = f"synthetic_freiburg{number}_room"
    assert sequence.info.name == name
    assert sequence.info.text["rgb"].head == f"# color images\n# file: '{name}.bag'\n# timestamp filename\n"
    assert sequence.info.images["depth"].depth_units_per_metre == 5000
    assert sequence.info.images["rgb"].encoding == "rgb8"


def test_rates_and_offsets_are_those_of_the_benchmark() -> None:
    sequence = synthesize(120, width=64, height=48)
    colour, depth = sequence.image_stamps("rgb"), sequence.image_stamps("depth")
    assert np.median(np.diff(colour)) == pytest.approx(1e9 / 30, rel=0.01)
    assert np.median(depth - colour) == pytest.approx(20e6, abs=1e6)
    assert np.ptp(depth - colour) > 1e6
    assert (colour % 1000 == 0).all()
    assert sequence.groundtruth is not None
    assert sequence.accelerometer is not None
    assert (np.diff(sequence.groundtruth.stamps) == 10_000_000).all()
    assert (sequence.groundtruth.stamps % 100_000 == 0).all()
    assert np.median(np.diff(sequence.accelerometer.stamps)) == pytest.approx(2e6, abs=5e4)
    assert (np.diff(sequence.accelerometer.stamps) > 0).all()
    for first, last in ((sequence.groundtruth.stamps, colour), (sequence.accelerometer.stamps, depth)):
        assert first[0] < last[0]
        assert first[-1] > last[-1]


def test_images_come_in_time_order_and_can_be_cut() -> None:
    sequence = synthesize(5, width=64, height=48)
    frames = list(sequence.images())
    assert [frame.stamp for frame in frames] == sorted(frame.stamp for frame in frames)
    cut = list(sequence.images(["rgb"], start=frames[1].stamp, end=frames[6].stamp))
    assert [frame.row for frame in cut] == [1, 2, 3]


def test_infrared_only() -> None:
    sequence = synthesize(2, width=64, height=48, streams=["ir"])
    (first, _) = (frame.load() for frame in sequence.images())
    assert first.encoding == "mono8"
    assert first.pixels is not None
    assert first.pixels.shape == (48, 64)
    assert first.pixels.std() > 10
    assert sequence.groundtruth is None
    assert sequence.accelerometer is None


def test_the_depth_has_the_quantisation_of_the_sensor() -> None:
    frames = synthesize(3).images(["depth"])
    pixels = [frame.load().pixels for frame in frames]
    values = np.unique(np.concatenate([np.unique(image) for image in pixels if image is not None]))
    scale = measure_depth_scale(values)
    assert scale is not None
    assert scale.is_quantised
    assert scale.units_per_metre == pytest.approx(5000, rel=0.05)


def test_the_depth_has_holes_and_a_plausible_range() -> None:
    pixels = next(iter(synthesize(1).images(["depth"]))).load().pixels
    assert pixels is not None
    assert 0.05 < (pixels == 0).mean() < 0.5
    assert pixels[pixels > 0].min() > 0.5 * 5000
    assert pixels.max() < 9 * 5000
    assert (pixels % 5 != 0).any()  # not whole millimetres: a loss in a conversion would show


def test_colour_has_texture_everywhere() -> None:
    pixels = next(iter(synthesize(1).images(["rgb"]))).load().pixels
    assert pixels is not None
    grey = pixels.astype(np.float64).mean(axis=2)
    blocks = grey.reshape(12, 40, 16, 40).std(axis=(1, 3))
    assert (blocks > 1).all()
    assert grey.std() > 25


@pytest.mark.parametrize("seed", range(6))
def test_gravity_fits_the_right_reading_of_the_quaternions(seed: int) -> None:
    sequence = synthesize(60, seed=seed, width=64, height=48)
    assert sequence.groundtruth is not None
    assert sequence.accelerometer is not None
    fits = fit_readings(sequence.groundtruth, sequence.accelerometer)
    assert fits[XYZW].rms_degrees < 3.5
    assert fits[XYZW].up[2] > 0.97
    assert min(fits["w x y z"].rms_degrees, fits["inverse poses"].rms_degrees) > 1.5 * fits[XYZW].rms_degrees
    offset = estimate_offset(sequence.groundtruth, sequence.accelerometer)
    assert offset is not None
    assert abs(offset[0]) < 0.05


def test_a_shifted_accelerometer_fits_worse() -> None:
    sequence = synthesize(300, width=64, height=48)
    assert sequence.groundtruth is not None
    assert sequence.accelerometer is not None
    right = fit_gravity(sequence.groundtruth, sequence.accelerometer)
    shifted = fit_gravity(sequence.groundtruth, sequence.accelerometer, shift_seconds=0.2)
    assert right is not None
    assert shifted is not None
    assert shifted.rms_degrees > 2 * right.rms_degrees


@pytest.mark.parametrize(
    "wrong",
    [
        {"frames": 0},
        {"seed": -1},
        {"camera": "fr4"},
        {"width": 4},
        {"height": 10_000},
        {"streams": ["lidar"]},
    ],
)
def test_wrong_arguments_are_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(UsageError):
        synthesize(**wrong)  # type: ignore[arg-type] - that they are wrong is the point
