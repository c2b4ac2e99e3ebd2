# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""From a recording to a sequence: decoded signals, and images as a lazy stream in order of their stamps."""

from __future__ import annotations

import heapq
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.errors import InputError, UsageError
from tumtools.formats.cameras import own_calibrations
from tumtools.formats.ros import signals
from tumtools.formats.ros.besides import added_transforms, beside_the_streams, has_window, offers
from tumtools.formats.ros.codec import MessageType
from tumtools.formats.ros.collectors import header_stamp
from tumtools.formats.ros.gather import Gathered, gather
from tumtools.formats.ros.images import image_of_message
from tumtools.formats.ros.kept import fitting_layouts, read_kept
from tumtools.formats.ros.layouts import LAYOUTS, is_default_frame
from tumtools.formats.ros.order import ImageOrder
from tumtools.formats.ros.tf import TransformTree, find_path, losses_of_path, way_of
from tumtools.formats.ros.topics import loss_of, resolve
from tumtools.model.camera import camera_of_name
from tumtools.model.sequence import (
    IMAGE_STREAMS,
    Frame,
    ImageStreamInfo,
    Loss,
    Sequence,
    SequenceInfo,
    frame_order,
)
from tumtools.model.signals import Accelerometer, Trajectory

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping

    import numpy.typing as npt

    from tumtools.formats.options import ReadOptions
    from tumtools.formats.ros.codec import Message
    from tumtools.formats.ros.collectors import Times
    from tumtools.formats.ros.recording import Channel, RawMessage, Recording
    from tumtools.model.camera import CameraInfo
    from tumtools.model.image import Image

_WORLD: Final = "world"
_BODIES: Final = frozenset(layout.body for layout in LAYOUTS.values())
"""Frames that our own transforms place in the world."""
_MAX_WAITING: Final = 32
"""Messages; each may be a raw image."""


