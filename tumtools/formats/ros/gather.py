# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Read small signals, and the stamps of large ones, in a single pass over a recording."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from tumtools.errors import InputError
from tumtools.formats.ros.besides import Lateness, lateness
from tumtools.formats.ros.collectors import (
    AccelerometerCollector,
    Collector,
    ConstantCollector,
    PoseCollector,
    StampCollector,
    TransformCollector,
)
from tumtools.formats.ros.tf import TransformTree
from tumtools.model.sequence import IMAGE_STREAMS

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from contextlib import AbstractContextManager

    from tumtools.formats.ros.codec import MessageType
    from tumtools.formats.ros.collectors import Times
    from tumtools.formats.ros.recording import Channel, Recording
    from tumtools.formats.ros.topics import Resolution
    from tumtools.model.signals import Accelerometer, Trajectory

_AnyCollector = Collector | StampCollector | ConstantCollector


@dataclass(slots=True)
class Gathered:
    """What one pass over a recording gives.

    Attributes:
        accelerometer: None if there is no channel for it.
        poses: Ground truth of a channel with poses, or of our own transforms; None if there is none.
        frame_ids: Signal -> coordinate frame of its first message.
        tree: Transforms that the ground truth of a foreign recording is composed from.
        times: Image stream -> log times and header stamps, of foreign recordings.
        other_frames: Stream -> messages whose frame id is not that of the first.
        late: Stream -> how its messages were logged at other times than their stamps say.
        other_cameras: Image stream -> messages of CameraInfo that differ from the first, if there are any.
        besides: Topic and what its messages say beside the stream -> how many do.

    """

    accelerometer: Accelerometer | None = None
    poses: Trajectory | None = None
    frame_ids: dict[str, str] = field(default_factory=dict)
    tree: TransformTree = field(default_factory=TransformTree)
    times: dict[str, Times] = field(default_factory=dict)
    other_frames: dict[str, int] = field(default_factory=dict)
    late: dict[str, Lateness] = field(default_factory=dict)
    other_cameras: dict[str, int] = field(default_factory=dict)
    besides: Counter[tuple[str, str]] = field(default_factory=Counter)


def gather(
    recording: Recording,
    resolution: Resolution,
    type_of: Callable[[Channel], MessageType],
    named: Callable[[Channel, int | None], AbstractContextManager[None]],
    *,
    bodies: frozenset[str],
    stamps: bool,
) -> Gathered:
    """Read the signals, and of images the header stamps and the constancy of their CameraInfo if wanted.

    Args:
        recording: Is read once.
        resolution: Which channel is what.
        type_of: Gives the codec of a channel.
        named: Puts the channel and the log time into errors.
        bodies: Frames whose own transforms are the ground truth.
        stamps: Whether header stamps and calibrations of images are looked at.

    Raises:
        InputError: A message does not fit its definition.

    """
    result = Gathered()
    signal_collectors = _collectors(resolution, type_of, result.tree, bodies)
    collectors: dict[int, _AnyCollector] = dict(signal_collectors)
    if stamps:
        images = {resolution.channels[stream] for stream in IMAGE_STREAMS if stream in resolution.channels}
        collectors |= {channel.id: StampCollector() for channel in images}
        collectors |= {channel.id: ConstantCollector() for channel in resolution.infos.values()}
    wanted = [channel for channel in recording.channels if channel.id in collectors]
    for message in recording.messages(wanted) if stamps else ():
        try:
            collectors[message.channel.id].add(message)
        except InputError:
            with named(
                message.channel, None if message.channel.id in signal_collectors else message.log_time
            ):
                raise
    for batch in () if stamps else recording.batches(wanted):
        with named(batch.channel, None):
            signal_collectors[batch.channel.id].add_batch(batch)
    for channel in wanted:
        with named(channel, None):
            collectors[channel.id].flush()
    _take_results(result, resolution, collectors)
    return result


def _take_results(result: Gathered, resolution: Resolution, collectors: Mapping[int, _AnyCollector]) -> None:
    for stream, channel in resolution.channels.items():
        collector = collectors.get(channel.id)
        if isinstance(collector, StampCollector):
            result.times[stream] = collector.result()
            result.late[stream] = lateness(*result.times[stream])
            result.other_frames[stream] = collector.other_frames
        elif isinstance(collector, AccelerometerCollector):
            result.accelerometer = collector.result()
        elif isinstance(collector, PoseCollector):
            result.poses = collector.result()
        if isinstance(collector, (AccelerometerCollector, PoseCollector)):
            result.frame_ids[stream] = collector.frame_id
            result.other_frames[stream] = collector.other_frames
            result.late[stream] = collector.late
            result.besides.update({(channel.topic, what): n for what, n in collector.besides.items()})
    for stream, channel in resolution.infos.items():
        collector = collectors.get(channel.id)
        if isinstance(collector, ConstantCollector) and collector.others:
            result.other_cameras[stream] = collector.others


def _collectors(
    resolution: Resolution,
    type_of: Callable[[Channel], MessageType],
    tree: TransformTree,
    bodies: frozenset[str],
) -> dict[int, Collector]:
    """Return what takes the messages of the signals, by channel."""
    channels = resolution.channels
    result: dict[int, Collector] = {
        channel.id: TransformCollector(type_of(channel), tree) for channel in resolution.transforms
    }
    if "accelerometer" in channels:
        result[channels["accelerometer"].id] = AccelerometerCollector(type_of(channels["accelerometer"]))
    if "groundtruth" in channels and not resolution.transforms:
        result[channels["groundtruth"].id] = PoseCollector(type_of(channels["groundtruth"]), bodies)
    return result
