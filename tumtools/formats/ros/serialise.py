# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Images and calibrations to messages.

The messages of a stream differ in their stamps and payloads only. What stands before the payload is
serialised once, and the stamp put into a copy; the payload stays a buffer of its own.
"""

from __future__ import annotations

import struct
from functools import lru_cache
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.formats.ros import messages
from tumtools.images.codec import canonical, in_metres, pixels_of, png_of
from tumtools.model.image import ENCODINGS, Image
from tumtools.model.time import split_stamp

if TYPE_CHECKING:
    import numpy.typing as npt

    from tumtools.formats.ros.recording import MessageEncoding
    from tumtools.model.camera import CameraInfo

Message = dict[str, object]

_COLOUR_ENCODINGS: Final = {
    "rgb8": {"bgr8": "rgb8", "bgra8": "rgba8"},
    "bgr8": {"rgb8": "bgr8", "rgba8": "bgra8"},
}
"""Encoding asked for -> encodings whose channels have to be swapped for it."""
_ROS1_HEADER: Final = struct.Struct("<III")
"""Sequence number and stamp, with which a ROS 1 message begins."""
_CDR_STAMP: Final = struct.Struct("<iI")
_CDR_STAMP_OFFSET: Final = 4


def header(encoding: MessageEncoding, frame_id: str, stamp: int = 0, row: int = 0) -> Message:
    """Return a std_msgs/Header."""
    seconds, nanoseconds = split_stamp(stamp)
    result: Message = {"stamp": {"sec": seconds, "nanosec": nanoseconds}, "frame_id": frame_id}
    return result | {"seq": row % 2**32} if encoding == "ros1" else result


def camera_info(encoding: MessageEncoding, frame_id: str, stamp: int, row: int, camera: CameraInfo) -> bytes:
    """Serialise a sensor_msgs/CameraInfo."""
    return _stamped(_camera_info(encoding, frame_id, camera), encoding, stamp, row)


@lru_cache(maxsize=64)
def _camera_info(encoding: MessageEncoding, frame_id: str, camera: CameraInfo) -> bytes:
    matrices = {"d": camera.d, "k": camera.k, "r": camera.r, "p": camera.p}
    message: Message = {
        "header": header(encoding, frame_id),
        "height": camera.height,
        "width": camera.width,
        "distortion_model": camera.distortion_model,
        "binning_x": 0,
        "binning_y": 0,
        "roi": {"x_offset": 0, "y_offset": 0, "height": 0, "width": 0, "do_rectify": False},
    }
    upper = encoding == "ros1"
    message |= {name.upper() if upper else name: values for name, values in matrices.items()}
    return messages.message_type(messages.CAMERA_INFO, encoding).encode(message)


def compressed_image(
    encoding: MessageEncoding, frame_id: str, stamp: int, row: int, image: Image
) -> tuple[bytes, bytes | memoryview]:
    """Serialise a sensor_msgs/CompressedImage of the PNG file, as head and payload.

    Raises:
        InputError: The image is damaged.

    """
    data = png_of(image)
    # Of the words of image_transport; without the encoding it would take 16 bits for 8.
    text = "16UC1; png compressed " if ENCODINGS[image.encoding].dtype.itemsize > 1 else "png"
    head = _head(messages.COMPRESSED_IMAGE, encoding, frame_id, (("format", text),))
    return _with_length(_stamped(head, encoding, stamp, row), data), data


def raw_image(
    encoding: MessageEncoding, frame_id: str, stamp: int, row: int, image: Image, wanted: str
) -> tuple[bytes, memoryview]:
    """Serialise a sensor_msgs/Image, as head and payload.

    Args:
        encoding: How messages are serialised.
        frame_id: Coordinate frame.
        stamp: Nanoseconds.
        row: For the sequence number of ROS 1.
        image: Any.
        wanted: `rgb8` or `bgr8` decide the order of colour channels, `32FC1` makes metres of counts.

    Raises:
        InputError: The image is damaged.

    """
    pixels, name = _pixels(image, wanted)
    data = np.ascontiguousarray(pixels).reshape(-1).view(np.uint8).data
    fields = (
        ("height", image.height),
        ("width", image.width),
        ("encoding", name),
        ("is_bigendian", 0),
        ("step", image.width * ENCODINGS[name].bytes_per_pixel),
    )
    head = _head(messages.IMAGE, encoding, frame_id, fields)
    return _with_length(_stamped(head, encoding, stamp, row), data), data


@lru_cache(maxsize=64)
def _head(
    kind: str, encoding: MessageEncoding, frame_id: str, fields: tuple[tuple[str, str | int], ...]
) -> bytes:
    """Serialise a message whose data, its last field, is empty."""
    message: Message = {"header": header(encoding, frame_id), **dict(fields), "data": ()}
    return messages.message_type(kind, encoding).encode(message)


def _with_length(head: bytes, data: bytes | memoryview) -> bytes:
    return head[:-4] + struct.pack("<I", len(data))


def _stamped(message: bytes, encoding: MessageEncoding, stamp: int, row: int) -> bytes:
    """Put stamp and sequence number into the header, with which the message begins."""
    if encoding == "ros1":
        return _ROS1_HEADER.pack(row % 2**32, *split_stamp(stamp)) + message[_ROS1_HEADER.size :]
    end = _CDR_STAMP_OFFSET + _CDR_STAMP.size
    return message[:_CDR_STAMP_OFFSET] + _CDR_STAMP.pack(*split_stamp(stamp)) + message[end:]


def _pixels(image: Image, wanted: str) -> tuple[npt.NDArray[np.generic], str]:
    if image.depth_units_per_metre is not None:
        image = in_metres(image) if wanted == "32FC1" else image
        return pixels_of(image), image.encoding
    pixels = pixels_of(image)
    name = _COLOUR_ENCODINGS.get(wanted, {}).get(image.encoding, image.encoding)
    if name != image.encoding:
        # Swapping is its own inverse, so this makes either order of the other.
        pixels = canonical(pixels, "bgra8" if pixels.shape[2] == 4 else "bgr8")[0]  # noqa: PLR2004 - alpha
    return pixels, name
