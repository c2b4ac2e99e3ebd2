# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A rosbag2 folder as one `Recording`, whatever its storage, however it is split and compressed."""

from __future__ import annotations

import heapq
import tempfile
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
import zstandard

from tumtools.errors import InputError, MissingInputError, UnsupportedInputError
from tumtools.formats.mcap.recording import McapRecording
from tumtools.formats.metadata import DIGEST_RECORD, KEYS, is_metadata, parse_object
from tumtools.formats.ros.batches import in_batches
from tumtools.formats.ros.qos import is_latched
from tumtools.formats.ros.recording import Channel, RawMessage, Recording
from tumtools.formats.rosbag2.bag_info import FILE_NAME, BagInfo, read_bag_info
from tumtools.formats.rosbag2.sqlite_reader import SqliteRecording
from tumtools.model.sequence import LEFT_OUT, RECORDING, Loss, sum_losses

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator

    import numpy.typing as npt

    from tumtools.formats.ros.batches import Batch

_MAX_MESSAGE_BYTES: Final = 256 * 2**20
_MAX_WINDOW: Final = 128 * 2**20
_FRAME_HEADER_BYTES: Final = 18
_COPY_OF_INFO: Final = "metadata rosbag2"
"""A metadata record of MCAP in which rosbag2 keeps a copy of metadata.yaml."""
_STORAGES: Final = {"sqlite3": SqliteRecording, "mcap": McapRecording}
_SUFFIXES: Final = {".db3": "sqlite3", ".mcap": "mcap"}


