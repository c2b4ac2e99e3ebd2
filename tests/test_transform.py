# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A choice of streams, times and frames, and depth in other units."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from tests.made import Made, made
from tumtools.images.codec import image_of_pixels, pixels_of
from tumtools.transform import Selection, first_stamp, rescale_depth, select, transform_losses, without

if TYPE_CHECKING:
    from tumtools.model.image import Image

SECOND = 10**9


def _example() -> Made:
    return made(
        rgb=[3 * SECOND, SECOND, 2 * SECOND, 4 * SECOND],
        depth=[SECOND, 2 * SECOND],
        accelerometer=[(SECOND * n, (0.0, 0.0, float(n))) for n in range(6)],
        groundtruth=[0, SECOND, 5 * SECOND],
    )


def test_nothing_chosen_is_the_sequence_itself() -> None:
    sequence = _example()
    assert select(sequence, Selection()) is sequence


def test_times_are_chosen_with_both_ends_and_keep_the_order_of_the_file() -> None:
    chosen = select(_example(), Selection(start=2 * SECOND, end=3 * SECOND))
    assert chosen.image_stamps("rgb").tolist() == [3 * SECOND, 2 * SECOND]
    assert chosen.image_stamps("depth").tolist() == [2 * SECOND]
    assert chosen.accelerometer is not None
    assert chosen.accelerometer.values[:, 2].tolist() == [2, 3]
    assert chosen.groundtruth is not None
    assert len(chosen.groundtruth) == 0
    assert [(f.stream, f.stamp // SECOND, f.row) for f in chosen.images()] == [
        ("rgb", 2, 1),
        ("depth", 2, 0),
        ("rgb", 3, 0),
    ]


def test_each_nth_image_in_order_of_time_and_all_rows_of_the_signals() -> None:
    chosen = select(_example(), Selection(every=2))
    assert chosen.image_stamps("rgb").tolist() == [3 * SECOND, SECOND]
    assert chosen.image_stamps("depth").tolist() == [SECOND]
    assert chosen.accelerometer is not None
    assert len(chosen.accelerometer) == 6
    assert chosen.info.images["rgb"].count == 2
    assert chosen.info.images["rgb"].nbytes == 200


def test_streams_are_chosen_by_name() -> None:
    chosen = select(_example(), Selection(streams=("depth", "groundtruth")))
    assert list(chosen.info.images) == ["depth"]
    assert chosen.accelerometer is None
    assert chosen.groundtruth is not None
    assert {frame.stream for frame in chosen.images()} == {"depth"}
    assert len(chosen.image_stamps("rgb")) == 0
    assert list(without(_example(), {"rgb"}).info.images) == ["depth"]


def test_a_choice_can_be_read_in_part() -> None:
    chosen = select(_example(), Selection(start=2 * SECOND))
    assert [frame.stamp // SECOND for frame in chosen.images(["rgb"], 3 * SECOND, 3 * SECOND)] == [3]
    assert list(chosen.images(["rgb"], 0, SECOND)) == []


def test_an_empty_choice_has_no_images() -> None:
    chosen = select(_example(), Selection(start=10 * SECOND))
    assert list(chosen.images()) == []


def test_the_first_stamp_is_that_of_the_images_or_else_of_the_signals() -> None:
    assert first_stamp(_example()) == SECOND
    assert first_stamp(select(_example(), Selection(streams=("groundtruth",)))) == 0
    assert first_stamp(made(rgb=[])) is None


def _with_depth(pixels: np.ndarray, encoding: str, units: float) -> Made:
    sequence = made(depth=[SECOND, 2 * SECOND])
    sequence.load_depth = lambda: image_of_pixels(pixels, encoding, units)
    images = dict(sequence.info.images)
    images["depth"] = images["depth"].__class__(2, encoding, 2, 1, units)
    sequence.info = sequence.info.__class__("made", "made", images=images)
    return sequence


def _depth(image: Image) -> list[list[int]]:
    assert (image.encoding, image.depth_units_per_metre) == ("16UC1", 5000.0)
    return pixels_of(image).tolist()


def test_depth_of_the_unit_wanted_is_not_touched() -> None:
    sequence = made(depth=[SECOND])
    rescaled = rescale_depth(sequence, 5000.0)
    assert rescaled.info == sequence.info
    before, after = (next(one.images()).load() for one in (sequence, rescaled))
    assert (before.png, before.pixels) == (after.png, after.pixels)
    images = {"depth": replace(sequence.info.images["depth"], is_uniform=True)}
    sequence.info = replace(sequence.info, images=images)
    assert rescale_depth(sequence, 5000.0) is sequence
    without_depth = made()
    assert rescale_depth(without_depth, 1000.0) is without_depth


def test_each_depth_image_is_rescaled_from_its_own_unit_whatever_the_first_has() -> None:
    counts = np.array([[1000, 0]], np.uint16)
    images = [
        image_of_pixels(counts * 5, "16UC1", 5000.0),
        image_of_pixels(counts, "16UC1", 1000.0),
        image_of_pixels(np.array([[1.0, np.nan]], np.float32), "32FC1", 1.0),
        image_of_pixels(np.array([[1, 0]], np.uint16), "16UC1", 3000.0),
    ]
    for order in ([0, 1, 2, 3], [2, 3, 1, 0]):
        left = [images[number] for number in order]
        sequence = _with_depth(counts, images[order[0]].encoding, images[order[0]].depth_units_per_metre or 0)
        sequence.load_depth = lambda left=left: left.pop(0)  # type: ignore[misc]  # bound now
        sequence._stamps["depth"] = np.arange(4) * SECOND
        rescaled = rescale_depth(sequence, 5000.0)
        found = [_depth(frame.load()) for frame in rescaled.images(["depth"])]
        assert [found[order.index(number)] for number in range(4)] == [[[5000, 0]]] * 3 + [[[2, 0]]]
        assert [(loss.what, loss.count) for loss in transform_losses(rescaled)] == [("pixels rounded", 1)]


def test_metres_among_counts_become_counts_where_any_counts_will_do() -> None:
    counts = np.array([[1000, 0]], np.uint16)
    left = [
        image_of_pixels(counts, "16UC1", 1000.0),
        image_of_pixels(np.array([[1.0, np.nan]], np.float32), "32FC1", 1.0),
    ]
    sequence = _with_depth(counts, "16UC1", 1000.0)
    sequence.load_depth = lambda: left.pop(0)
    loaded = [frame.load() for frame in rescale_depth(sequence, None, 5000.0).images(["depth"])]
    assert [(image.encoding, image.depth_units_per_metre) for image in loaded] == [
        ("16UC1", 1000.0),
        ("16UC1", 5000.0),
    ]


@pytest.mark.parametrize(
    ("pixels", "encoding", "units"),
    [
        (np.array([[1.0, np.nan]], np.float32), "32FC1", 1.0),
        (np.array([[1000, 0]], np.uint16), "16UC1", 1000.0),
    ],
)
def test_depth_is_rescaled_without_loss_where_it_fits(
    pixels: np.ndarray, encoding: str, units: float
) -> None:
    rescaled = rescale_depth(_with_depth(pixels, encoding, units), 5000.0)
    assert [_depth(frame.load()) for frame in rescaled.images(["depth"])] == [[[5000, 0]]] * 2
    assert rescaled.losses() == ()


def test_rounding_is_added_up_once_for_each_frame() -> None:
    rescaled = rescale_depth(_with_depth(np.array([[1.00005, 99.0]], np.float32), "32FC1", 1.0), 5000.0)
    for _ in range(2):  # a frame may be loaded more than once
        for frame in rescaled.images():
            frame.load()
    assert [(loss.what, loss.count) for loss in rescaled.losses()] == [
        ("pixels rounded", 2),
        ("pixels out of range, now without a reading", 2),
    ]
