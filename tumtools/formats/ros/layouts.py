# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Topics and coordinate frames: as the benchmark published them, and as ROS 2 and viewers expect them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Mapping

TF_TOPIC: Final = "/tf"
TF_STATIC_TOPIC: Final = "/tf_static"
METADATA_TOPIC: Final = "/tumtools/sequence"
"""Where a ROS 1 bag keeps what its messages have no field for."""
DIGEST_TOPIC: Final = "/tumtools/digest"
"""Where a ROS 1 bag keeps the digest of its content, as its last message."""


@dataclass(frozen=True, slots=True)
class Layout:
    """Names of a recording.

    Attributes:
        name: As on the command line.
        topics: Stream -> topic. That of `groundtruth` is for poses; transforms are on /tf.
        info_topics: Image stream -> topic of its CameraInfo.
        frames: Stream -> coordinate frame.
        world: Frame that the ground truth is given in.
        body: Frame that /tf places in the world.
        groundtruth: How ground truth is written unless told: `pose`, `tf` or `both`.

    """

    name: str
    topics: Mapping[str, str]
    info_topics: Mapping[str, str]
    frames: Mapping[str, str]
    world: str
    body: str
    groundtruth: str


_TOPICS: Final = {
    "rgb": "/camera/rgb/image_color",
    "depth": "/camera/depth/image",
    "ir": "/camera/ir/image_raw",
    "accelerometer": "/imu",
    "groundtruth": "/groundtruth/pose",
}
_INFO_TOPICS: Final = {stream: f"/camera/{stream}/camera_info" for stream in ("rgb", "depth", "ir")}
_FRAMES: Final = {
    "rgb": "openni_rgb_optical_frame",
    "depth": "openni_rgb_optical_frame",  # registered to colour
    "ir": "openni_depth_optical_frame",
    "accelerometer": "imu",
}

LAYOUTS: Final[dict[str, Layout]] = {
    layout.name: layout
    for layout in (
        Layout(
            name="published",
            topics=_TOPICS,
            info_topics=_INFO_TOPICS,
            frames={stream: f"/{frame}" for stream, frame in _FRAMES.items()},
            world="/world",
            body="/openni_rgb_optical_frame",
            groundtruth="tf",
        ),
        Layout(
            name="modern",
            topics=_TOPICS,
            info_topics=_INFO_TOPICS,
            frames=_FRAMES,
            world="world",
            body="groundtruth",
            groundtruth="both",
        ),
    )
}

_KNOWN_FRAMES: Final = frozenset(
    frame.lstrip("/") for layout in LAYOUTS.values() for frame in (*layout.frames.values(), layout.body)
)
_WORLDS: Final = frozenset(layout.world.lstrip("/") for layout in LAYOUTS.values())


def is_default_frame(frame_id: str) -> bool:
    """Tell whether a frame says nothing beyond the layout, with or without its slash."""
    return frame_id.lstrip("/") in _KNOWN_FRAMES | _WORLDS | {""}
