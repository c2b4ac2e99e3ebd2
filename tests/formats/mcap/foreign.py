# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Recordings as other people make them, written with the reference library."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from mcap.writer import CompressionType, IndexType, Writer

from tests.memory import START, picture
from tumtools.formats.ros import messages
from tumtools.images.codec import pixels_of, png_of

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from tumtools.formats.ros.recording import MessageEncoding, Recording

ZERO = {"x": 0.0, "y": 0.0, "z": 0.0}
ONE = ZERO | {"w": 1.0}


@dataclass
class Foreign:
    """A file that is written by another library.

    Attributes:
        path: The file.
        encoding: Of the messages.
        writer: Arguments of the library's writer.
        extra: What to keep beside a topic.

    """

    path: Path
    encoding: MessageEncoding = "cdr"
    writer: dict[str, Any] = field(default_factory=dict)
    extra: dict[str, dict[str, str]] = field(default_factory=dict)

    def __enter__(self) -> Self:
        self._file = self.path.open("wb")
        self.library = Writer(self._file, **self.writer)
        self.library.start("ros1" if self.encoding == "ros1" else "ros2", "somebody")
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        return self

    def __exit__(self, *error: object) -> None:
        self.library.finish()
        self._file.close()

    @contextmanager
    def beside_the_chunks(self) -> Iterator[None]:
        """Write messages to no chunk, which the library does only for a file without any."""
        chunks, end_chunk = "_Writer__chunk_builder", "_Writer__finalize_chunk"
        getattr(self.library, end_chunk)()
        builder = getattr(self.library, chunks)
        setattr(self.library, chunks, None)
        yield
        setattr(self.library, chunks, builder)

    def forget(self) -> None:
        """Go on with other channels and schemas, as another recorder would."""
        self._schemas, self._channels = {}, {}

    def copy(self, ours: Recording, later: int = 0) -> None:
        """Write our metadata and messages again, each received some nanoseconds later than the one before."""
        self.library.add_metadata("tumtools", dict(ours.metadata or {}))
        for number, message in enumerate(ours.messages(ours.channels)):
            time, channel = message.log_time + later * number, message.channel
            self.library.add_message(
                self.channel(channel.topic, channel.type), time, bytes(message.data), time
            )

    def channel(self, topic: str, kind: str, definition: str | None = None) -> int:
        if kind not in self._schemas:
            name = messages.ros1_name(kind) if self.encoding == "ros1" else kind
            text = definition or messages.definition(kind, self.encoding)
            schema = "ros1msg" if self.encoding == "ros1" else "ros2msg"
            self._schemas[kind] = self.library.register_schema(name, schema, text.encode())
        if topic not in self._channels:
            self._channels[topic] = self.library.register_channel(
                topic, self.encoding, self._schemas[kind], self.extra.get(topic, {})
            )
        return self._channels[topic]

    def write(
        self,
        topic: str,
        kind: str,
        stamp: int,
        *,
        late: int = 0,
        **values: Any,
    ) -> None:
        """Write a message that was received `late` nanoseconds after its header's stamp."""
        codec = messages.message_type(kind, self.encoding)
        if "transforms" not in values:
            values["header"] = self.header(stamp, str(values.pop("frame_id", "somewhere")))
        number = self.channel(topic, kind)
        self.library.add_message(number, stamp + late, codec.encode(values), stamp + late)

    def header(self, stamp: int, frame_id: str) -> dict[str, Any]:
        seconds, nanoseconds = divmod(stamp, 10**9)
        return {"seq": 0, "stamp": {"sec": seconds, "nanosec": nanoseconds}, "frame_id": frame_id}

    def image(
        self, topic: str, stamp: int, row: int, *, encoding: str = "bgr8", late: int = 0, **values: Any
    ) -> None:
        image = picture(
            "depth" if encoding == "16UC1" else "rgb", row, encoding=encoding if encoding != "16UC1" else None
        )
        pixels = np.ascontiguousarray(pixels_of(image))
        data = pixels.reshape(-1).view(np.uint8).tolist()
        sizes = {"height": image.height, "width": image.width, "step": pixels.strides[0]}
        self.write(
            topic,
            messages.IMAGE,
            stamp,
            late=late,
            encoding=encoding,
            is_bigendian=0,
            data=data,
            **sizes,
            **values,
        )

    def compressed(self, topic: str, stamp: int, row: int, *, stream: str = "rgb", late: int = 0) -> None:
        data = list(bytes(png_of(picture(stream, row))))
        self.write(topic, messages.COMPRESSED_IMAGE, stamp, late=late, format="png", data=data)

    def calibration(self, topic: str, stamp: int, focal_length: float) -> None:
        size = {"height": 6, "width": 8, "distortion_model": "plumb_bob", "binning_x": 0, "binning_y": 0}
        roi = {"x_offset": 0, "y_offset": 0, "height": 0, "width": 0, "do_rectify": False}
        k = [focal_length, 0.0, 4.0, 0.0, focal_length, 3.0, 0.0, 0.0, 1.0]
        one, p = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0], [*k[:3], 0.0, *k[3:6], 0.0, *k[6:], 0.0]
        matrices = {"d": [0.0] * 5, "k": k, "r": one, "p": p}
        as_in_ros1 = {name.upper(): value for name, value in matrices.items()}
        self.write(topic, messages.CAMERA_INFO, stamp, roi=roi, **size, **matrices, **as_in_ros1)

    def imu(self, stamp: int, x: float, topic: str = "/imu/data") -> None:
        none = [0.0] * 9
        self.write(
            topic, messages.IMU, stamp, orientation=ONE, orientation_covariance=none, angular_velocity=ZERO,
            angular_velocity_covariance=none, linear_acceleration=ZERO | {"x": x},
            linear_acceleration_covariance=none,
        )  # fmt: skip

    def pose(self, stamp: int, x: float, topic: str = "/mocap/pose") -> None:
        pose = {"position": ZERO | {"x": x}, "orientation": ONE}
        self.write(topic, messages.POSE_STAMPED, stamp, frame_id="map", pose=pose)

    def other(self, topic: str, schema: str, encoding: str, data: bytes = b"{}") -> None:
        """Write a message that is not of ROS."""
        number = self.library.register_schema(f"foxglove.{schema}", encoding, b"schema")
        channel = self.library.register_channel(topic, encoding.removesuffix("schema"), number)
        self.library.add_message(channel, START, data, START)


