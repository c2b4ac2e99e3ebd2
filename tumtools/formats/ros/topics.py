# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Which topic of a recording is which stream: asked for, remembered, or found by type and name."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from tumtools.errors import UsageError
from tumtools.formats.ros import messages
from tumtools.formats.ros.layouts import TF_STATIC_TOPIC, TF_TOPIC
from tumtools.formats.ros.signals import POSE_PATHS
from tumtools.model.sequence import IMAGE_STREAMS, STREAMS, Loss

if TYPE_CHECKING:
    from collections.abc import Mapping

    from tumtools.formats.options import ReadOptions
    from tumtools.formats.ros.recording import Channel, Recording

_IMAGES: Final = frozenset({messages.IMAGE, messages.COMPRESSED_IMAGE})
TF_TYPES: Final = frozenset({messages.TF_MESSAGE, messages.OLD_TF_MESSAGE})
TYPES: Final[dict[str, frozenset[str]]] = {
    "rgb": _IMAGES,
    "depth": _IMAGES,
    "ir": _IMAGES,
    "accelerometer": frozenset({messages.IMU}),
    "groundtruth": frozenset(POSE_PATHS) | TF_TYPES,
}
"""Message types that a stream can come from."""


@dataclass(frozen=True, slots=True)
class Resolution:
    """Which channel is which stream.

    Attributes:
        channels: Stream -> channel.
        infos: Image stream -> channel of its CameraInfo.
        not_carried: Channels that are no part of a sequence.
        warnings: Streams that were left out because several topics could be meant.
        transforms: Channels of transforms that the ground truth of a foreign recording is composed from.
        frames: Between which frames, `world.camera`; empty to look for them, None if nobody asked for
            transforms.

    """

    channels: Mapping[str, Channel]
    infos: Mapping[str, Channel]
    not_carried: tuple[Loss, ...]
    warnings: tuple[str, ...] = field(default=())
    transforms: tuple[Channel, ...] = ()
    frames: str | None = None


def resolve(recording: Recording, options: ReadOptions, places: Mapping[str, str]) -> Resolution:
    """Find the channels of the streams.

    Args:
        recording: Any.
        options: With the topics asked for.
        places: Stream -> topic as our own metadata remembers it; empty for foreign recordings.

    Raises:
        UsageError: A topic asked for is not there or has no fitting type, or several could be meant.

    """
    chosen: dict[str, Channel] = {}
    warnings: list[str] = []
    by_topic = {channel.topic: channel for channel in recording.channels}
    frames: str | None = None
    for stream in STREAMS:
        topic = options.topics.get(stream, places.get(stream) or None)
        if stream == "groundtruth" and stream in options.topics:
            topic, _, frames = options.topics[stream].partition(":")
        if topic is not None:
            channel = by_topic.get(topic)
            if channel is None and stream not in options.topics:
                warnings.append(
                    f"{recording.path}: its metadata names the topic {topic} for {stream}; there is none"
                )
                continue
            chosen[stream] = _asked_for(recording, stream, topic, channel)
        elif not places and (found := _found(recording, stream, options, warnings)) is not None:
            chosen[stream] = found
    _refuse_shared(recording, chosen)
    transforms = _transforms(recording, chosen, places) if options.wants("groundtruth") else ()
    if "groundtruth" not in chosen or not transforms:
        frames = None
    warnings += _offered_transforms(recording, is_known=bool("groundtruth" in chosen or transforms or places))
    infos = {
        stream: info for stream in chosen if (info := _info_channel(recording, chosen[stream])) is not None
    }
    used = {channel.id for channel in (*chosen.values(), *infos.values(), *transforms)}
    rest = [
        channel for channel in recording.channels if channel.id not in used and not _ours(channel, places)
    ]
    losses = tuple(loss_of(channel) for channel in rest if channel.count != 0)
    return Resolution(chosen, infos, losses, tuple(warnings), transforms, frames)


def _found(recording: Recording, stream: str, options: ReadOptions, warnings: list[str]) -> Channel | None:
    """Return the channel whose type and name fit a stream that was not named; of several, none.

    Raises:
        UsageError: Several fit a stream that is wanted.

    """
    candidates = _candidates(recording, stream, set(options.topics.values()))
    if len(candidates) < 2:  # noqa: PLR2004 - it is clear
        return candidates[0] if candidates else None
    text = _ambiguous(stream, candidates)
    if options.lenient:
        warnings.append(f"{text}; choose one with --topic {stream}=TOPIC")
    elif options.wants(stream):
        hint = f"choose one, as with --topic {stream}={candidates[0].topic}"
        raise UsageError(text, path=recording.path, hint=hint)
    return None


