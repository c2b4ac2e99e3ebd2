# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""TUM301 to TUM306: what the depth values say about themselves."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.validate.finding import Severity
from tumtools.validate.frames import COUNTS, NO_READING_ELSEWHERE
from tumtools.validate.rule import Found, Limit, Needs, rule

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tumtools.validate.depth_scale import DepthScale
    from tumtools.validate.frames import DepthFacts, FrameFacts
    from tumtools.validate.rule import Limits
    from tumtools.validate.subject import Subject

ROS_FORMATS: Final = frozenset({"rosbag1", "rosbag2", "mcap"})
KNOWN_FACTORS: Final = {
    5000.0: "the benchmark's 5000",
    1000.0: "millimetres",
    10000.0: "tenths of a millimetre, or the factor 5000 applied to what was doubled",
    100.0: "centimetres",
    256.0: "1/256 m",
    6553.5: "65535 for 10 m",
}
"""Depth factors in use."""
_NEAR_A_KNOWN_FACTOR: Final = 0.08
_SWAPPED: Final = 2.0
"""How much rougher an image must be than with its bytes swapped."""
_LEAST_VALUES: Final = 8
_EIGHT_BITS: Final = 256


def _frames(subject: Subject) -> list[tuple[FrameFacts, DepthFacts]]:
    return [(facts, facts.depth) for facts in subject.frames.get("depth", []) if facts.depth is not None]


def _is_swapped(depth: DepthFacts) -> bool:
    return depth.swapped_ratio > _SWAPPED


def _is_coarse(depth: DepthFacts) -> bool:
    """Whether 8 bits or fewer carry all there is: one byte is the same in all values."""
    return depth.distinct >= _LEAST_VALUES and (
        depth.low_bytes == 1 or (depth.high_bytes == 1 and depth.nearest < _EIGHT_BITS)
    )


def declared_by_encoding(subject: Subject) -> bool:
    """Whether nothing but the encoding of a ROS message says what the depth's unit is; see TUM704."""
    if subject.format not in ROS_FORMATS:
        return False
    facts = next((facts for facts in subject.frames.get("depth", []) if facts.depth is not None), None)
    return facts is not None and facts.png_kind is None and facts.encoding in {"16UC1", "32FC1"}


def name_factor(units_per_metre: float) -> str:
    """Say which known depth factor a measured one is."""
    for factor, name in KNOWN_FACTORS.items():
        if abs(units_per_metre / factor - 1) < _NEAR_A_KNOWN_FACTOR:
            return f"; that is {name}"
    return ""


