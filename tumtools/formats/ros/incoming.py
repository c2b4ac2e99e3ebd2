# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""From a recording to a sequence: decoded signals, and images as a lazy stream in order of their stamps."""

from __future__ import annotations

import heapq
import struct
from contextlib import contextmanager
from dataclasses import replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.errors import InputError
from tumtools.formats import metadata
from tumtools.formats.ros import signals
from tumtools.formats.ros.codec import MessageType
from tumtools.formats.ros.images import image_of_message
from tumtools.formats.ros.layouts import KNOWN_FRAMES, LAYOUTS
from tumtools.formats.ros.topics import TF_TYPES, resolve
from tumtools.model.camera import ROS_DEFAULT, CameraInfo, calibration, camera_of_name
from tumtools.model.sequence import (
    IMAGE_STREAMS,
    SIGNAL_STREAMS,
    Frame,
    ImageStreamInfo,
    Sequence,
    SequenceInfo,
    frame_order,
)
from tumtools.model.signals import Accelerometer, Trajectory
from tumtools.model.time import join_stamp

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator

    import numpy.typing as npt

    from tumtools.formats.options import ReadOptions
    from tumtools.formats.ros.codec import Message
    from tumtools.formats.ros.recording import Channel, RawMessage, Recording
    from tumtools.model.image import Image
    from tumtools.model.text import TextLayout

_STAMP_OFFSET: Final = 4
"""Of the header's stamp: behind the representation in CDR, behind the sequence number in ROS 1."""
_STAMPS: Final = {"cdr": struct.Struct("<iI"), "ros1": struct.Struct("<II")}
_BIG_ENDIAN_STAMP: Final = struct.Struct(">iI")
_MAX_WAITING: Final = 32
"""Messages; each may be a raw image."""


