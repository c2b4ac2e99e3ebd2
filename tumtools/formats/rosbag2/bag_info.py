# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`metadata.yaml`, the description that a rosbag2 folder has of itself (rosbag2_storage, versions 1 to 9)."""

from __future__ import annotations

import textwrap
from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import yaml

from tumtools.errors import InputError
from tumtools.formats import safe_yaml
from tumtools.formats.ros.messages import TYPE_HASHES
from tumtools.formats.ros.qos import qos_profile

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence
    from pathlib import Path

    from tumtools.formats.ros.recording import OutChannel, OutMessage

FILE_NAME: Final = "metadata.yaml"
DISTRO_VERSIONS: Final = {
    "humble": 8, "iron": 8, "jazzy": 9, "kilted": 9, "rolling": 9, "galactic": 4, "foxy": 4,
}  # fmt: skip
"""Newest version of `metadata.yaml` that each release of ROS 2 reads; the first one is the default."""

_ROOT: Final = "rosbag2_bagfile_information"
_MAX_BYTES: Final = 64 * 2**20
_FILES, _CUSTOM_DATA, _TYPE_HASH, _ROS_DISTRO, _QOS_WORDS = 5, 6, 7, 8, 9
"""Version from which on each of these is there."""


@dataclass(frozen=True, slots=True)
class BagInfo:
    """What `metadata.yaml` says.

    Attributes:
        storage: `sqlite3` or `mcap`.
        files: Names of the files, in order.
        compression_format: `zstd`, or empty.
        compression_mode: `file`, `message`, or empty.
        qos: Topic -> profiles, as text; empty where none is given.
        counts: Topic -> number of messages, as far as they are given.
        custom_data: Strings that the writer put there.

    """

    storage: str
    files: tuple[str, ...]
    compression_format: str
    compression_mode: str
    qos: Mapping[str, str]
    custom_data: Mapping[str, str]
    counts: Mapping[str, int] = field(default_factory=dict)


def read_bag_info(path: Path) -> BagInfo:
    """Read the file.

    Raises:
        InputError: It is damaged or lacks something.

    """
    try:
        with path.open("rb") as file:
            content = file.read(_MAX_BYTES + 1)
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", path=path) from error
    if len(content) > _MAX_BYTES:
        raise InputError(f"larger than {_MAX_BYTES} bytes, no description of a recording", path=path)
    return parse_bag_info(content, path)


def parse_bag_info(content: bytes | str, path: Path | str) -> BagInfo:
    """Read the text of the file; the path is for messages.

    Raises:
        InputError: It is damaged or lacks something.

    """
    try:
        document = safe_yaml.load(content)
    except yaml.MarkedYAMLError as error:
        line = None if error.problem_mark is None else f"line {error.problem_mark.line + 1}"
        raise InputError(f"not valid YAML: {error.problem}", path=path, location=line) from error
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        raise InputError(f"not valid YAML: {error}", path=path) from error
    root = document.get(_ROOT, document) if isinstance(document, dict) else None
    # The copy in a sqlite3 file begins with what is below the root.
    if not isinstance(root, dict) or "storage_identifier" not in root:
        raise InputError(f"no {_ROOT!r}, so it does not describe a ROS 2 recording", path=path)
    files, topics = root.get("relative_file_paths"), root.get("topics_with_message_count") or []
    if not isinstance(files, list) or not all(isinstance(name, str) for name in files):
        raise InputError("relative_file_paths is no list of file names", path=path)
    if not isinstance(topics, list):
        raise InputError("topics_with_message_count is no list", path=path)
    custom = root.get("custom_data")
    return BagInfo(
        storage=_text(root, "storage_identifier"),
        files=tuple(files),
        compression_format=_text(root, "compression_format").lower(),
        compression_mode=_text(root, "compression_mode").lower().replace("none", ""),
        qos=dict(_qos(topic) for topic in topics if isinstance(topic, dict)),
        custom_data={str(k): str(v) for k, v in custom.items()} if isinstance(custom, dict) else {},
        counts=_counts(topics),
    )


def _text(values: Mapping[object, object], key: str) -> str:
    value = values.get(key)
    return value if isinstance(value, str) else ""


def _counts(topics: list[object]) -> Counter[str]:
    """Return the number of messages of each topic; a topic may be listed once for each type."""
    counts: Counter[str] = Counter()
    for topic in topics:
        count = topic.get("message_count") if isinstance(topic, dict) else None
        if isinstance(topic, dict) and isinstance(count, int):
            counts[_qos(topic)[0]] += count
    return counts


