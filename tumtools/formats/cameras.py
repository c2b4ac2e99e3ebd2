# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Which intrinsics a sequence has of its own, and which are written for a stream."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tumtools.model.camera import CAMERAS, ROS_DEFAULT, CameraInfo, calibration

if TYPE_CHECKING:
    from collections.abc import Mapping

    from tumtools.formats.options import WriteOptions
    from tumtools.model.sequence import ImageStreamInfo, Sequence


def own_calibrations(
    found: Mapping[str, CameraInfo], camera: str | None, images: Mapping[str, ImageStreamInfo]
) -> dict[str, CameraInfo]:
    """Return the intrinsics that do not follow from the camera; every container holds some.

    Args:
        found: Intrinsics by stream, as a source has them.
        camera: One of `CAMERAS`, None if unknown.
        images: The image streams; what has no images needs no intrinsics.

    """
    result = {}
    for stream, one in found.items():
        image = images.get(stream)
        if image is not None and image.count:
            # The size is not known where the first image is damaged or missing.
            size = (image.width, image.height) if image.width else (one.width, one.height)
            if one != calibration(camera or ROS_DEFAULT, stream, *size):
                result[stream] = one
    return result


def known_camera(sequence: Sequence, options: WriteOptions) -> str | None:
    """Return the camera that was asked for, or else the sequence's; None if it has no calibration."""
    camera = options.camera or sequence.info.camera
    return camera if camera in CAMERAS else None


def chosen_calibration(
    sequence: Sequence, options: WriteOptions, stream: str, width: int, height: int
) -> CameraInfo:
    """Return the intrinsics: those asked for, the sequence's own, those of its camera, ROS's default.

    Args:
        sequence: What is written.
        options: `cameras` and `camera`.
        stream: `rgb`, `depth` or `ir`.
        width: Columns of the images.
        height: Rows of the images.

    """
    if stream in options.cameras:
        return options.cameras[stream]
    if options.camera is None and stream in sequence.cameras:
        return sequence.cameras[stream]
    return calibration(known_camera(sequence, options) or ROS_DEFAULT, stream, width, height)
