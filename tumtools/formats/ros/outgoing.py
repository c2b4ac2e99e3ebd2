# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""From a sequence to messages: channels, and serialised messages in order of their stamps.

At equal stamps the order is: calibration, image (rgb, depth, ir), accelerometer, tf, pose.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.errors import OutputError, UsageError
from tumtools.formats import metadata
from tumtools.formats.cameras import chosen_calibration, known_camera
from tumtools.formats.options import Plan
from tumtools.formats.ros import messages, serialise
from tumtools.formats.ros.layouts import TF_TOPIC
from tumtools.formats.ros.recording import MessageEncoding, OutChannel, OutMessage
from tumtools.formats.ros.rows import Rows, signal_rows
from tumtools.formats.ros.style import Style, estimated_bytes
from tumtools.images.parallel import ordered_map
from tumtools.model.digest import to_strings
from tumtools.model.sequence import IMAGE_STREAMS, Frame, Sequence, streams_of
from tumtools.model.time import NANOSECONDS_PER_SECOND, format_stamp

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping


_SECONDS_LIMIT: Final[dict[MessageEncoding, int]] = {"cdr": 2**31, "ros1": 2**32}
"""First second that does not fit; before 1970 nothing does, since log times are unsigned."""


def style_plan(sequence: Sequence, style: Style, *, compressed: bool) -> Plan:
    """Return the estimated size, and what is assumed.

    Args:
        sequence: What would be written.
        style: How.
        compressed: Whether chunks are compressed.

    """
    nbytes = estimated_bytes(sequence, style, compressed=compressed)
    return Plan(nbytes=nbytes, warnings=outgoing(sequence, style).warnings)


@dataclass(frozen=True, slots=True)
class Outgoing:
    """A sequence as messages.

    Attributes:
        channels: Topics to write.
        metadata: What messages have no field for.
        warnings: What was assumed.

    """

    channels: tuple[OutChannel, ...]
    metadata: Mapping[str, str]
    warnings: tuple[str, ...]
    _sequence: Sequence = field(repr=False)
    _style: Style = field(repr=False)
    _numbers: Mapping[str, int] = field(repr=False)

    @property
    def compressed_channels(self) -> frozenset[int]:
        """Channels whose messages are compressed images."""
        kinds = enumerate(channel.type for channel in self.channels)
        return frozenset(number for number, kind in kinds if kind == messages.COMPRESSED_IMAGE)

    @property
    def keeps_digest(self) -> bool:
        """Whether there will be a digest to keep."""
        return self._sequence.noted_digest() is not None

    def digest(self) -> dict[str, str]:
        """Return the digest of what has been written, as strings; empty if nobody notes it.

        It is complete when all messages have been taken.
        """
        noted = self._sequence.noted_digest()
        return {} if noted is None else to_strings(noted)

    def images(self) -> Iterator[OutMessage]:
        """Yield calibrations and images, serialised by `jobs` threads, in order.

        Raises:
            InputError: An image is damaged.

        """
        return _images(self._sequence, self._style, self._numbers)

    def rows(self) -> tuple[Rows, ...]:
        """Return the messages of the signals; at equal stamps images come first, then these in order."""
        return tuple(signal_rows(self._sequence, self._style, self._numbers))

    def messages(self) -> Iterator[OutMessage]:
        """Yield the messages of `images` and `rows`, in order.

        Raises:
            InputError: An image is damaged.

        """
        # The merge is stable: at equal stamps it keeps the order of its arguments.
        return heapq.merge(
            self.images(), *(rows.messages() for rows in self.rows()), key=lambda message: message.stamp
        )


def outgoing(sequence: Sequence, style: Style) -> Outgoing:
    """Plan the channels for a sequence.

    Raises:
        OutputError: A stamp does not fit into the messages.

    """
    _check_stamps(sequence, style)
    channels: list[OutChannel] = []
    numbers: dict[str, int] = {}
    places: dict[str, str] = {}

    def add(key: str, topic: str, kind: str) -> None:
        numbers[key] = len(channels)
        channels.append(OutChannel(topic, kind))

    topics = {**style.layout.topics, **style.options.topics}
    info_topics = _info_topics(style, [stream for stream in IMAGE_STREAMS if stream in sequence.info.images])
    for stream in IMAGE_STREAMS:
        if stream in sequence.info.images:
            compressed = stream not in style.pixel_streams
            topic = topics[stream] + (
                "/compressed" if compressed and stream not in style.options.topics else ""
            )
            add(f"{stream} info", info_topics[stream], messages.CAMERA_INFO)
            add(stream, topic, messages.COMPRESSED_IMAGE if compressed else messages.IMAGE)
            places[stream] = topic
    if sequence.accelerometer is not None:
        add("accelerometer", topics["accelerometer"], messages.IMU)
        places["accelerometer"] = topics["accelerometer"]
    if sequence.groundtruth is not None:
        places["groundtruth"] = topics["groundtruth"] if style.groundtruth in {"pose", "both"} else TF_TOPIC
        if style.groundtruth in {"tf", "both"}:
            add("tf", TF_TOPIC, messages.TF_MESSAGE)
        if style.groundtruth in {"pose", "both"}:
            add("groundtruth", topics["groundtruth"], messages.POSE_STAMPED)
    _check_topics(channels, style.options.topics)
    kept = metadata.gather(sequence, places, style.options.camera)
    if style.depth_encoding != "png":
        kept = replace(kept, depth_units_per_metre=None)  # the message says it
    strings = metadata.to_strings(kept)
    return Outgoing(tuple(channels), strings, tuple(_warnings(sequence, style)), sequence, style, numbers)


