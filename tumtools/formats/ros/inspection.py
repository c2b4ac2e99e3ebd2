# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What a recording says beyond the sequence in it: frame ids, calibrations, times. For `validate`."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.errors import InputError
from tumtools.formats.ros import signals
from tumtools.model.sequence import IMAGE_STREAMS

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from tumtools.formats.ros.codec import Message
    from tumtools.formats.ros.incoming import RosSequence
    from tumtools.formats.ros.recording import Channel
    from tumtools.model.camera import CameraInfo

_ROS1_FIELD: Final = re.compile(r"^\s*float64\[[0-9]*\]\s+[DKRP]\s*$", re.MULTILINE)
"""A field of CameraInfo as ROS 1 spells it; ROS 2 has small letters."""


@dataclass(frozen=True, slots=True)
class TimeFacts:
    """How the log times of an image stream lie to its header stamps.

    Attributes:
        backwards: Messages whose header stamp is before that of the message recorded before.
        first_backwards: Number of the first of them.
        largest_difference: Largest distance of log time and header stamp, nanoseconds.

    """

    backwards: int
    first_backwards: int
    largest_difference: int


@dataclass(frozen=True, slots=True)
class RecordingFacts:
    """What a recording says beyond the sequence in it.

    Attributes:
        frame_ids: Of the first message of each stream that has a header.
        cameras: The first CameraInfo of each image stream; None where there is none.
        old_definitions: Topics of CameraInfo in CDR whose definition has the field names of ROS 1.
        times: Of each image stream with messages.
        other_cameras: Image stream -> messages of CameraInfo that differ from the first, if there are any.

    """

    frame_ids: dict[str, str]
    cameras: dict[str, CameraInfo | None]
    old_definitions: tuple[str, ...]
    times: dict[str, TimeFacts]
    other_cameras: Mapping[str, int] = field(default_factory=dict)


def inspect(sequence: RosSequence) -> RecordingFacts:
    """Look at the first message of each topic, and at the stamps of all images.

    Raises:
        InputError: The recording is damaged.

    """
    infos = sequence.info_channels
    cameras: dict[str, CameraInfo | None] = {}
    for stream in IMAGE_STREAMS:
        if stream in sequence.channels:
            message = _first(sequence, infos.get(stream))
            cameras[stream] = None if message is None else signals.camera_info(message)
    return RecordingFacts(
        frame_ids=dict(_frame_ids(sequence)),
        cameras=cameras,
        old_definitions=tuple(
            channel.topic
            for channel in infos.values()
            if channel.encoding == "cdr" and _ROS1_FIELD.search(channel.definition)
        ),
        times={stream: _times(sequence, stream) for stream in cameras if sequence.info.images[stream].count},
        other_cameras=sequence.other_cameras,
    )


def _first(sequence: RosSequence, channel: Channel | None) -> Message | None:
    if channel is None:
        return None
    return next(sequence.decode([channel]), None)


def _frame_ids(sequence: RosSequence) -> Iterator[tuple[str, str]]:
    for stream, channel in sequence.channels.items():
        try:
            message = _first(sequence, channel)
        except InputError:
            continue  # it is reported where the messages are read
        header = message.get("header") if message else None
        if isinstance(header, dict):
            yield stream, str(header.get("frame_id", ""))


def _times(sequence: RosSequence, stream: str) -> TimeFacts:
    stamps, log_times = sequence.times(stream)
    back = np.flatnonzero(stamps[1:] < stamps[:-1]) + 1
    largest = int(np.abs(stamps - log_times).max()) if len(stamps) else 0
    return TimeFacts(len(back), int(back[0]) if len(back) else 0, largest)