class Rosbag2Recording(Recording):
    """A rosbag2 folder, or one sqlite3 file of it.

    Args:
        path: The folder, or the file.
        salvage: Leave out what is damaged, with a warning, instead of failing.

    Raises:
        InputError: Something is missing or damaged.

    """

    format = "rosbag2"

    def __init__(self, path: Path, *, salvage: bool = False) -> None:
        self.path = str(path)
        self._temporary: tempfile.TemporaryDirectory[str] | None = None
        info = read_bag_info(path / FILE_NAME) if path.is_dir() else _info_of_file(path)
        folder = path if path.is_dir() else path.parent
        warnings = [] if path.is_dir() else [f"read without the {FILE_NAME} of its folder"]
        _check_compression(info, path)
        if not info.files:
            raise InputError("it lists no files", path=folder / FILE_NAME)
        self._by_message = info.compression_mode == "message"
        self._parts: list[Recording] = []
        errors: list[InputError] = []
        for name in info.files:
            try:
                self._parts.append(self._open(_file(folder, name), info, salvage=salvage))
            except InputError as error:
                if not salvage:
                    self.close()
                    raise
                errors.append(error)
        if errors:
            if not self._parts:
                self.close()
                raise errors[0]
            warnings += [f"{error.message}; this file is left out" for error in errors]
            self.left_out = (Loss(RECORDING, f"files {LEFT_OUT}", len(errors), errors[0].message),)
        self.channels, self._places = _merge_channels(self._parts, info)
        custom = dict(info.custom_data or next((p.metadata for p in self._parts if p.metadata), {}))
        self.digest = next((p.digest for p in self._parts if p.digest), None)
        if DIGEST_RECORD in custom:
            self.digest = _digest(custom.pop(DIGEST_RECORD))
        if is_metadata(custom):
            self.metadata = {key: custom.pop(key) for key in KEYS & custom.keys()}
        why = "a sequence has no place for what others note in the custom_data of a recording"
        self.not_carried = (
            *(Loss(f"custom_data {key}", "entry not carried over", 1, why) for key in sorted(custom)),
            *sum_losses(
                loss for part in self._parts for loss in part.not_carried if loss.stream != _COPY_OF_INFO
            ),
        )
        self.left_out += tuple(loss for part in self._parts for loss in part.left_out)
        if salvage and (missing_messages := tuple(self._missing(info))):
            self.left_out = missing_messages
        self.warnings = (*warnings, *(warning for part in self._parts for warning in part.warnings))

    def _missing(self, info: BagInfo) -> Iterator[Loss]:
        """Yield the messages that metadata.yaml counts and that could not be read."""
        found: Counter[str] = Counter()
        for channel in self.channels:
            found[channel.topic] += channel.count or 0
        others = {loss.stream for part in self._parts for loss in part.not_carried}
        why = "; ".join(dict.fromkeys(loss.why for loss in self.left_out)) or "the files do not hold them"
        for topic, count in info.counts.items():
            if count > found[topic] and topic not in others:
                yield Loss(
                    topic, f"messages {LEFT_OUT}", count - found[topic], f"{FILE_NAME} counts them; {why}"
                )

    def _open(self, file: Path, info: BagInfo, *, salvage: bool) -> Recording:
        name = file.name.removesuffix(".zstd")
        storage = info.storage or _SUFFIXES.get(Path(name).suffix, "")
        if storage not in _STORAGES:
            raise UnsupportedInputError(
                f"storage {info.storage!r}, read are {', '.join(_STORAGES)}", path=self.path
            )
        if info.compression_mode == "file" or file.suffix == ".zstd":
            if self._temporary is None:
                self._temporary = tempfile.TemporaryDirectory(prefix="tumtools-")
            unpacked = Path(self._temporary.name, name)
            _decompress_file(file, unpacked, salvage=salvage)
            try:
                return _STORAGES[storage](unpacked, salvage=salvage)
            except InputError as error:
                # The file that the user has, and not its copy, which is gone by then.
                raise type(error)(
                    error.message, path=file, location=error.location, hint=error.hint
                ) from error
        return _STORAGES[storage](file, salvage=salvage)

    def messages(
        self, channels: Collection[Channel], start: int | None = None, end: int | None = None
    ) -> Iterator[RawMessage]:
        """Yield the messages of the channels in order of (log time, file, position in the file).

        Raises:
            InputError: A file is damaged.

        """
        ids = {channel.id for channel in channels}
        streams = []
        for number, part in enumerate(self._parts):
            wanted = {own: merged for own, merged in self._places[number].items() if merged.id in ids}
            chosen = [channel for channel in part.channels if channel.id in wanted]
            times = [part.log_times(channel) for channel in chosen]
            first = min((int(column[0]) for column in times if len(column)), default=None)
            if first is not None:
                streams.append((first, number, part.messages(chosen, start, end), wanted))
        for message, wanted in _merge(streams):
            data = self._unpack(message.data) if self._by_message else message.data
            yield RawMessage(wanted[message.channel.id], message.log_time, data)

    def batches(self, channels: Collection[Channel]) -> Iterator[Batch]:
        """Yield small messages many at a time; those of each channel in order of log time.

        Raises:
            InputError: As `messages`.

        """
        merged = (
            {channel.id: channel for channel in self._places[0].values()} if len(self._parts) == 1 else {}
        )
        if self._by_message or not merged or len(merged) < len(self._places[0]):
            yield from in_batches(self.messages(channels))  # what is merged has to be put into order
            return
        ids = {channel.id for channel in channels}
        own = {channel: self._places[0][channel.id] for channel in self._parts[0].channels}
        for batch in self._parts[0].batches([channel for channel, one in own.items() if one.id in ids]):
            yield replace(batch, channel=own[batch.channel])

    def log_times(self, channel: Channel) -> npt.NDArray[np.int64]:
        """Return the log times of a channel, in order."""
        times = [
            part.log_times(own)
            for number, part in enumerate(self._parts)
            for own in part.channels
            if self._places[number][own.id].id == channel.id
        ]
        return np.sort(np.concatenate([np.empty(0, np.int64), *times]), kind="stable")

    def _unpack(self, data: memoryview) -> memoryview:
        """Decompress a message."""
        try:
            size = zstandard.get_frame_parameters(data).content_size
            if size > _MAX_MESSAGE_BYTES and size != zstandard.CONTENTSIZE_UNKNOWN:
                raise InputError(f"a message of {size} bytes when decompressed", path=self.path)
            return memoryview(
                zstandard.ZstdDecompressor().decompress(data, max_output_size=_MAX_MESSAGE_BYTES)
            )
        except zstandard.ZstdError as error:
            raise InputError(f"a compressed message is damaged: {error}", path=self.path) from error

    def close(self) -> None:
        """Close the files, and remove what was unpacked."""
        for part in self._parts:
            part.close()
        if self._temporary is not None:
            self._temporary.cleanup()
            self._temporary = None


def _digest(text: str) -> dict[str, str]:
    """Return the strings of the digest; strings that are none where they are damaged."""
    try:
        return parse_object(text)
    except ValueError as error:
        return {"damage": str(error)}


