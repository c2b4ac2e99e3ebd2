# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""TUM107 to TUM109: the rates of the streams, and how they lie to each other."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.evaluate.associate import associate
from tumtools.model.sequence import IMAGE_STREAMS
from tumtools.validate.finding import Severity
from tumtools.validate.rule import Found, Limit, rule
from tumtools.validate.rules.stamps import MIN_ROWS, is_recording, median_period, went_through_float32

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy.typing as npt

    from tumtools.validate.rule import Limits
    from tumtools.validate.subject import Subject

    Stamps = npt.NDArray[np.int64]

_RATES_HZ: Final[dict[str, tuple[float, ...]]] = {
    "rgb": (30.0,),
    "depth": (30.0,),
    "ir": (30.0,),
    "groundtruth": (100.0, 300.0),
    "accelerometer": (500.0,),
}
"""Rates of the benchmark's sensors."""


def _mean_rate(stamps: Stamps) -> float:
    """Return the distinct stamps per second."""
    distinct = np.unique(stamps)
    # Python's integers, since centuries of nanoseconds do not fit into 64 bits.
    return (len(distinct) - 1) * 1e9 / (int(distinct[-1]) - int(distinct[0]))


@rule(
    "TUM107",
    "rate-off",
    Severity.WARNING,
    title="A stream does not come at the rate of the sensor.",
    why=(
        "Frames were left out or repeated, or stamps are scaled; filters tuned for the sensor's "
        "rate go wrong."
    ),
    how=(
        "The rates of the median step and of the mean step are compared with 30 Hz (images), "
        "100 or 300 Hz (ground truth), 500 Hz "
        "(accelerometer)."
    ),
    mend="Nothing to mend where the recording has another rate; ignore the rule for it.",
    limits={"share": Limit(0.1, "of the rate", "largest deviation")},
)
def rate_off(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Compare median rates."""
    for stream, stamps in subject.all_stamps.items():
        period = median_period(stamps)
        if not period or not is_recording(subject, stream) or went_through_float32(stamps):
            continue
        rate, mean = 1e9 / period, _mean_rate(stamps)
        rates = _RATES_HZ[stream]
        # The published accelerometers come in bursts: 825 Hz in the median, 497 Hz in the mean.
        if min(abs(one / expected - 1) for expected in rates for one in (rate, mean)) > limits["share"]:
            wanted = " or ".join(f"{expected:g}" for expected in rates)
            yield Found(
                f"{stream} comes at {rate:.1f} Hz (median; mean {mean:.1f} Hz), the sensor's "
                f"rate is {wanted} Hz",
                subject.stream_place(stream),
                measured=f"{rate:.3f} Hz",
                expected=f"{wanted} Hz",
            )


@rule(
    "TUM108",
    "stream-offset",
    Severity.WARNING,
    title="Colour and depth do not lie close together in time.",
    why="A fusion of images that are apart puts depth beside the objects that move.",
    how=(
        "Median distance of the nearest stamps, share of depth images with a colour image within the limit, "
        "one-to-one pairs by the benchmark's association, longest run of depth images without a partner."
    ),
    mend="Associate before pairing; look for a clock offset between the streams.",
    limits={
        "milliseconds": Limit(20, "ms", "largest distance of a pair"),
        "share": Limit(0.8, "of the images", "least share that has a partner"),
        "run": Limit(30, "images", "longest run without a partner"),
    },
)
def stream_offset(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Pair depth with colour."""
    colour, depth = (
        np.sort(subject.stamps.get(stream, np.empty(0, np.int64))) for stream in ("rgb", "depth")
    )
    if min(len(colour), len(depth)) < MIN_ROWS or went_through_float32(colour) or went_through_float32(depth):
        return
    low, high = max(colour[0], depth[0]), min(colour[-1], depth[-1])
    shared_colour = colour[(colour >= low) & (colour <= high)]
    shared = depth[(depth >= low) & (depth <= high)]
    if min(len(shared_colour), len(shared)) < MIN_ROWS:
        yield Found(
            "colour and depth images hardly overlap in time",
            subject.stream_place("depth"),
            measured=f"{max(int(high) - int(low), 0) / 1e9:.3f} s",
        )
        return
    after = np.clip(np.searchsorted(colour, shared), 1, len(colour) - 1)
    nearest = np.minimum(np.abs(shared - colour[after - 1]), np.abs(colour[after] - shared))
    limit = round(limits["milliseconds"] * 1e6)
    median, within = float(np.median(nearest)) / 1e6, float((nearest < limit).mean())
    pairs = associate(colour, depth, max_difference=limit)
    alone = np.ones(len(depth), bool)
    alone[pairs.second] = False
    run = _longest_run(alone[(depth >= low) & (depth <= high)])
    text = (
        f"nearest colour and depth images are {median:.1f} ms apart in the median, {within:.0%} of the depth "
        f"images have one within {limits['milliseconds']:g} ms, {len(pairs)} pairs, longest run without {run}"
    )
    paired = len(pairs) / min(len(shared), len(shared_colour))
    if median > limits["milliseconds"] or min(within, paired) < limits["share"] or run > limits["run"]:
        yield Found(text, subject.stream_place("depth"), measured=f"{median:.3f} ms")


def _longest_run(flags: npt.NDArray[np.bool_]) -> int:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return int((edges[1::2] - edges[::2]).max()) if len(edges) else 0


@rule(
    "TUM109",
    "groundtruth-coverage",
    Severity.WARNING,
    title="Images lie outside of the ground truth, or in one of its holes.",
    why="An evaluation silently leaves these images out, or interpolates over the hole.",
    how=(
        "An image is covered if a pose lies within the limit of its stamp; longer steps of the "
        "poses are holes."
    ),
    mend="Nothing to mend in a recording; leave the time out of an evaluation.",
    limits={
        "steps": Limit(2, "median steps", "largest distance to a pose"),
        "hole": Limit(0.5, "s", "longest step that is no hole"),
        "share": Limit(0.05, "of the images", "share that may be uncovered"),
    },
)
def groundtruth_coverage(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Look for images without poses."""
    if subject.groundtruth is None or not is_recording(subject, "groundtruth"):
        return
    poses = np.unique(subject.groundtruth.stamps)
    # Of a single pose there is no step; it covers no more than one of the benchmark's would.
    step = median_period(poses) or 1e9 / _RATES_HZ["groundtruth"][0]
    if not len(poses) or went_through_float32(poses):
        return
    for stream in IMAGE_STREAMS:
        stamps = subject.stamps.get(stream)
        if stamps is None or not len(stamps):
            continue
        after = np.clip(np.searchsorted(poses, stamps), 0, len(poses) - 1)
        nearest = np.minimum(np.abs(stamps - poses[np.maximum(after - 1, 0)]), np.abs(poses[after] - stamps))
        bare = np.flatnonzero(nearest > limits["steps"] * step)
        if len(bare) > limits["share"] * len(stamps):
            yield Found(
                f"{len(bare)} of {len(stamps)} {stream} images have no pose within "
                f"{limits['steps'] * step / 1e6:.0f} ms",
                subject.place(stream, int(bare[0])),
                measured=str(len(bare)),
                expected="0",
            )
    order = np.argsort(subject.groundtruth.stamps, kind="stable")
    steps = np.diff(subject.groundtruth.stamps[order])
    holes = np.flatnonzero(steps > limits["hole"] * 1e9)
    if len(holes):
        longest = int(holes[np.argmax(steps[holes])])
        count = "1 hole" if len(holes) == 1 else f"{len(holes)} holes"
        yield Found(
            f"{count} in the ground truth longer than {limits['hole']:g} s, the longest of "
            f"{int(steps[longest]) / 1e9:.2f} s ends here",
            subject.place("groundtruth", int(order[longest + 1])),
            measured=f"{int(steps[longest]) / 1e9:.4f} s",
            expected=f"at most {limits['hole']:g} s",
        )


RULES = (rate_off, stream_offset, groundtruth_coverage)
