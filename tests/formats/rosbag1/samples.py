# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Small bags for the tests of the container; their messages are std_msgs/String."""

from __future__ import annotations

import io
import random
import struct
from typing import TYPE_CHECKING

from tumtools.formats.ros.recording import OutMessage
from tumtools.formats.rosbag1.container import write_bag
from tumtools.formats.rosbag1.recording import BagRecording
from tumtools.formats.rosbag1.structure import Connection

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

SECOND = 1_000_000_000
START = 1305031102 * SECOND + 175304000
STRING_MD5 = "992ce8a1687cec8c8bd883ec73ca41d1"

CONNECTIONS = tuple(
    Connection(topic, "std_msgs/String", STRING_MD5, "string data\n", latched)
    for topic, latched in (("/one", False), ("/two", False), ("/static", True))
)


def string(text: str) -> bytes:
    """Serialise a std_msgs/String as ROS 1 does."""
    data = text.encode()
    return struct.pack("<I", len(data)) + data


def some_messages(count: int = 40, size: int = 50_000) -> list[OutMessage]:
    """Return messages of three connections, 10 ms apart, of which every seventh is large."""
    noise = random.Random(0)
    texts = [f"message {i} " + (noise.randbytes(size // 2).hex() if i % 7 == 0 else "") for i in range(count)]
    return [
        OutMessage(
            i % 3, START + i * SECOND // 100, (string(text)[:9], memoryview(string(text)[9:])), i % 7 == 0
        )
        for i, text in enumerate(texts)
    ]


def bag_bytes(
    messages: Sequence[OutMessage],
    compression: str = "none",
    connections: Sequence[Connection] = CONNECTIONS,
    jobs: int = 2,
) -> bytes:
    """Return a bag with these messages."""
    file = io.BytesIO()
    write_bag(file, connections, messages, compression=compression, jobs=jobs)
    return file.getvalue()


def plain(messages: Sequence[OutMessage]) -> list[tuple[str, int, bytes]]:
    """Return topic, stamp and bytes of messages to write."""
    return [(CONNECTIONS[m.channel].topic, m.stamp, b"".join(m.parts)) for m in messages]


def read(path: Path, *, salvage: bool = False) -> list[tuple[str, int, bytes]]:
    """Return topic, stamp and bytes of all messages of a bag."""
    bag = BagRecording(path, salvage=salvage)
    found = [(m.channel.topic, m.log_time, bytes(m.data)) for m in bag.messages(bag.channels)]
    bag.close()
    return found
