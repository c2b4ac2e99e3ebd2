# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""TUM701 to TUM707: archives, bags, MCAP files and rawlogs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from tumtools.errors import MissingInputError
from tumtools.validate.finding import NOWHERE, Place, Severity
from tumtools.validate.rule import Found, Limit, Needs, rule
from tumtools.validate.rules.depth import declared_by_encoding, name_factor

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tumtools.model.camera import CameraInfo
    from tumtools.validate.rule import Limits
    from tumtools.validate.subject import Subject

_ROS2_FORMATS: Final = frozenset({"rosbag2", "mcap"})
_FOCAL_LENGTHS: Final = (0.3, 5.0)
"""Plausible focal lengths, in image widths."""
_SATURATED: Final = 60_000
"""Counts above this in all pixels: float depth that is not in metres."""


@rule(
    "TUM701",
    "container-damaged",
    Severity.ERROR,
    title="The archive or recording is damaged.",
    why="What comes after the damage is lost, and other readers may end there without a word.",
    how=(
        "Structure, lengths, indexes and checksums are checked while it is read. With `--salvage` damage is "
        "a warning, as long as the recording can be opened."
    ),
    mend="Get it again; `tumtools convert --salvage` saves what stands before the damage.",
)
def container_damaged(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Report what could not be read, and how much could."""
    del limits
    for error in subject.damage:
        if isinstance(error, MissingInputError):
            continue  # TUM001
        where = f" ({error.location})" if error.location else ""
        saved = sum(len(frames) for frames in subject.frames.values())
        rest = f"; {saved} images could be read" if saved else ""
        message = f"{error.message}{where}{rest}"
        if subject.salvage and subject.info is not None:
            yield Found(message, severity=Severity.WARNING)
        else:
            yield Found(message, NOWHERE, error.hint or "")


@rule(
    "TUM702",
    "container-order",
    Severity.WARNING,
    title="Messages were recorded out of order, or at other times than their header says.",
    why="Players go by the time of recording: frames come out of order, streams are shifted.",
    how=(
        "Header stamps are compared in the order of recording, and with the time of recording. A recording "
        "made from a live camera lags behind by some milliseconds: below the second limit that is an "
        "information only."
    ),
    mend="Convert: tumtools writes both times the same, in order.",
    limits={
        "milliseconds": Limit(1, "ms", "largest difference of both times that is not mentioned"),
        "seconds": Limit(1, "s", "largest difference that is an information only"),
    },
)
def container_order(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Compare header stamps with their order and time of recording."""
    for stream, times in (subject.recording.times if subject.recording else {}).items():
        if times.backwards:
            yield Found(
                f"{times.backwards} messages of {stream} were recorded before one with an earlier stamp",
                Place(stream=stream, row=times.first_backwards),
                measured=str(times.backwards),
                expected="0",
            )
        apart = times.largest_difference / 1e6
        if apart > limits["milliseconds"]:
            yield Found(
                f"the header stamps of {stream} are up to {apart:.1f} ms off the time of recording",
                Place(stream=stream),
                measured=f"{apart:.3f} ms",
                expected=f"at most {limits['milliseconds']:g} ms",
                severity=None if apart > 1e3 * limits["seconds"] else Severity.INFO,
            )


@rule(
    "TUM703",
    "frame-id-slash",
    Severity.WARNING,
    title="A frame id begins with a slash in a ROS 2 recording.",
    why="tf2 of ROS 2 refuses such names; the transforms do not connect.",
    how="The frame ids of the first messages are looked at.",
    mend="Convert with `--layout modern`, or name the frames with `--frame-id`.",
)
def frame_id_slash(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Look at the frame ids."""
    del limits
    if subject.format not in _ROS2_FORMATS or subject.recording is None:
        return
    for stream, frame_id in subject.recording.frame_ids.items():
        if frame_id.startswith("/"):
            yield Found(f"the frame id is {frame_id!r}", Place(stream=stream), measured=frame_id)


@rule(
    "TUM704",
    "depth-encoding",
    Severity.ERROR,
    title="Encoding and values of the depth disagree.",
    why="ROS means millimetres by 16UC1 and metres by 32FC1; readers go by that.",
    how="The factor measured from the sensor's quantisation (TUM301) is compared with the encoding's.",
    mend="Rescale the depth, or write it as 32FC1 in metres.",
    limits={"deviation": Limit(0.15, "of the factor", "largest deviation")},
    needs=Needs.PIXELS,
)
def depth_encoding(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Compare measured factor and encoding."""
    declared = subject.depth_units_per_metre
    if declared is None or not declared_by_encoding(subject):
        return
    facts = next(facts for facts in subject.frames["depth"] if facts.depth is not None)
    is_float = facts.encoding == "32FC1"
    if is_float and facts.depth is not None and facts.depth.nearest > _SATURATED:
        yield Found("32FC1 depth beyond 60 m in every pixel: this is not metres", Place(stream="depth"))
        return
    scale = subject.depth_scale
    if (
        scale is None
        or not scale.is_quantised
        or abs(scale.units_per_metre / declared - 1) <= limits["deviation"]
    ):
        return
    measured = scale.units_per_metre / (1000 if is_float else 1)
    meant = "metres" if is_float else "millimetres"
    yield Found(
        f"{facts.encoding} means {meant}, but the depth has {measured:.4g} counts a metre"
        f"{name_factor(scale.units_per_metre)}",
        Place(stream="depth"),
        measured=f"{measured:.4g}",
        expected="1" if is_float else "1000",
    )


@rule(
    "TUM705",
    "camera-info",
    Severity.ERROR,
    title="The camera's calibration is missing, changes, or cannot be right.",
    why="Nothing can be projected without it; a calibration of another image size is off by its ratio.",
    how=(
        "Each image stream of a ROS recording needs a CameraInfo of its size, with a plausible "
        "K, in ROS 2 spelling. In recordings of other programs all messages are compared with the first."
    ),
    mend="Convert with `--camera`.",
)
def camera_info(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Look at the calibrations."""
    del limits
    if subject.recording is None or subject.info is None:
        return
    for stream, camera in subject.recording.cameras.items():
        images = subject.info.images[stream]
        problem = "" if camera is None else _implausible(camera)
        if camera is None:
            yield Found("the stream has no CameraInfo", Place(stream=stream), severity=Severity.WARNING)
        elif images.width and (camera.width, camera.height) != (images.width, images.height):
            yield Found(
                f"CameraInfo is of {camera.width}x{camera.height} pixels, "
                f"the images have {images.width}x{images.height}",
                Place(stream=stream),
            )
        elif problem:
            yield Found(problem, Place(stream=stream))
    for stream, count in subject.recording.other_cameras.items():
        yield Found(
            f"{count} messages of CameraInfo differ from the first; a sequence has one calibration",
            Place(stream=stream),
            measured=str(count),
            expected="0",
            severity=Severity.WARNING,
        )
    for topic in subject.recording.old_definitions:
        yield Found(
            f"the definition of {topic} names its fields D, K, R, P as ROS 1 does; readers of "
            f"ROS 2 expect d, k, r, p",
            NOWHERE,
        )


def _implausible(camera: CameraInfo) -> str:
    fx, cx, fy, cy = camera.k[0], camera.k[2], camera.k[4], camera.k[5]
    low, high = (share * camera.width for share in _FOCAL_LENGTHS)
    if not (low < fx < high and low < fy < high):
        return f"the focal lengths {fx:g} and {fy:g} are implausible for {camera.width} columns"
    if not (0 < cx < camera.width and 0 < cy < camera.height):
        return f"the principal point ({cx:g}, {cy:g}) lies outside of the image"
    return ""


@rule(
    "TUM706",
    "topics-unclear",
    Severity.ERROR,
    title="It is not clear which topics of a recording are the streams.",
    why="Nothing can be checked before it is, and a reader that takes the first may take the wrong one.",
    how=(
        "Topics are found by type and name. It is unclear if several fit one stream, or if the one that was "
        "asked for is not there."
    ),
    mend="Name the topic: `--topic STREAM=TOPIC`.",
)
def topics_unclear(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Report why the recording was not opened."""
    del limits
    if subject.unclear is not None:
        yield Found(subject.unclear.message, NOWHERE, subject.unclear.hint or "")


@rule(
    "TUM707",
    "digest-differs",
    Severity.ERROR,
    title="The content is not what was written: it differs from the digest that the file carries.",
    why="Somebody or something has changed the file since; it is not the sequence that it says it is.",
    how=(
        "Files that tumtools writes carry a SHA-256 of each of their streams: of stamps and values, and of "
        "the images' files or pixels. Each stream is hashed again."
    ),
    mend="Get it again, or convert the source again. To keep a change that was meant, convert the file.",
    needs=Needs.PIXELS,
)
def digest_differs(subject: Subject, limits: Limits) -> Iterator[Found]:
    """Compare the digests; what could not be read has been told."""
    del limits
    unread = {stream for stream, frames in subject.frames.items() if any(one.error for one in frames)}
    unread |= subject.missing.keys()
    for one in subject.digests if not subject.damage else ():
        if one.same or one.stream in unread:
            continue
        if one.found is None:
            what = "the stream is gone"
        elif one.kept is None:
            what = "the stream was not there when the file was written"
        elif one.kept.count != one.found.count:
            what = f"there are {one.found.count} of {one.kept.count} rows"
        else:
            what = "the stream is not what was written"
        yield Found(
            what,
            Place(stream=one.stream),
            measured="" if one.found is None else one.found.value,
            expected="" if one.kept is None else one.kept.value,
        )


RULES = (
    container_damaged,
    container_order,
    frame_id_slash,
    depth_encoding,
    camera_info,
    topics_unclear,
    digest_differs,
)
