# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What the three ROS containers have in common: channels, and messages in order of log time.

A container package (`rosbag1`, `rosbag2`, `mcap`) only knows how bytes are laid out in its files. It
gives a `Recording` to read from and takes channels and serialised messages to write. What the messages
mean is known by the other modules of this package.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from tumtools.formats.ros.batches import in_batches

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping

    import numpy.typing as npt

    from tumtools.formats.ros.batches import Batch
    from tumtools.model.sequence import Loss

MessageEncoding = Literal["cdr", "ros1"]


@dataclass(frozen=True, slots=True)
class Channel:
    """A topic of a recording.

    Attributes:
        id: Number of the channel in its container, unique there.
        topic: Its name.
        type: Message type in the spelling of ROS 2: `sensor_msgs/msg/Image`.
        encoding: How messages are serialised.
        definition: Embedded message definition with its dependencies, as `gendeps --cat` prints it
            (`====` lines and `MSG: package/Type`); empty if the container has none.
        count: How many messages, where an index tells; else None.
        latched: Late subscribers get the last message (ROS 1 latching, ROS 2 transient local).
        qos: Profiles that it was offered with, as the container has them: texts of YAML.

    """

    id: int
    topic: str
    type: str
    encoding: MessageEncoding
    definition: str
    count: int | None = None
    latched: bool = False
    qos: tuple[str, ...] = ()


class RawMessage(NamedTuple):
    """A serialised message.

    Attributes:
        channel: Its channel.
        log_time: Nanoseconds since 1970 at which the container says that it was recorded.
        data: The message; a view that stays valid while somebody holds it.

    """

    channel: Channel
    log_time: int
    data: memoryview


class Recording(ABC):
    """An open container.

    Attributes:
        path: The file or folder.
        format: Name of the format, for messages.
        channels: All topics that are there, with or without messages.
        metadata: The strings of the record named `tumtools`; None if there is none.
        digest: The strings of the record named `tumtools.digest`; None if there is none.
        not_carried: What is in the container besides messages and is left alone (attachments).
        left_out: What a salvage passes over because it is damaged.
        warnings: What the user should know: no index, clean end missing.

    """

    path: str
    format: str
    channels: tuple[Channel, ...]
    metadata: Mapping[str, str] | None = None
    digest: Mapping[str, str] | None = None
    not_carried: tuple[Loss, ...] = ()
    left_out: tuple[Loss, ...] = ()
    warnings: tuple[str, ...] = ()

    @abstractmethod
    def messages(
        self, channels: Collection[Channel], start: int | None = None, end: int | None = None
    ) -> Iterator[RawMessage]:
        """Yield the messages of the channels in order of (log time, position in the file).

        Reads nothing that does not hold messages of these channels where an index allows that.

        Args:
            channels: Which channels.
            start: First log time wanted, inclusive.
            end: Last log time wanted, inclusive.

        Raises:
            InputError: Damage, with the offset and what was expected there.

        """

    def batches(self, channels: Collection[Channel]) -> Iterator[Batch]:
        """Yield small messages many at a time; those of each channel in order of log time.

        Raises:
            InputError: As `messages`.

        """
        return in_batches(self.messages(channels))

    def log_times(self, channel: Channel) -> npt.NDArray[np.int64]:
        """Return the log times of the messages of a channel, in order; from an index where there is one."""
        return np.array([message.log_time for message in self.messages([channel])], np.int64)

    @abstractmethod
    def close(self) -> None:
        """Release files. Views that were handed out stay valid."""


@dataclass(frozen=True, slots=True)
class OutChannel:
    """A topic to write.

    Attributes:
        topic: Its name.
        type: Message type in the spelling of ROS 2; a key of `messages.DEFINITIONS`.
        latched: Late subscribers get the last message.

    """

    topic: str
    type: str
    latched: bool = False


@dataclass(frozen=True, slots=True)
class OutMessage:
    """A serialised message to write.

    Attributes:
        channel: Index into the list of channels.
        stamp: Nanoseconds since 1970; log time and publish time.
        parts: Buffers that make up the message when they are joined. A large payload is a part of its
            own, so that nobody needs to copy it.
        is_image: Whether it counts as a frame.

    """

    channel: int
    stamp: int
    parts: tuple[bytes | memoryview, ...] = field(repr=False)
    is_image: bool = False
