# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What other people's readers must find in a recording of a sequence, computed without our ROS code."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from tumtools.convert import ConvertOptions, convert
from tumtools.formats.options import WriteOptions
from tumtools.images.codec import pixels_of
from tumtools.sources import open_source
from tumtools.transform import Selection

if TYPE_CHECKING:
    from pathlib import Path

    from tumtools.model.sequence import Frame, Sequence

EVERY = 15


def write(source: Path, target: Path, to: str, **options: str | bool) -> Path:
    """Convert some images and all signals of a sequence."""
    with open_source(source) as sequence:
        convert(sequence, target, to, _options(options), ConvertOptions(Selection(every=EVERY)))
    return target


def _options(options: dict[str, str | bool]) -> WriteOptions:
    return replace(WriteOptions(), **options)  # type: ignore[arg-type]  # a test names what there is


def check_messages(source: Path, messages: list[dict[str, Any]], *, png: bool = False) -> None:
    """Compare decoded messages with a sequence: stamps to the nanosecond, pixels and values bit by bit."""
    by_topic: dict[str, list[dict[str, Any]]] = {}
    for message in messages:
        by_topic.setdefault(message["topic"], []).append(message)
        stamp = header_of(message["message"])
        if stamp:
            assert message["time"] == stamp
    times = [int(message["time"]) for message in messages]
    assert times == sorted(times)
    with open_source(source) as sequence:
        _check_images(sequence, by_topic, png=png)
        assert sequence.accelerometer is not None
        imu = [message["message"] for message in by_topic["/imu"]]
        assert [int(header_of(one)) for one in imu] == sequence.accelerometer.stamps.tolist()
        values = [[one["linear_acceleration"][axis] for axis in "xyz"] for one in imu]
        assert values == sequence.accelerometer.values.tolist()
        assert imu[0]["orientation_covariance"][0] == imu[0]["angular_velocity_covariance"][0] == -1
        assert sequence.groundtruth is not None
        transforms = [transform for one in by_topic["/tf"] for transform in one["message"]["transforms"]]
        assert [int(one["header"]["stamp"]) for one in transforms] == sequence.groundtruth.stamps.tolist()
        poses = [one["transform"] for one in transforms]
        found = [
            [*(one["translation"][axis] for axis in "xyz"), *(one["rotation"][axis] for axis in "xyzw")]
            for one in poses
        ]
        assert found == sequence.groundtruth.values.tolist()


def header_of(message: dict[str, Any]) -> str:
    """Return the stamp of a message's header, empty if it has none."""
    return str(message.get("header", {}).get("stamp", ""))


def _check_images(sequence: Sequence, by_topic: dict[str, list[dict[str, Any]]], *, png: bool) -> None:
    colour = "/camera/rgb/image_color" + ("/compressed" if png else "")
    for stream, topic in (("rgb", colour), ("depth", "/camera/depth/image")):
        frames = list(sequence.images([stream]))[::EVERY]
        images = [message["message"] for message in by_topic[topic]]
        assert [int(header_of(image)) for image in images] == [frame.stamp for frame in frames]
        for image, frame in zip(images, frames, strict=True):
            assert image["data"]["sha256"] == _digest(frame, png=png and stream == "rgb")
        infos = [message["message"] for message in by_topic[f"/camera/{stream}/camera_info"]]
        assert [header_of(info) for info in infos] == [header_of(image) for image in images]
        matrix = infos[0].get("k", infos[0].get("K"))
        assert matrix == [517.3, 0, 318.6, 0, 516.5, 255.3, 0, 0, 1]


def _digest(frame: Frame, *, png: bool) -> str:
    image = frame.load()
    if png:
        return hashlib.sha256(image.compressed).hexdigest()
    pixels = pixels_of(image)
    if frame.stream == "depth":
        metres = (pixels / 5000.0).astype(np.float32)
        pixels = np.where(pixels == 0, np.float32(np.nan), metres)
    return hashlib.sha256(np.ascontiguousarray(pixels).tobytes()).hexdigest()
