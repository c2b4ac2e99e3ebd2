# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The topics of a MCAP file. Channels that say the same of one topic share one, as publishers in a bag do."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from tumtools.formats.mcap.structure import Schema
from tumtools.formats.ros.definitions import full_name
from tumtools.formats.ros.qos import is_latched
from tumtools.formats.ros.recording import Channel, MessageEncoding

if TYPE_CHECKING:
    from collections.abc import Mapping

    from tumtools.formats.mcap.structure import RawChannel

_ENCODINGS: Final[dict[tuple[str, str], MessageEncoding]] = {
    ("ros2msg", "cdr"): "cdr",
    ("ros1msg", "ros1"): "ros1",
}
_NO_SCHEMA: Final = Schema("", "", "")
_QOS: Final = "offered_qos_profiles"
"""Key of the channel's metadata that rosbag2 writes."""


def channels_of(
    channels: Mapping[int, RawChannel], schemas: Mapping[int, Schema], counts: Mapping[int, int]
) -> dict[int, Channel]:
    """Return the channel of each number; those of one topic, schema and encoding of messages share one.

    Args:
        channels: As they are in the file, by number.
        schemas: By number.
        counts: Messages of each channel of the file.

    """
    groups: dict[tuple[str, str, Schema | int], list[int]] = {}
    for number, channel in sorted(channels.items()):
        schema = schemas.get(channel.schema, channel.schema)  # one that is missing agrees with itself only
        groups.setdefault((channel.topic, channel.encoding, schema), []).append(number)
    shared: dict[int, Channel] = {}
    for (topic, encoding, schema), group in groups.items():
        name, of_messages, definition = _type(schema if isinstance(schema, Schema) else _NO_SCHEMA, encoding)
        members = [channels[number] for number in group]
        qos = tuple(dict.fromkeys(channel.extra.get(_QOS, "") for channel in members))
        latched = any(map(is_latched, qos)) or any(_latches(channel) for channel in members)
        count = sum(counts.get(number, 0) for number in group)
        one = Channel(group[0], topic, full_name(name), of_messages, definition, count, latched, qos)
        shared |= dict.fromkeys(group, one)
    return shared


def _type(schema: Schema, encoding: str) -> tuple[str, MessageEncoding, str]:
    """Return name, encoding and definition of a type of messages."""
    of_messages = _ENCODINGS.get((schema.encoding, encoding))
    if of_messages is None:
        # Not of ROS (protobuf, JSON, flatbuffer): named, and left alone.
        return f"{schema.encoding or encoding}/{schema.name or 'unknown'}", "cdr", ""
    return schema.name, of_messages, schema.definition


def _latches(channel: RawChannel) -> bool:
    return channel.extra.get("latching") == "1"
