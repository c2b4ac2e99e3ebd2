# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Write a sequence as a ROS 1 bag."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import chain
from typing import TYPE_CHECKING

from tumtools.formats.registry import FORMATS
from tumtools.formats.ros import messages
from tumtools.formats.ros.layouts import DIGEST_TOPIC, METADATA_TOPIC
from tumtools.formats.ros.outgoing import outgoing, style_plan
from tumtools.formats.ros.recording import OutChannel, OutMessage
from tumtools.formats.ros.style import Style, make_style, style_needs
from tumtools.formats.rosbag1.container import write_bag
from tumtools.formats.rosbag1.structure import Connection

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from tumtools.formats.options import Needs, Plan, Progress, WriteOptions
    from tumtools.formats.ros.outgoing import Outgoing
    from tumtools.model.sequence import Loss, Sequence


def write(sequence: Sequence, target: Path, options: WriteOptions, progress: Progress) -> tuple[Loss, ...]:
    """Write a bag; returns no losses, since what it cannot hold is taken out before (`needs`).

    Raises:
        InputError: An image of the sequence is damaged.
        OutputError: A stamp does not fit into the messages, or the disk is full.

    """
    out = outgoing(sequence, _style(options))
    # Number 0 is the topic of our own metadata, which stands first in the bag.
    channels = [OutChannel(METADATA_TOPIC, messages.STRING, latched=True), *out.channels]
    if out.keeps_digest:
        channels.append(OutChannel(DIGEST_TOPIC, messages.STRING, latched=True))
    with target.open("wb") as file:
        write_bag(
            file,
            [_connection(channel) for channel in channels],
            _with_metadata(out),
            compression=FORMATS["rosbag1"].option(options, "compression"),
            jobs=options.jobs,
            progress=progress,
        )
    return ()


def needs(options: WriteOptions) -> Needs:
    """Return what the writer must be given."""
    return style_needs(_style(options))


def plan(sequence: Sequence, target: Path, options: WriteOptions) -> Plan:
    """Return the estimated size, and what is assumed."""
    del target
    compressed = FORMATS["rosbag1"].option(options, "compression") != "none"
    return style_plan(sequence, _style(options), compressed=compressed)


def _style(options: WriteOptions) -> Style:
    return make_style("ros1", FORMATS["rosbag1"], options)


def _connection(channel: OutChannel) -> Connection:
    kind = channel.type
    return Connection(
        topic=channel.topic,
        type=messages.ros1_name(kind),
        md5sum=messages.ros1_md5_sum(kind),
        definition=messages.definition(kind, "ros1"),
        latched=channel.latched,
    )


def _with_metadata(out: Outgoing) -> Iterator[OutMessage]:
    """Put the metadata before everything else, at the time of the first message; the digest at the end."""
    iterator = out.messages()
    first = next(iterator, None)
    stamp = first.stamp if first else 1
    yield OutMessage(0, stamp, (_string(out.metadata),))
    for message in chain(() if first is None else (first,), iterator):
        stamp = message.stamp
        yield replace(message, channel=message.channel + 1)
    if out.keeps_digest:
        yield OutMessage(len(out.channels) + 1, stamp, (_string(out.digest()),))


def _string(values: Mapping[str, str]) -> bytes:
    text = json.dumps(values, sort_keys=True, separators=(",", ":"))
    return messages.message_type(messages.STRING, "ros1").encode({"data": text})
