# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Quality of service of topics, as rosbag2 keeps it beside them.

Up to version 8 of its metadata, rosbag2 keeps a YAML text with the numbers of `rmw/types.h`, which is all
that Humble's parser reads; from version 9 on it keeps words.
"""

from __future__ import annotations

from typing import Final

_FOREVER: Final = "\n    sec: 9223372036\n    nsec: 854775807\n"
"""RMW_DURATION_INFINITE."""

_PROFILE: Final = (
    "- history: {history}\n  depth: {depth}\n  reliability: {reliability}\n  durability: {durability}\n"
    f"  deadline:{_FOREVER}  lifespan:{_FOREVER}"
    f"  liveliness: {{liveliness}}\n  liveliness_lease_duration:{_FOREVER}"
    "  avoid_ros_namespace_conventions: false"
)
_NUMBERS: Final = {"history": "1", "reliability": "1", "liveliness": "1"}
_WORDS: Final = {"history": "keep_last", "reliability": "reliable", "liveliness": "automatic"}


def qos_profile(*, latched: bool, words: bool = False) -> str:
    """Return the profile of a reliable topic, as YAML.

    Args:
        latched: Late subscribers get the last message (transient local).
        words: Write words instead of numbers.

    """
    number, word = ("1", "transient_local") if latched else ("2", "volatile")
    fields = _WORDS if words else _NUMBERS
    return _PROFILE.format(depth=1 if latched else 10, durability=word if words else number, **fields)


def is_latched(profiles: str) -> bool:
    """Tell whether a profile, as numbers or words, is transient local."""
    lines = [line.strip() for line in profiles.splitlines()]
    return "durability: 1" in lines or "durability: transient_local" in lines