@rule(
    "TUM301",
    "depth-scale",
    Severity.ERROR,
    title="The depth images have another factor than the one declared.",
    why="All distances, and with them every map and trajectory, are wrong by that factor.",
    how=(
        "A structured-light sensor measures disparity in steps of 1/8 pixel, so its depths "
        "lie on a grid that "
        "is uniform in 1/Z. The step of the values found gives the counts per metre, whatever the scene."
    ),
    mend="Rescale the depth (`tumtools convert`), or declare the factor that fits.",
    limits={
        "deviation": Limit(0.15, "of the factor", "largest deviation over all images"),
        "frame_deviation": Limit(0.4, "of the factor", "largest deviation of one image"),
    },
    needs=Needs.PIXELS,
)
def depth_scale(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Compare measured and declared factor, over all images and for each."""
    declared, frames = subject.depth_units_per_metre, _frames(subject)
    if (
        declared is None
        or declared_by_encoding(subject)
        or any(_is_swapped(depth) or _is_coarse(depth) for _, depth in frames)
    ):
        return
    scale = subject.depth_scale
    if _is_off(scale, declared, limits["deviation"]) and scale is not None:
        yield Found(
            f"the depth has {scale.units_per_metre:.0f} counts a metre, {declared:.0f} are declared"
            f"{name_factor(scale.units_per_metre)}",
            subject.stream_place("depth"),
            "rescale it, or read it with the factor that fits",
            f"{scale.units_per_metre:.1f}",
            f"{declared:.1f}",
        )
        return
    for facts, depth in frames:
        if depth.scale is not None and _is_off(depth.scale, declared, limits["frame_deviation"]):
            yield Found(
                f"this image has {depth.scale.units_per_metre:.0f} counts a metre, "
                f"{declared:.0f} are declared"
                f"{name_factor(depth.scale.units_per_metre)}",
                subject.image_place("depth", facts.row),
                measured=f"{depth.scale.units_per_metre:.1f}",
                expected=f"{declared:.1f}",
            )


def _is_off(scale: DepthScale | None, declared: float, deviation: float) -> bool:
    return scale is not None and scale.is_quantised and abs(scale.units_per_metre / declared - 1) > deviation


@rule(
    "TUM302",
    "depth-range",
    Severity.WARNING,
    title="Depth values lie outside of the sensor's range.",
    why=(
        'What a sensor cannot measure is an error of scale or a code for "no reading" that '
        "others take for depth."
    ),
    how='Readings below and above the range are counted; 65535 is what other cameras write for "no reading".',
    mend="Write 0 where there is no reading; check the depth factor.",
    limits={
        "nearest": Limit(0.4, "m", "least distance"),
        "farthest": Limit(10, "m", "greatest distance"),
        "share": Limit(0.01, "of the readings", "share that may lie outside"),
    },
    needs=Needs.PIXELS,
)
def depth_range(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Count readings outside of the range."""
    factor, frames = subject.depth_units_per_metre, _frames(subject)
    if factor is None or not frames:
        return
    coded = [(facts, depth) for facts, depth in frames if depth.no_reading_elsewhere]
    if coded:
        facts, depth = coded[0]
        yield Found(
            f"65535 in {len(coded)} images ({depth.no_reading_elsewhere} pixels of the "
            f'first): "no reading" is 0',
            subject.image_place("depth", facts.row),
        )
    histogram = subject.depth_histogram
    readings = int(histogram[1:NO_READING_ELSEWHERE].sum())
    near = int(histogram[1 : min(int(np.ceil(limits["nearest"] * factor)), COUNTS)].sum())
    far = int(histogram[min(int(limits["farthest"] * factor) + 1, COUNTS - 1) : NO_READING_ELSEWHERE].sum())
    for count, limit, word in ((near, limits["nearest"], "below"), (far, limits["farthest"], "above")):
        if readings and count > limits["share"] * readings:
            yield Found(
                f"{count / readings:.1%} of the readings lie {word} {limit:g} m",
                subject.stream_place("depth"),
                measured=f"{count / readings:.4f}",
                expected=f"at most {limits['share']:g}",
            )


@rule(
    "TUM303",
    "depth-invalid-share",
    Severity.WARNING,
    title="Hardly any depth, or depth without a single hole.",
    why="Without depth there is nothing to track; depth without holes was filled in or rendered.",
    how="The share of zeros in the image of middle rank, and whether all images together have none.",
    mend="Nothing to mend; know what you evaluate on.",
    limits={"share": Limit(0.6, "of the pixels", "largest share without a reading")},
    needs=Needs.PIXELS,
)
def depth_invalid_share(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Look at the share of zeros."""
    shares = [depth.zero_share for _, depth in _frames(subject)]
    if not shares:
        return
    median = float(np.median(shares))
    if median > limits["share"]:
        message = f"{median:.0%} of the pixels of the median depth image have no reading"
        yield Found(message, subject.stream_place("depth"), measured=f"{median:.3f}")
    elif not subject.depth_histogram[0] and not subject.depth_histogram[NO_READING_ELSEWHERE]:
        message = "not one pixel of all depth images is without a reading: this is filled or rendered depth"
        yield Found(message, subject.stream_place("depth"), measured="0")


@rule(
    "TUM304",
    "depth-byte-order",
    Severity.ERROR,
    title="The bytes of the depth are swapped.",
    why="PNG keeps 16-bit values with the high byte first; a writer that forgets it makes noise of depth.",
    how=(
        "Steps between neighbours are compared with those after swapping the bytes: the right "
        "order is the smoother."
    ),
    mend="Swap the bytes.",
    needs=Needs.PIXELS,
)
def depth_byte_order(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Compare the roughness of both byte orders."""
    del limits
    frames = _frames(subject)
    swapped = [(facts, depth) for facts, depth in frames if _is_swapped(depth) and not _is_coarse(depth)]
    if swapped:
        facts, depth = swapped[0]
        yield Found(
            f"{len(swapped)} of {len(frames)} depth images are smoother with their bytes swapped",
            subject.image_place("depth", facts.row),
            measured=f"{depth.swapped_ratio:.1f}",
            expected="below 1",
        )


@rule(
    "TUM305",
    "depth-8bit",
    Severity.ERROR,
    title="Depth images carry 8 bits or fewer.",
    why="Steps of many centimetres; such depth was saved for looking at, not for measuring.",
    how="One of the two bytes is the same in all values of an image.",
    mend="Export the depth again with 16 bits.",
    needs=Needs.PIXELS,
)
def depth_8bit(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Look for a constant byte."""
    del limits
    frames = _frames(subject)
    coarse = [(facts, depth) for facts, depth in frames if _is_coarse(depth)]
    if coarse:
        facts, depth = coarse[0]
        byte = "low" if depth.low_bytes == 1 else "high"
        yield Found(
            f"the {byte} byte of all values is the same in {len(coarse)} of {len(frames)} depth images",
            subject.image_place("depth", facts.row),
            measured=f"{depth.distinct} values",
        )


@rule(
    "TUM306",
    "depth-not-quantised",
    Severity.INFO,
    title="No quantisation of a structured-light sensor was found.",
    why="The depth is rendered, filtered or of another kind of sensor; TUM301 cannot tell its factor.",
    how="The steps of 1/Z scatter too widely, or too few values occur.",
    mend="Nothing to mend; check the factor by hand.",
    needs=Needs.PIXELS,
)
def depth_not_quantised(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Say that the depth factor cannot be measured."""
    del limits
    frames = _frames(subject)
    if not frames or any(_is_swapped(depth) or _is_coarse(depth) for _, depth in frames):
        return
    scale = subject.depth_scale
    if scale is None:
        yield Found("too few depth values to measure the depth factor", subject.stream_place("depth"))
    elif not scale.is_quantised:
        yield Found(
            "the depth has no quantisation of a sensor; its factor cannot be measured",
            subject.stream_place("depth"),
            measured=f"spread {scale.spread:.2f}, steps of {scale.coarseness:g} counts",
        )


RULES = (depth_scale, depth_range, depth_invalid_share, depth_byte_order, depth_8bit, depth_not_quantised)
