# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""TUM201 to TUM205: the images as such."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.validate.finding import Severity
from tumtools.validate.rule import Found, Limit, Needs, rule

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tumtools.validate.frames import FrameFacts
    from tumtools.validate.rule import Limits
    from tumtools.validate.subject import Subject

_SIZE: Final = (640, 480)
_WANTED: Final[dict[str, tuple[str, tuple[str, ...]]]] = {
    "rgb": ("8-bit RGB", ("rgb8", "bgr8")),
    "depth": ("16-bit grey", ("16UC1", "mono16", "32FC1")),
    "ir": ("grey", ("mono8", "mono16", "16UC1", "rgb8", "bgr8")),
}
"""What the images of a stream are, and the encodings that mean this."""
_PALETTE: Final = 3


@rule(
    "TUM201",
    "image-unreadable",
    Severity.ERROR,
    title="An image is damaged.",
    why="Readers stop there, or take the half that they can decode for the whole.",
    how=(
        "Signature, chunks, their checksums and the compressed data are checked; `--quick` reads "
        "the header only."
    ),
    mend="Get the sequence again.",
)
def image_unreadable(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Report what could not be loaded or decoded."""
    del limits
    for facts in _all(subject):
        if facts.error is not None:
            where = f" ({facts.error.location})" if facts.error.location else ""
            yield Found(f"{facts.error.message}{where}", subject.image_place(facts.stream, facts.row))


@rule(
    "TUM202",
    "image-format",
    Severity.ERROR,
    title="An image is not of the kind or size that its stream has.",
    why="Readers cast what they find: 8-bit depth becomes metres of 0.05, a palette becomes grey.",
    how=(
        "Bit depth, colour type and size are read from the header; the size is compared with that of most "
        "images of the stream, and with 640x480."
    ),
    mend="Write colour as 8-bit RGB and depth as 16-bit grey, all of one size.",
)
def image_format(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Look at kind and size."""
    del limits
    for stream, frames in subject.frames.items():
        readable = [facts for facts in frames if facts.encoding]
        if not readable:
            continue
        kind, encodings = _WANTED[stream]
        sizes = Counter((facts.width, facts.height) for facts in readable)
        size, _ = sizes.most_common(1)[0]  # of equally many, that of the first image
        if size != _SIZE:
            row = next(facts.row for facts in readable if (facts.width, facts.height) == size)
            yield Found(
                f"the {stream} images have {size[0]}x{size[1]} pixels, the benchmark's have 640x480",
                subject.image_place(stream, row),
                severity=Severity.WARNING,
            )
        for facts in readable:
            palette = facts.png_kind is not None and facts.png_kind[1] == _PALETTE
            if facts.encoding not in encodings or palette:
                bits, _ = facts.png_kind or (0, 0)
                found = (
                    "an image with a palette"
                    if palette
                    else f"{facts.encoding}{f', {bits} bit' if bits else ''}"
                )
                yield Found(f"{found} instead of {kind}", subject.image_place(stream, facts.row))
            elif (facts.width, facts.height) != size:
                yield Found(
                    f"{facts.width}x{facts.height} pixels, {_share(sizes[size], len(readable))} "
                    f"{size[0]}x{size[1]}",
                    subject.image_place(stream, facts.row),
                )


def _share(count: int, total: int) -> str:
    return f"{count} of the {total} images of the stream have" if count > 1 else "the first image has"


@rule(
    "TUM203",
    "image-repeated",
    Severity.WARNING,
    title="Two images with different stamps have the same pixels.",
    why="A driver that repeats the last frame when it falls behind makes a camera that stands still.",
    how=(
        "Checksums of all images of a stream are compared; blank images are left out. A sensor's "
        "noise never repeats."
    ),
    mend="Remove the repetition from the list.",
    needs=Needs.PIXELS,
)
def image_repeated(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Compare checksums."""
    del limits
    for frames in subject.frames.values():
        seen: dict[tuple[int, int, int], FrameFacts] = {}
        for facts in frames:
            if facts.fingerprint is None or facts.constant is not None:
                continue
            first = seen.setdefault(facts.fingerprint, facts)
            if first.stamp != facts.stamp:
                here, other = (subject.image_place(one.stream, one.row) for one in (facts, first))
                before = f"{(facts.stamp - first.stamp) / 1e9:.3f} s before"
                if here.file and here.file == other.file:
                    yield Found(
                        f"the image is listed twice, the first time {before}",
                        subject.place(facts.stream, facts.row),
                    )
                else:
                    yield Found(f"the same pixels as {other}, {before}", here)


@rule(
    "TUM204",
    "image-blank",
    Severity.WARNING,
    title="An image has one value everywhere.",
    why="A covered lens or a failed transfer; trackers lose the camera there.",
    how="Smallest and largest value are compared.",
    mend="Remove it from the list.",
    needs=Needs.PIXELS,
)
def image_blank(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Look for constant images."""
    del limits
    for facts in _all(subject):
        if facts.constant is not None:
            yield Found(f"all pixels are {facts.constant}", subject.image_place(facts.stream, facts.row))


@rule(
    "TUM205",
    "colour-channels-swapped",
    Severity.WARNING,
    title="Red and blue seem to be swapped (a guess; off unless selected).",
    why="OpenCV's order is blue, green, red; a colour image saved without care has blue faces.",
    how="Rooms under lamps are warmer than blue: the mean of blue over red is compared with the limit.",
    mend="Swap the channels.",
    limits={"ratio": Limit(1.15, "blue over red", "largest ratio of the means")},
    needs=Needs.PIXELS,
    enabled=False,
)
def colour_channels_swapped(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Compare the means of red and blue."""
    pairs = [
        (facts.red, facts.blue)
        for facts in subject.frames.get("rgb", [])
        if facts.red is not None and facts.blue is not None
    ]
    if not pairs:
        return
    red, blue = np.mean(np.array(pairs), axis=0)
    if blue > limits["ratio"] * red:
        yield Found(
            f"blue is {blue / max(red, 1e-9):.2f} times as bright as red",
            subject.stream_place("rgb"),
            measured=f"{blue / max(red, 1e-9):.3f}",
            expected=f"at most {limits['ratio']:g}",
        )


def _all(subject: Subject) -> Iterator[FrameFacts]:
    for frames in subject.frames.values():
        yield from frames


RULES = (image_unreadable, image_format, image_repeated, image_blank, colour_channels_swapped)