def _info_of_file(path: Path) -> BagInfo:
    return BagInfo(_SUFFIXES.get(path.suffix, "sqlite3"), (path.name,), "", "", {}, {})


def _check_compression(info: BagInfo, path: Path) -> None:
    if info.compression_mode not in {"", "file", "message"}:
        raise UnsupportedInputError(f"compression mode {info.compression_mode!r}", path=path)
    if info.compression_mode and info.compression_format not in {"", "zstd"}:
        raise UnsupportedInputError(f"compression {info.compression_format!r}, only zstd is read", path=path)


def _file(folder: Path, name: str) -> Path:
    """Return a file of a recording.

    Raises:
        MissingInputError: It is not there, or its name leads out of the folder.

    """
    # The first versions put the folder's own name before that of the file.
    for path in (folder / name, folder / Path(name).name):
        if path.resolve().is_relative_to(folder.resolve()):
            # rosbag2 lists the compressed name, some writers the one before.
            for found in (path, path.with_name(f"{path.name}.zstd")):
                if found.is_file():
                    return found
    raise MissingInputError(f"the file {name!r} that {FILE_NAME} lists is missing", path=folder)


def _decompress_file(source: Path, target: Path, *, salvage: bool) -> None:
    """Decompress a file to disk, through a window of bounded size."""
    try:
        with source.open("rb") as packed, target.open("wb") as unpacked:
            promised = zstandard.frame_content_size(packed.read(_FRAME_HEADER_BYTES))
            packed.seek(0)
            decompressor = zstandard.ZstdDecompressor(max_window_size=_MAX_WINDOW)
            decompressor.copy_stream(packed, unpacked)
            if unpacked.tell() < promised and not salvage:
                raise InputError(
                    f"the zstd data ends after {unpacked.tell()} of {promised} bytes: the file was cut",
                    path=source,
                    hint="--salvage reads what comes before the damage",
                )
            if not unpacked.tell():
                raise InputError("the file is empty", path=source)
    except zstandard.ZstdError as error:
        raise InputError(f"the zstd data is damaged: {error}", path=source) from error
    except OSError as error:
        raise InputError(f"cannot be unpacked: {error.strerror}", path=source) from error


def _merge_channels(
    parts: list[Recording], info: BagInfo
) -> tuple[tuple[Channel, ...], list[dict[int, Channel]]]:
    """Return the channels of all files together, and for each file: its number of a channel -> channel."""
    groups: dict[tuple[str, str], list[tuple[int, Channel]]] = {}
    for number, part in enumerate(parts):
        for channel in part.channels:
            groups.setdefault((channel.topic, channel.type), []).append((number, channel))
    merged: list[Channel] = []
    places: list[dict[int, Channel]] = [{} for _ in parts]
    for group in groups.values():
        first = group[0][1]
        qos = [*(text for _, c in group for text in c.qos), info.qos.get(first.topic, "")]
        channel = replace(
            first,
            id=len(merged),
            definition=next((c.definition for _, c in group if c.definition), ""),
            count=sum(c.count or 0 for _, c in group),
            latched=first.latched or is_latched(qos[-1]),
            qos=tuple(dict.fromkeys(qos)),
        )
        merged.append(channel)
        for number, own in group:
            places[number][own.id] = channel
    return tuple(merged), places


_Stream = tuple[int, int, "Iterator[RawMessage]", dict[int, Channel]]
"""First log time of a file, its number, its messages, and its channels."""


def _merge(streams: list[_Stream]) -> Iterator[tuple[RawMessage, dict[int, Channel]]]:
    """Merge by log time; a file is not touched before its first message may be due."""
    waiting = sorted(streams, key=lambda stream: stream[:2], reverse=True)
    active: list[tuple[int, int, RawMessage, Iterator[RawMessage], dict[int, Channel]]] = []
    while waiting or active:
        while waiting and (not active or waiting[-1][0] <= active[0][0]):
            _, number, messages, channels = waiting.pop()
            message = next(messages, None)
            if message is not None:
                heapq.heappush(active, (message.log_time, number, message, messages, channels))
        if not active:
            continue
        _, number, message, messages, channels = active[0]
        yield message, channels
        following = next(messages, None)
        if following is None:
            heapq.heappop(active)
        else:
            heapq.heapreplace(active, (following.log_time, number, following, messages, channels))