def _qos(entry: Mapping[object, object]) -> tuple[str, str]:
    """Return name and profiles of a topic; lists of version 9 become the text of earlier versions."""
    topic = entry.get("topic_metadata")
    if not isinstance(topic, dict):
        return "", ""
    profiles = topic.get("offered_qos_profiles") or ""
    try:
        text = profiles if isinstance(profiles, str) else yaml.safe_dump(profiles)
    except RecursionError:
        text = "too deep"  # no profiles, but something that is not kept
    return _text(topic, "name"), text


@dataclass(frozen=True, slots=True)
class Summary:
    """What has been written.

    Attributes:
        file: Name of the storage file.
        channels: Topics.
        counts: Messages of each channel.
        start: Stamp of the first message; 0 if there is none.
        end: Stamp of the last message.

    """

    file: str
    channels: Sequence[OutChannel]
    counts: Sequence[int]
    start: int
    end: int


class Tally:
    """Counts messages on their way into a file."""

    def __init__(self, channels: Sequence[OutChannel]) -> None:
        self._channels = channels
        self._counts = [0] * len(channels)
        self._start: int | None = None
        self._end = 0

    def watch(self, messages: Iterable[OutMessage]) -> Iterator[OutMessage]:
        """Pass the messages on."""
        for message in messages:
            self._counts[message.channel] += 1
            self._start = message.stamp if self._start is None else min(self._start, message.stamp)
            self._end = max(self._end, message.stamp)
            yield message

    def summary(self, file: str) -> Summary:
        """Return what has been seen so far."""
        return Summary(file, self._channels, tuple(self._counts), self._start or 0, self._end)


def format_bag_info(
    summary: Summary, *, storage: str, ros_distro: str, custom_data: Mapping[str, str]
) -> tuple[str, str]:
    """Return the text of the file in the version that a release of ROS 2 reads, and the copy for sqlite3."""
    version = DISTRO_VERSIONS[ros_distro]
    total, duration = sum(summary.counts), summary.end - summary.start
    start = f"starting_time:\n    nanoseconds_since_epoch: {summary.start}\n"
    lines = [
        f"version: {version}\n",
        f"storage_identifier: {storage}\n",
        f"duration:\n  nanoseconds: {duration}\n",
        f"starting_time:\n  nanoseconds_since_epoch: {summary.start}\n",
        f"message_count: {total}\n",
        "topics_with_message_count:" + ("\n" if summary.channels else " []\n"),
        *(
            _format_topic(channel, count, version)
            for channel, count in zip(summary.channels, summary.counts, strict=True)
        ),
        'compression_format: ""\ncompression_mode: ""\n',
        f"relative_file_paths:\n  - {quoted(summary.file)}\n",
    ]
    if version >= _FILES:
        lines.append(
            f"files:\n  - path: {quoted(summary.file)}\n    {start.replace('    ', '      ')}"
            f"    duration:\n      nanoseconds: {duration}\n    message_count: {total}\n"
        )
    if version >= _CUSTOM_DATA or custom_data:
        # Earlier readers pass over keys that they do not know.
        lines.append("custom_data:" + ("\n" if custom_data else " {}\n"))
        lines += [f"  {quoted(key)}: {quoted(value)}\n" for key, value in sorted(custom_data.items())]
    if version >= _ROS_DISTRO:
        lines.append(f"ros_distro: {ros_distro}\n")
    text = "".join(lines)
    return f"{_ROOT}:\n" + textwrap.indent(text, "  "), text


def _format_topic(channel: OutChannel, count: int, version: int) -> str:
    words = version >= _QOS_WORDS
    profile = qos_profile(latched=channel.latched, words=words)
    profiles = "\n" + textwrap.indent(profile, "      ") if words else f" {quoted(profile)}"
    text = (
        f"  - topic_metadata:\n      name: {quoted(channel.topic)}\n      type: {channel.type}\n"
        f"      serialization_format: cdr\n      offered_qos_profiles:{profiles}\n"
    )
    if version >= _TYPE_HASH:
        text += f"      type_description_hash: {TYPE_HASHES[channel.type]}\n"
    return text + f"    message_count: {count}\n"


def quoted(text: str) -> str:
    """Return a text as a double-quoted YAML scalar of printable ASCII."""
    return '"' + "".join(map(_escaped, text)) + '"'


def _escaped(character: str) -> str:
    if character in '"\\':
        return "\\" + character
    if character == "\n":
        return "\\n"
    code = ord(character)
    if 0x20 <= code < 0x7F:  # noqa: PLR2004 - printable ASCII
        return character
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"  # noqa: PLR2004 - what two and four hex digits hold