class RosSequence(Sequence):
    """A sequence in a recording of ROS.

    Args:
        recording: Closed with the sequence.
        name: What to call it if it does not say so itself.
        options: How to read it.

    Raises:
        UsageError: The topics asked for do not fit, or several could be meant.
        InputError: The recording is damaged.

    """

    def __init__(self, recording: Recording, name: str, options: ReadOptions) -> None:
        self._recording = recording
        with self._named():
            self._meta = metadata.from_strings(recording.metadata) if recording.metadata else None
        places = self._meta.streams if self._meta else {}
        self._resolution = resolve(recording, options, places)
        self._channels = self._resolution.channels
        self._types: dict[int, MessageType] = {}
        self._order = {
            stream: np.array(order, np.intp)
            for stream, order in (self._meta.row_order.items() if self._meta else ())
        }
        self._frame_ids: dict[str, str] = {}
        self._notes: list[str] = []
        signal_messages = self._signal_messages()
        if "accelerometer" in self._channels or "accelerometer" in places:
            self.accelerometer = self._decode_accelerometer(signal_messages["accelerometer"])
        if "groundtruth" in self._channels or "groundtruth" in places:
            self.groundtruth = self._decode_groundtruth(signal_messages["groundtruth"])
        streams = [stream for stream in IMAGE_STREAMS if stream in self._channels or stream in places]
        images = {stream: self._image_info(stream) for stream in streams}
        self._rows = self._file_rows()
        text = self._text_layouts()
        meta_camera = self._meta.camera if self._meta else None
        camera = meta_camera or (None if self._meta else camera_of_name(name))
        self.cameras = dict(self._read_cameras(images, camera))
        self.info = SequenceInfo(
            name=self._meta.name if self._meta else name,
            format=recording.format,
            camera=camera,
            images=images,
            text=text,
            frame_ids=self._frame_ids,
            licence=self._meta.licence if self._meta else None,
            citation=self._meta.citation if self._meta else None,
            not_carried=recording.not_carried + self._resolution.not_carried,
            warnings=recording.warnings + self._resolution.warnings + tuple(self._notes),
        )

    @contextmanager
    def _named(self, channel: Channel | None = None, stamp: int | None = None) -> Iterator[None]:
        """Put file, topic and time into errors that do not know theirs."""
        try:
            yield
        except InputError as error:
            if error.path:
                raise
            topic = f"topic {channel.topic}" if channel else None
            time = f"message at {stamp} ns" if stamp is not None else None
            place = ", ".join(part for part in (topic, time, error.location) if part)
            raise type(error)(
                error.message, path=self._recording.path, location=place or None, hint=error.hint
            ) from error

    def _type(self, channel: Channel) -> MessageType:
        if channel.id not in self._types:
            with self._named(channel):
                self._types[channel.id] = MessageType(channel.definition, channel.type, channel.encoding)
        return self._types[channel.id]

    def _signal_messages(self) -> dict[str, list[memoryview]]:
        """Read the messages of the small signals, in one pass.

        They are copied, since a view would keep in memory what lies around it, such as images.
        """
        found: dict[str, list[memoryview]] = {stream: [] for stream in SIGNAL_STREAMS}
        names = {self._channels[stream].id: stream for stream in SIGNAL_STREAMS if stream in self._channels}
        for message in self._recording.messages([self._channels[stream] for stream in names.values()]):
            found[names[message.channel.id]].append(memoryview(bytes(message.data)))
        return found

    def _decode_accelerometer(self, data: list[memoryview]) -> Accelerometer:
        channel = self._channels.get("accelerometer")
        if channel is None:
            return Accelerometer.empty()
        with self._named(channel):
            found = signals.accelerometer(self._type(channel), data)
        return found.take(self._to_file_order("accelerometer", found.stamps))

    def _decode_groundtruth(self, data: list[memoryview]) -> Trajectory:
        channel = self._channels.get("groundtruth")
        if channel is None:
            return Trajectory.empty()
        with self._named(channel):
            if channel.type in TF_TYPES:
                found = self._own_transforms(channel, data)
            else:
                found, frame_id = signals.poses(self._type(channel), data)
                self._note_frame("groundtruth", frame_id)
        return found.take(self._to_file_order("groundtruth", found.stamps))

    def _own_transforms(self, channel: Channel, data: list[memoryview]) -> Trajectory:
        for layout in LAYOUTS.values():
            found = signals.transforms(self._type(channel), data, layout.world, layout.body)
            if len(found):
                return found
        return Trajectory.empty()

    def _note_frame(self, stream: str, frame_id: str) -> None:
        worlds = {layout.world.lstrip("/") for layout in LAYOUTS.values()}
        if frame_id.lstrip("/") not in KNOWN_FRAMES | worlds | {""}:
            self._frame_ids[stream] = frame_id

    def _to_file_order(self, stream: str, stamps: npt.NDArray[np.int64]) -> npt.NDArray[np.intp]:
        """Return for each row in file order which message it is; the messages are in order of stamps."""
        by_stamp = np.argsort(stamps, kind="stable")
        return by_stamp[np.argsort(self._file_order(stream, len(stamps)))]

    def _file_order(self, stream: str, count: int) -> npt.NDArray[np.intp]:
        """Return for each row in order of stamps its row number in file order."""
        order = self._order.get(stream)
        if order is not None and len(order) == count:
            return order
        if order is not None:
            self._notes.append(
                f"{self._recording.path}: its metadata knows the order of {len(order)} rows of {stream}, "
                f"there are {count}; they are sorted by stamp"
            )
            del self._order[stream]
        return np.arange(count)

    def _image_info(self, stream: str) -> ImageStreamInfo:
        channel = self._channels.get(stream)
        first = None if channel is None else next(self._recording.messages([channel]), None)
        if channel is None or first is None:
            return ImageStreamInfo(count=0, source=channel.topic if channel else None)
        with self._named(channel, first.log_time):
            message = self._type(channel).decode(first.data)
            image = image_of_message(channel.type, message, stream, self._png_units)
        header = message.get("header")
        if list(message)[:1] != ["header"] or not isinstance(header, dict) or "stamp" not in header:
            raise InputError(
                "its image messages do not begin with a header",
                path=self._recording.path,
                location=f"topic {channel.topic}",
            )
        self._note_frame(stream, str(header.get("frame_id", "")))
        count = len(self._log_stamps[stream])
        return ImageStreamInfo(
            count=count,
            encoding=image.encoding,
            width=image.width,
            height=image.height,
            depth_units_per_metre=image.depth_units_per_metre,
            frame_id=self._frame_ids.get(stream),
            nbytes=image.nbytes * count,
            compression=image.compression,
            source=channel.topic,
        )

    @property
    def _png_units(self) -> float | None:
        return self._meta.depth_units_per_metre if self._meta else None

    def _read_cameras(
        self, images: dict[str, ImageStreamInfo], camera: str | None
    ) -> Iterator[tuple[str, CameraInfo]]:
        """Yield calibrations that do not follow from the camera's name."""
        for stream, channel in self._resolution.infos.items():
            first = next(self._recording.messages([channel]), None)
            if first is None or not images[stream].width:
                continue
            with self._named(channel, first.log_time):
                found = signals.camera_info(self._type(channel).decode(first.data))
            known = calibration(camera or ROS_DEFAULT, stream, images[stream].width, images[stream].height)
            if found != known:
                yield stream, found

    def _text_layouts(self) -> dict[str, TextLayout]:
        """Return the look of the text files as far as it fits what the messages say."""
        layouts = {}
        for stream, kept in (self._meta.text if self._meta else {}).items():
            signal = {"accelerometer": self.accelerometer, "groundtruth": self.groundtruth}.get(stream)
            if signal is not None:
                stamps, values = signal.stamps, signal.values
            else:
                stamps = self.image_stamps(stream)
                values = np.empty((len(stamps), 0))
            layouts[stream] = metadata.fitting(kept, stream, stamps, values)
            dropped = len(kept.overrides) - len(layouts[stream].overrides)
            if dropped:
                self._notes.append(
                    f"{self._recording.path}: the text that its metadata keeps for {dropped} rows of "
                    f"{stream} does not say what the messages say, and is left out"
                )
        return layouts

    def _stamp(self, message: RawMessage) -> int:
        """Read the header's stamp without decoding the message."""
        data = message.data
        if len(data) < _STAMP_OFFSET + 8:
            raise InputError(
                "a message that is too short for a header",
                path=self._recording.path,
                location=f"topic {message.channel.topic}, message at {message.log_time} ns",
            )
        kind = _STAMPS[message.channel.encoding]
        if message.channel.encoding == "cdr" and not data[1] & 1:
            kind = _BIG_ENDIAN_STAMP
        return join_stamp(*kind.unpack_from(data, _STAMP_OFFSET))

    @cached_property
    def _times(self) -> dict[str, tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]]:
        """Log times and header stamps of the image streams, in order of log time."""
        streams = {self._channels[stream].id: stream for stream in IMAGE_STREAMS if stream in self._channels}
        channels = [self._channels[stream] for stream in streams.values()]
        if self._meta is not None:
            # Our own writer makes both times the same, and the index knows the log times.
            logged = {streams[channel.id]: self._recording.log_times(channel) for channel in channels}
            return {stream: (times, times) for stream, times in logged.items()}
        found: dict[str, list[tuple[int, int]]] = {stream: [] for stream in streams.values()}
        for message in self._recording.messages(channels):
            found[streams[message.channel.id]].append((message.log_time, self._stamp(message)))
        tables = {stream: np.array(pairs, np.int64).reshape(-1, 2) for stream, pairs in found.items()}
        return {stream: (table[:, 0].copy(), table[:, 1].copy()) for stream, table in tables.items()}

    @cached_property
    def _log_stamps(self) -> dict[str, npt.NDArray[np.int64]]:
        """Header stamps of the image streams in order of log time."""
        return {stream: stamps for stream, (_, stamps) in self._times.items()}

    def _file_rows(self) -> dict[str, npt.NDArray[np.intp]]:
        """Return for each message of an image stream, in order of log time, its row in file order."""
        rows = {}
        for stream, stamps in self._log_stamps.items():
            by_stamp = np.argsort(stamps, kind="stable")
            rows[stream] = np.empty(len(stamps), np.intp)
            rows[stream][by_stamp] = self._file_order(stream, len(stamps))
        return rows

    def image_stamps(self, stream: str) -> npt.NDArray[np.int64]:
        """Return the header stamps, in file order where that is known, else sorted."""
        if stream not in self._log_stamps:
            return np.empty(0, np.int64)
        stamps = np.empty_like(self._log_stamps[stream])
        stamps[self._rows[stream]] = self._log_stamps[stream]
        return stamps

    def images(
        self, streams: Collection[str] | None = None, start: int | None = None, end: int | None = None
    ) -> Iterator[Frame]:
        """Yield the images in order of their header stamps.

        Messages that were recorded out of order wait until their turn comes. Streams whose clocks disagree
        so much that many would wait are read each on its own.
        """
        wanted = [s for s in self._log_stamps if streams is None or s in streams]
        if self._most_waiting(wanted) <= _MAX_WAITING:
            return self._frames(wanted, start, end)
        return heapq.merge(*(self._frames([stream], start, end) for stream in wanted), key=frame_order)

    def _most_waiting(self, streams: list[str]) -> int:
        """Return how many messages of the streams wait at most when they are read together."""
        if not streams:
            return 0
        logged = np.concatenate([self._times[stream][0] for stream in streams])
        stamps = np.concatenate([self._times[stream][1] for stream in streams])
        arrival = np.empty(len(stamps), np.intp)
        arrival[np.argsort(logged, kind="stable")] = np.arange(len(stamps))
        leaves_after = np.maximum.accumulate(arrival[np.lexsort((logged, stamps))])
        gone = np.searchsorted(leaves_after, np.arange(len(stamps)), side="right")
        return int((np.arange(len(stamps)) + 1 - gone).max(initial=0))

    def _frames(self, streams: list[str], start: int | None, end: int | None) -> Iterator[Frame]:
        chosen = self._chosen(streams, start, end)
        if not chosen:
            return
        logged = [int(self._times[stream][0][position]) for stream, position in chosen]
        first, last = min(logged), max(logged)
        names = {self._channels[stream].id: stream for stream in streams}
        positions = {stream: int(np.searchsorted(self._times[stream][0], first)) for stream in streams}
        ranks = {key: rank for rank, key in enumerate(chosen)}
        waiting: list[tuple[int, Frame]] = []
        due = 0
        for message in self._recording.messages([self._channels[s] for s in streams], first, last):
            stream = names[message.channel.id]
            position = positions[stream]
            positions[stream] += 1
            rank = ranks.get((stream, position))
            if rank is None:
                continue
            stamp = int(self._log_stamps[stream][position])
            if self._stamp(message) != stamp:
                raise InputError(
                    f"the header says {self._stamp(message)} ns, the recording {message.log_time} ns",
                    path=self._recording.path,
                    location=f"topic {message.channel.topic}, message at {message.log_time} ns",
                )
            row = int(self._rows[stream][position])
            load = partial(self._load, stream, message)
            heapq.heappush(waiting, (rank, Frame(stream, stamp, row, load, self._frame_ids.get(stream))))
            while waiting and waiting[0][0] == due:
                yield heapq.heappop(waiting)[1]
                due += 1

    def _chosen(self, wanted: list[str], start: int | None, end: int | None) -> list[tuple[str, int]]:
        """Return (stream, position in order of log time) of the images in the order to yield them."""
        keys = [
            (stamp, IMAGE_STREAMS.index(stream), row, position)
            for stream in wanted
            for position, (stamp, row) in enumerate(
                zip(self._log_stamps[stream].tolist(), self._rows[stream].tolist(), strict=True)
            )
            if (start is None or stamp >= start) and (end is None or stamp <= end)
        ]
        return [(IMAGE_STREAMS[stream], position) for _, stream, _, position in sorted(keys)]

    def _load(self, stream: str, message: RawMessage) -> Image:
        with self._named(message.channel, message.log_time):
            decoded: Message = self._type(message.channel).decode(message.data)
            image = image_of_message(message.channel.type, decoded, stream, self._png_units)
        origin = f"{self._recording.path}, topic {message.channel.topic}, message at {message.log_time} ns"
        return replace(image, origin=origin)

    def close(self) -> None:
        """Close the recording."""
        self._recording.close()