def _transforms(
    recording: Recording, chosen: Mapping[str, Channel], places: Mapping[str, str]
) -> tuple[Channel, ...]:
    """Return the channels of transforms, if the ground truth was asked for there or is nowhere else."""
    groundtruth = chosen.get("groundtruth")
    if groundtruth is None:
        wanted = not places and any(stream in chosen for stream in IMAGE_STREAMS)
    else:
        wanted = groundtruth.type in TF_TYPES and places.get("groundtruth") != groundtruth.topic
    return tuple(c for c in recording.channels if wanted and c.type in TF_TYPES and c.count != 0)


def _refuse_shared(recording: Recording, chosen: Mapping[str, Channel]) -> None:
    """Refuse one topic as two streams: its images cannot be both."""
    owner: dict[str, str] = {}
    for stream, channel in chosen.items():
        first = owner.setdefault(channel.topic, stream)
        if first != stream:
            raise UsageError(
                f"the topic {channel.topic} cannot be both {first} and {stream}",
                path=recording.path,
                hint="choose other topics with --topic",
            )


def _offered_transforms(recording: Recording, *, is_known: bool) -> list[str]:
    """Tell how to take the ground truth from transforms, unless it is known where it is."""
    if is_known:
        return []
    topics = [channel.topic for channel in recording.channels if channel.type in TF_TYPES and channel.count]
    moving = [topic for topic in topics if topic.strip("/") != "tf_static"]
    return [
        f"{topic} holds transforms; --topic groundtruth={topic}:WORLD.CAMERA takes the ground truth from them"
        for topic in moving[:1]
    ]


def loss_of(channel: Channel) -> Loss:
    """Say that the messages of a channel are left alone."""
    return Loss(channel.topic, "messages not carried over", channel.count or 0, _why(channel))


def _asked_for(recording: Recording, stream: str, topic: str, channel: Channel | None) -> Channel:
    if channel is None:
        there = ", ".join(sorted(channel.topic for channel in recording.channels)) or "none"
        raise UsageError(
            f"--topic {stream}={topic}: no such topic", path=recording.path, hint=f"topics: {there}"
        )
    if channel.type not in TYPES[stream]:
        raise UsageError(
            f"--topic {stream}={topic}: its type is {channel.type}",
            path=recording.path,
            hint=f"for {stream} it can be {', '.join(sorted(TYPES[stream]))}",
        )
    return channel


def _candidates(recording: Recording, stream: str, taken: set[str]) -> list[Channel]:
    return [
        channel
        for channel in recording.channels
        if channel.type in TYPES[stream]
        and channel.topic not in taken
        and channel.count != 0
        and (channel.type not in _IMAGES or _stream_of_image(channel.topic) == stream)
        and channel.type not in TF_TYPES
    ]


def _stream_of_image(topic: str) -> str:
    words = topic.lower().replace("_", "/").split("/")
    if any("depth" in word for word in words):
        return "depth"
    if any(word in {"ir", "infra", "infra1", "infra2", "infrared"} for word in words):
        return "ir"
    return "rgb"


def _ambiguous(stream: str, candidates: list[Channel]) -> str:
    topics = ", ".join(f"{channel.topic} ({channel.type})" for channel in candidates)
    return f"several topics could be {stream}: {topics}"


def _info_channel(recording: Recording, channel: Channel) -> Channel | None:
    """Return the CameraInfo of an image topic, `/compressed` or not: below it, or in the same namespace."""
    if channel.type not in _IMAGES:
        return None
    topic = channel.topic.removesuffix("/compressed").removesuffix("/compressedDepth")
    infos = {other.topic: other for other in recording.channels if other.type == messages.CAMERA_INFO}
    return infos.get(f"{topic}/camera_info") or infos.get(f"{topic.rpartition('/')[0]}/camera_info")


def _ours(channel: Channel, places: Mapping[str, str]) -> bool:
    """Tell whether a channel only repeats what our own metadata or another channel holds."""
    return bool(places) and channel.topic in {TF_TOPIC, TF_STATIC_TOPIC}


def _why(channel: Channel) -> str:
    if any(channel.type in kinds for kinds in TYPES.values()):
        return f"{channel.type}, not chosen for any stream"
    return f"{channel.type} is no part of a sequence"