class RosSequence(Sequence):
    """A sequence in a recording of ROS.

    Args:
        recording: Closed with the sequence.
        name: What to call it if it does not say so itself.
        options: How to read it.

    Attributes:
        other_cameras: Image stream -> messages of CameraInfo that differ from the first, where there are any
            in a foreign recording.

    Raises:
        UsageError: The topics asked for do not fit, or several could be meant.
        InputError: The recording is damaged.

    """

    def __init__(self, recording: Recording, name: str, options: ReadOptions) -> None:
        self._recording = recording
        kept = read_kept(recording, salvage=options.salvage)
        self._meta = kept.metadata
        places = self._meta.streams if self._meta else {}
        self._resolution = resolve(recording, options, places)
        self._channels = self._resolution.channels
        self._types: dict[int, MessageType] = {}
        self._order = {
            stream: np.array(order, np.intp)
            for stream, order in (self._meta.row_order.items() if self._meta else ())
        }
        self._frame_ids: dict[str, str] = {}
        self._camera_frame: str | None = None
        self._is_as_written = self._meta is not None
        self._way = ""
        self._unused: list[Loss] = []
        self._notes: list[str] = []
        if all(channel.count == 0 for channel in recording.channels):
            self._notes.append("the recording has no messages")
        streams = [stream for stream in IMAGE_STREAMS if stream in self._channels or stream in places]
        images = {stream: self._image_info(stream) for stream in streams}
        found = gather(
            recording,
            self._resolution,
            self._type,
            self._named,
            bodies=_BODIES,
            stamps=not self._is_as_written,
        )
        times = found.times or self._logged()
        self._unused += beside_the_streams(found)
        self.other_cameras = found.other_cameras
        images = {stream: _counted(info, times.get(stream)) for stream, info in images.items()}
        if found.accelerometer is not None:
            order = self._to_file_order("accelerometer", found.accelerometer.stamps)
            self.accelerometer = found.accelerometer.take(order)
            self._note_frame("accelerometer", found.frame_ids.get("accelerometer", ""))
        elif "accelerometer" in places:
            self.accelerometer = Accelerometer.empty()
        self.groundtruth = self._groundtruth(found, expected="groundtruth" in places)
        self._unused += offers(self._resolution, composed=bool(self._way))
        if self._meta is not None:
            self._unused += added_transforms(recording, self._channels.values(), self.groundtruth)
        self._images = ImageOrder(
            times, {stream: self._file_rows(stream, times[stream][1]) for stream in times}
        )
        text, misfits = fitting_layouts(self._meta, self, recording.path)
        self._notes += misfits
        meta_camera = self._meta.camera if self._meta else None
        camera = meta_camera or (None if self._meta else camera_of_name(name))
        self.cameras = own_calibrations(dict(self._read_cameras()), camera, images)
        self.info = SequenceInfo(
            name=self._meta.name if self._meta else name,
            format=recording.format,
            camera=camera,
            images=images,
            sources=self._sources(),
            text=text,
            frame_ids=self._frame_ids,
            licence=self._meta.licence if self._meta else None,
            citation=self._meta.citation if self._meta else None,
            digest=kept.digest,
            not_carried=(
                *recording.left_out,
                *kept.losses,
                *recording.not_carried,
                *self._resolution.not_carried,
                *self._unused,
            ),
            warnings=recording.warnings + kept.warnings + self._resolution.warnings + tuple(self._notes),
        )

    @property
    def channels(self) -> Mapping[str, Channel]:
        """The channel of each stream."""
        return self._channels

    @property
    def info_channels(self) -> Mapping[str, Channel]:
        """The channel of the CameraInfo of each image stream that has one."""
        return self._resolution.infos

    def decode(self, channels: Collection[Channel]) -> Iterator[Message]:
        """Yield the decoded messages of channels, in order of log time.

        Raises:
            InputError: The recording is damaged.

        """
        for message in self._recording.messages(channels):
            with self._named(message.channel, message.log_time):
                yield self._type(message.channel).decode(message.data)

    def times(self, stream: str) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
        """Return header stamps and log times of an image stream, in order of log time."""
        return self._images.times[stream][1], self._recording.log_times(self._channels[stream])

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

    def _logged(self) -> dict[str, Times]:
        """Return the times of images that we wrote: both are the same, and the index knows them."""
        streams = [stream for stream in IMAGE_STREAMS if stream in self._channels]
        logged = {stream: self._recording.log_times(self._channels[stream]) for stream in streams}
        return {stream: (times, times) for stream, times in logged.items()}

    def _groundtruth(self, found: Gathered, *, expected: bool) -> Trajectory | None:
        poses = found.poses
        if self._resolution.transforms:
            poses = self._compose(found.tree)
        elif poses is not None:
            self._note_frame("groundtruth", found.frame_ids.get("groundtruth", ""))
        elif expected:
            return Trajectory.empty()
        return None if poses is None else poses.take(self._to_file_order("groundtruth", poses.stamps))

    def _compose(self, tree: TransformTree) -> Trajectory | None:
        """Return the trajectory of the camera in a tree of transforms."""
        resolution = self._resolution
        try:
            path = find_path(tree, self._camera_frame, resolution.frames or "")
        except UsageError as error:
            raise UsageError(error.message, path=self._recording.path, hint=error.hint) from None
        if not path:
            if resolution.frames is not None:
                raise UsageError(
                    "it is not clear which transforms are the ground truth",
                    path=self._recording.path,
                    hint=f"write --topic groundtruth=/tf:WORLD.CAMERA; frames: {', '.join(tree.frames)}",
                )
            self._unused += [loss_of(channel) for channel in resolution.transforms]
            return None
        found, left_out = tree.compose(path)
        root, way = path[0][0], way_of(path)
        self._way = f"{resolution.transforms[0].topic}: {way}"
        self._note_frame("groundtruth", root)
        if resolution.frames is None and root != _WORLD:
            self._notes.append(
                f"ground truth is taken from transforms, {way}; "
                "choose others with --topic groundtruth=/tf:WORLD.CAMERA"
            )
        self._unused += losses_of_path(tree, path, left_out)
        return found

    def _sources(self) -> dict[str, str]:
        """Return the topics of the signals; ground truth may be composed from transforms."""
        found = {stream: channel.topic for stream, channel in self._channels.items()}
        found |= {"groundtruth": self._way} if self._way else {}
        signals = {"accelerometer": self.accelerometer, "groundtruth": self.groundtruth}
        return {
            stream: found[stream] for stream, one in signals.items() if one is not None and stream in found
        }

    def _note_frame(self, stream: str, frame_id: str) -> None:
        if not is_default_frame(frame_id):
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
            # We write both times alike; what was played and recorded again has others.
            self._is_as_written &= header_stamp(first) == first.log_time
        header = message.get("header")
        if list(message)[:1] != ["header"] or not isinstance(header, dict) or "stamp" not in header:
            raise InputError(
                "its image messages do not begin with a header",
                path=self._recording.path,
                location=f"topic {channel.topic}",
            )
        frame_id = str(header.get("frame_id", ""))
        self._camera_frame = self._camera_frame or frame_id
        self._note_frame(stream, frame_id)
        return ImageStreamInfo(
            count=1,
            encoding=image.encoding,
            width=image.width,
            height=image.height,
            depth_units_per_metre=image.depth_units_per_metre,
            frame_id=self._frame_ids.get(stream),
            nbytes=image.nbytes,
            compression=image.compression,
            source=channel.topic,
        )

    @property
    def _png_units(self) -> float | None:
        return self._meta.depth_units_per_metre if self._meta else None

    def _read_cameras(self) -> Iterator[tuple[str, CameraInfo]]:
        """Yield the calibrations of the first messages."""
        for stream, channel in self._resolution.infos.items():
            first = next(self._recording.messages([channel]), None)
            if first is not None:
                with self._named(channel, first.log_time):
                    message = self._type(channel).decode(first.data)
                    yield stream, signals.camera_info(message)
                if has_window(message):
                    why = "a sequence has calibrations of whole images"
                    what = "binning, region of interest or rectification"
                    self._unused.append(Loss(channel.topic, what, channel.count or 1, why))

    def _file_rows(self, stream: str, stamps: npt.NDArray[np.int64]) -> npt.NDArray[np.intp]:
        """Return for each message of an image stream, in order of log time, its row in file order."""
        rows = np.empty(len(stamps), np.intp)
        rows[np.argsort(stamps, kind="stable")] = self._file_order(stream, len(stamps))
        return rows

    def image_stamps(self, stream: str) -> npt.NDArray[np.int64]:
        """Return the header stamps, in file order where that is known, else sorted."""
        return self._images.in_file_order(stream)

    def images(
        self, streams: Collection[str] | None = None, start: int | None = None, end: int | None = None
    ) -> Iterator[Frame]:
        """Yield the images in order of their header stamps.

        Messages that were recorded out of order wait until their turn comes. Streams whose clocks disagree
        so much that many would wait are read each on its own.
        """
        wanted = [s for s in self._images.times if streams is None or s in streams]
        if self._images.most_waiting(wanted) <= _MAX_WAITING:
            return self._frames(wanted, start, end)
        return heapq.merge(*(self._frames([stream], start, end) for stream in wanted), key=frame_order)

    def _frames(self, streams: list[str], start: int | None, end: int | None) -> Iterator[Frame]:
        chosen, times = self._images.chosen(streams, start, end), self._images.times
        if not chosen:
            return
        logged = [int(times[stream][0][position]) for stream, position in chosen]
        first, last = min(logged), max(logged)
        names = {self._channels[stream].id: stream for stream in streams}
        positions = {stream: int(np.searchsorted(times[stream][0], first)) for stream in streams}
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
            stamp = int(times[stream][1][position])
            with self._named(message.channel, message.log_time):
                if header_stamp(message) != stamp:
                    raise InputError(
                        f"the header says {header_stamp(message)} ns, the recording {message.log_time} ns"
                    )
            row = int(self._images.rows[stream][position])
            load = partial(self._load, stream, message)
            heapq.heappush(waiting, (rank, Frame(stream, stamp, row, load, self._frame_ids.get(stream))))
            while waiting and waiting[0][0] == due:
                yield heapq.heappop(waiting)[1]
                due += 1

    def _load(self, stream: str, message: RawMessage) -> Image:
        with self._named(message.channel, message.log_time):
            decoded: Message = self._type(message.channel).decode(message.data)
            image = image_of_message(message.channel.type, decoded, stream, self._png_units)
        origin = f"{self._recording.path}, topic {message.channel.topic}, message at {message.log_time} ns"
        return replace(image, origin=origin)

    def close(self) -> None:
        """Close the recording."""
        self._recording.close()


def _counted(info: ImageStreamInfo, times: Times | None) -> ImageStreamInfo:
    """Return what is known of a stream of whose images only the first has been looked at."""
    count = 0 if times is None else len(times[0])
    return replace(info, count=count, nbytes=info.nbytes * count)