WRITERS: dict[str, dict[str, Any]] = {
    "zstd": {"compression": CompressionType.ZSTD, "chunk_size": 600},
    "lz4": {"compression": CompressionType.LZ4, "chunk_size": 600},
    "none": {"compression": CompressionType.NONE, "chunk_size": 600},
    "unchunked": {"use_chunking": False},
    "no summary": {
        "index_types": IndexType.NONE, "repeat_channels": False, "repeat_schemas": False,
        "use_statistics": False, "use_summary_offsets": False, "chunk_size": 600,
    },
    "no index": {"index_types": IndexType.NONE, "chunk_size": 600},
    "no chunk index": {"index_types": IndexType.MESSAGE, "chunk_size": 600},
    "no message index": {"index_types": IndexType.CHUNK, "chunk_size": 600},
    "no repeated channels": {"repeat_channels": False, "chunk_size": 600},
    "no repeated schemas": {"repeat_schemas": False, "chunk_size": 600},
    "no metadata index": {"index_types": IndexType.CHUNK | IndexType.MESSAGE, "chunk_size": 600},
    "no statistics": {"use_statistics": False, "chunk_size": 600},
    "no checksums": {"enable_crcs": False, "chunk_size": 600},
    "data checksums": {"enable_data_crcs": True, "chunk_size": 600},
    "one chunk": {"chunk_size": 1 << 24},
}  # fmt: skip
"""Everything that the writer of the reference library can leave out."""