def _check_topics(channels: list[OutChannel], asked: Mapping[str, str]) -> None:
    """Refuse empty names, and two kinds of messages under one name, which no reader could tell apart."""
    for stream, name in asked.items():
        if not name:
            raise UsageError(f"--topic {stream}=: a topic cannot have an empty name")
    topics = [channel.topic for channel in channels]
    for topic in topics:
        if topics.count(topic) > 1:
            raise UsageError(
                f"two streams would be written to the topic {topic}", hint="name another one with --topic"
            )


def _info_topics(style: Style, streams: list[str]) -> dict[str, str]:
    """Return where the calibrations go: beside their images, below them where streams lie side by side."""
    asked = style.options.topics
    beside = {
        stream: f"{asked[stream].rpartition('/')[0]}/camera_info"
        if stream in asked
        else style.layout.info_topics[stream]
        for stream in streams
    }
    taken = list(beside.values())
    return {
        stream: f"{asked[stream]}/camera_info" if stream in asked and taken.count(topic) > 1 else topic
        for stream, topic in beside.items()
    }


def _check_stamps(sequence: Sequence, style: Style) -> None:
    limit = _SECONDS_LIMIT[style.encoding] * NANOSECONDS_PER_SECOND
    columns = {stream: sequence.image_stamps(stream) for stream in sequence.info.images}
    for name, signal in (("accelerometer", sequence.accelerometer), ("groundtruth", sequence.groundtruth)):
        if signal is not None:
            columns[name] = signal.stamps
    for stream, stamps in columns.items():
        outside = np.flatnonzero((stamps < 0) | (stamps >= limit))
        if len(outside):
            text = format_stamp(int(stamps[outside[0]]), 9)
            raise OutputError(
                f"the stamp {text} of {stream} (row {outside[0]}) does not fit into a ROS time "
                f"(1970 to {1970 + _SECONDS_LIMIT[style.encoding] // 31_556_952})",
                hint="this format cannot hold the sequence; its stamps are no time since 1970, or shift them",
            )


def _warnings(sequence: Sequence, style: Style) -> Iterator[str]:
    options, there = style.options, streams_of(sequence)
    for flag, asked in (("--topic", options.topics), ("--frame-id", options.frame_ids)):
        for stream, name in asked.items():
            if stream not in there:
                yield f"{flag} {stream}={name} has no effect: there is no {stream} to write"
    known = style.options.cameras.keys() | sequence.cameras.keys()
    assumed = [stream for stream in sequence.info.images if stream not in known]
    if assumed and known_camera(sequence, style.options) is None:
        yield (
            f"the camera is unknown, so the calibration written for {' and '.join(assumed)} is that of ROS's "
            "default (525, 525, 319.5, 239.5); name it with --camera"
        )


def _images(sequence: Sequence, style: Style, numbers: Mapping[str, int]) -> Iterator[OutMessage]:
    def messages_of(frame: Frame) -> tuple[Frame, bytes, tuple[bytes | memoryview, ...]]:
        image = frame.load()
        camera = chosen_calibration(sequence, style.options, frame.stream, image.width, image.height)
        common = (
            style.encoding,
            style.frame_id(sequence, frame.stream, frame.frame_id),
            frame.stamp,
            frame.row,
        )
        info = serialise.camera_info(*common, camera)
        if frame.stream not in style.pixel_streams:
            return frame, info, serialise.compressed_image(*common, image)
        wanted = style.depth_encoding if frame.stream == "depth" else style.color_encoding
        return frame, info, serialise.raw_image(*common, image, wanted)

    for frame, info, parts in ordered_map(messages_of, sequence.images(), style.options.jobs):
        yield OutMessage(numbers[f"{frame.stream} info"], frame.stamp, (info,))
        yield OutMessage(numbers[frame.stream], frame.stamp, parts, is_image=True)
