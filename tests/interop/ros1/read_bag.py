# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Print every message of ROS 1 bags as a line of JSON, read with ROS's own rosbag.

Run with the system's Python, which has Debian's python3-rosbag; knows nothing of tumtools.
"""

from __future__ import annotations

import hashlib
import json
import sys
from typing import Any

import rosbag


def plain(value: Any) -> Any:
    """Turn a message into what JSON can hold; byte arrays become their length and SHA-256."""
    if isinstance(value, bytes):
        return {"length": len(value), "sha256": hashlib.sha256(value).hexdigest()}
    if hasattr(value, "to_nsec"):
        return str(value.to_nsec())
    if hasattr(value, "__slots__"):
        return {name: plain(getattr(value, name)) for name in value.__slots__}
    return [plain(item) for item in value] if isinstance(value, (list, tuple)) else value


for path in sys.argv[1:]:
    with rosbag.Bag(path) as bag:
        for topic, message, time, header in bag.read_messages(return_connection_header=True):
            line = {"topic": topic, "time": str(time.to_nsec()), "message": plain(message)}
            kind, md5sum = (bytes(header[name]).decode() for name in ("type", "md5sum"))
            line.update(type=kind, md5sum=md5sum, header=sorted(header))
            sys.stdout.write(json.dumps(line) + "\n")
