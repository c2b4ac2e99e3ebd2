# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The formats: a table of lazy descriptors.

A format is one package with `reader.open(path, ReadOptions) -> Sequence` and
`writer.write(Sequence, Path, WriteOptions, Progress) -> tuple[Loss, ...]`; it is imported when it is used.
"""

from __future__ import annotations

import re
import stat
import zlib
from dataclasses import dataclass, field
from functools import cached_property
from importlib import import_module
from typing import TYPE_CHECKING, BinaryIO, Final, Protocol, cast

from tumtools.errors import InputError, MissingInputError, UnsupportedInputError, UsageError

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from tumtools.formats.options import Needs, Plan, Progress, ReadOptions, WriteOptions
    from tumtools.model.sequence import Loss, Sequence

_HEAD_BYTES: Final = 1024
_GZIP, _ZSTD = b"\x1f\x8b", b"\x28\xb5\x2f\xfd"


class Reader(Protocol):
    """The module `reader` of a format."""

    def open(self, path: Path, options: ReadOptions) -> Sequence:
        """Open a source.

        Raises:
            InputError: It cannot be read.

        """


class Writer(Protocol):
    """The module `writer` of a format."""

    def write(
        self, sequence: Sequence, target: Path, options: WriteOptions, progress: Progress
    ) -> tuple[Loss, ...]:
        """Write a sequence to a staged path; return what was lost.

        Raises:
            InputError: The sequence cannot be read.
            OutputError: The target cannot be written, or cannot hold a value.

        """

    def needs(self, options: WriteOptions) -> Needs:
        """Return what the writer must be given."""

    def plan(self, sequence: Sequence, target: Path, options: WriteOptions) -> Plan:
        """Return what can be told before anything is written; of the target, its name only."""


@dataclass(frozen=True)
class Format:
    """A format and what it can do.

    Attributes:
        name: As on the command line.
        title: One line for people.
        package: Package below `tumtools.formats`.
        reads: What is read, for the table of formats.
        writes: What is written.
        suffix: Of the file that is written; empty for a folder.
        content: Pattern that the first bytes match, after gzip or zstd is undone; None if only folders.
        markers: A folder that holds files of these names or patterns is of this format, or of the one
            with most of them.
        options: Options that the writer understands -> their values, the default first.
        suffixes: Suffixes of the target that choose another container (`.tgz` for tum).
        keeps_name: Whether the target tells the name of its sequence, whatever it is called itself.

    """

    name: str
    title: str
    package: str
    reads: str
    writes: str
    suffix: str
    content: re.Pattern[bytes] | None = None
    markers: tuple[str, ...] = ()
    options: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    suffixes: tuple[str, ...] = ()
    keeps_name: bool = True

    @cached_property
    def reader(self) -> Reader:
        """Import the reader."""
        return cast("Reader", import_module(f"tumtools.formats.{self.package}.reader"))

    @cached_property
    def writer(self) -> Writer:
        """Import the writer."""
        return cast("Writer", import_module(f"tumtools.formats.{self.package}.writer"))

    def makes_folder(self, target: Path) -> bool:
        """Tell whether a folder is written to a target of this name, and not a file."""
        return not self.suffix and not target.name.endswith(self.suffixes)

    def option(self, options: WriteOptions, name: str) -> str:
        """Return the value of an option, its default if it was not given."""
        value = getattr(options, name)
        return cast("str", value) if value is not None else self.options[name][0]


FORMATS: Final[dict[str, Format]] = {
    entry.name: entry
    for entry in (
        Format(
            name="tum",
            title="Layout of the TUM RGB-D benchmark: text files and PNG images",
            package="tum",
            reads="folder, .tgz, .tar, .tar.zst, .zip without unpacking; a trajectory text file",
            writes="folder, .tgz",
            suffix="",
            suffixes=(".tgz", ".tar.gz"),
            content=re.compile(rb"(?s).{257}ustar|PK\x03\x04"),
            markers=("rgb.txt", "depth.txt", "ir.txt", "groundtruth.txt", "accelerometer.txt", "imu.txt"),
            keeps_name=False,
        ),
        Format(
            name="mcap",
            title="MCAP, with the messages of ROS 2 or ROS 1",
            package="mcap",
            reads="profiles ros1, ros2; none, lz4, zstd; foreign topics",
            writes="profiles ros2, ros1",
            suffix=".mcap",
            content=re.compile(rb"\x89MCAP0\r\n"),
            options={
                "color_encoding": ("png", "rgb8", "bgr8"),
                "depth_encoding": ("32FC1", "png", "16UC1"),
                "compression": ("zstd", "lz4", "none"),
                "layout": ("modern", "published"),
                "groundtruth": ("both", "pose", "tf", "none"),
                "profile": ("ros2", "ros1"),
                "camera": (),
                "frame_ids": (),
                "topics": (),
                "archive": (),
            },
        ),
        Format(
            name="rawlog",
            title="MRPT rawlog: 3D scans with external images",
            package="rawlog",
            reads="gzip, zstd, none; all versions of 3D scans, images and IMU; embedded and external images",
            writes="folder with NAME.rawlog, NAME_Images and groundtruth.txt",
            suffix="",
            content=re.compile(
                rb"[\x80-\xf8](mrpt::\w+::)?C[A-Z0-9]\w|[\x01-\x78]\0\0\0C[A-Z0-9]\w"
                rb"|(\x87|\x07\0\0\0)nullptr|(\x8e|\x0e\0\0\0)std::monostate"
            ),
            markers=("*.rawlog",),
            options={
                "dialect": ("modern", "legacy", "converter"),
                "compression": ("gzip", "zstd", "none"),
                "camera": (),
            },
        ),
        Format(
            name="rosbag1",
            title="ROS 1 bag, version 2.0",
            package="rosbag1",
            reads="none, bz2, lz4; with or without an index; published and foreign topics",
            writes="none, bz2, lz4",
            suffix=".bag",
            content=re.compile(rb"#ROS(BAG|RECORD) V"),
            options={
                "color_encoding": ("rgb8", "bgr8", "png"),
                "depth_encoding": ("32FC1", "png", "16UC1"),
                "compression": ("none", "bz2", "lz4"),
                "layout": ("published", "modern"),
                "groundtruth": ("tf", "pose", "both", "none"),
                "camera": (),
                "frame_ids": (),
                "topics": (),
                "archive": (),
            },
        ),
        Format(
            name="rosbag2",
            title="ROS 2 bag: a folder with metadata.yaml",
            package="rosbag2",
            reads="sqlite3, mcap; split; zstd by file and by message; foreign topics",
            writes="sqlite3, mcap",
            suffix="",
            content=re.compile(rb"SQLite format 3\x00"),
            markers=("metadata.yaml",),
            options={
                "color_encoding": ("png", "rgb8", "bgr8"),
                "depth_encoding": ("32FC1", "png", "16UC1"),
                "compression": ("none", "zstd", "lz4"),
                "layout": ("modern", "published"),
                "groundtruth": ("both", "pose", "tf", "none"),
                "storage": ("sqlite3", "mcap"),
                "ros_distro": ("humble", "iron", "jazzy", "kilted", "rolling", "galactic", "foxy"),
                "camera": (),
                "frame_ids": (),
                "topics": (),
                "archive": (),
            },
        ),
    )
}

_FILES = (".bag", ".db3", ".mcap", ".tgz")
_ALONE = (*(f"*{suffix}" for suffix in _FILES), "*/metadata.yaml", "*/rgb.txt")
"""What somebody may mean who names a folder around it."""
CONTAINER_SUFFIXES: Final = (
    ".tar.gz", ".tar.zst", ".tgz", ".tar", ".zip", ".mcap", ".bag", ".rawlog", ".db3"
)  # fmt: skip
"""What names of files end with that are read."""
_TRAJECTORY = re.compile(rb"(\xef\xbb\xbf)?\s*(#|[-+]?\d+(\.\d*)?([eE]\+\d+)?[,\s])")


def get(name: str) -> Format:
    """Return a format by name.

    Raises:
        UsageError: There is no such format.

    """
    try:
        return FORMATS[name]
    except KeyError:
        raise UsageError(f"no format {name!r}", hint=f"formats: {', '.join(FORMATS)}") from None


def detect(path: Path) -> Format:
    """Tell the format of a source from its content.

    Raises:
        InputError: There is nothing there, or nothing that any format knows.

    """
    if path.is_dir():
        found = [
            (sum(any(path.glob(marker)) for marker in entry.markers), number, entry)
            for number, entry in enumerate(FORMATS.values())
        ]
        # A rawlog and a recording may have a groundtruth.txt of the first format beside them.
        count, _, best = max(found, key=lambda item: item[:2])
        if count:
            return best
        known = ", ".join(marker for entry in FORMATS.values() for marker in entry.markers)
        found_in = [name.relative_to(path) for one in _ALONE for name in path.glob(one)]
        inside = sorted(str(name if name.suffix in _FILES else name.parent) for name in found_in)
        hint = f"name what is in it: {', '.join(inside[:5])}" if inside else None
        raise InputError(f"no sequence in this folder: none of {known}", path=path, hint=hint)
    head = _read_head(path)
    for entry in FORMATS.values():
        if entry.content is not None and entry.content.match(head):
            return entry
    if _TRAJECTORY.match(head):
        return FORMATS["tum"]
    part = any(path.name in entry.markers for entry in FORMATS.values())
    raise InputError(
        f"no format of tumtools begins with {head[:12]!r}",
        path=path,
        hint="name the folder that it is in" if part else "see: tumtools formats",
    )


def _read_head(path: Path) -> bytes:
    """Return the first bytes of a file, gzip or zstd undone."""
    try:
        if not stat.S_ISREG(path.stat().st_mode):
            raise UnsupportedInputError(
                "this is no file but a pipe or a device", path=path, hint="save it to a file first"
            )
        with path.open("rb") as file:
            head = file.read(_HEAD_BYTES)
            compressed = head.startswith((_GZIP, _ZSTD))
            if head.startswith(_GZIP):
                head = zlib.decompressobj(31).decompress(head, _HEAD_BYTES)
            elif head.startswith(_ZSTD):
                file.seek(0)
                head = _unzstd(file)
    except FileNotFoundError:
        raise MissingInputError("there is no such file or folder", path=path) from None
    except zlib.error as error:
        raise InputError(
            f"the compressed data is damaged: {error}", path=path, location="offset 0"
        ) from error
    except OSError as error:
        raise InputError(f"cannot read: {error.strerror}", path=path) from error
    if not head:
        what = "there is nothing in the compressed file" if compressed else "the file is empty (0 bytes)"
        raise InputError(what, path=path, location="offset 0", hint="its recording or download was cut off")
    return head


def _unzstd(file: BinaryIO) -> bytes:
    import zstandard  # noqa: PLC0415 - only for such files

    try:
        # Nothing comes out before a whole block of it has gone in, so the first bytes would not do.
        return zstandard.ZstdDecompressor().stream_reader(file, closefd=False).read(_HEAD_BYTES)
    except zstandard.ZstdError as error:
        raise zlib.error(str(error)) from error


def check_target(entry: Format, target: Path) -> None:
    """Refuse a target whose suffix promises a container that the format does not write.

    Raises:
        UsageError: With the names that are possible.

    """
    name = target.name.lower()
    promised = next((suffix for suffix in CONTAINER_SUFFIXES if name.endswith(suffix)), None)
    able = (*filter(None, (entry.suffix,)), *entry.suffixes)
    # A rawlog's folder may have the suffix of the file in it.
    if promised is None or target.name.endswith(able) or promised in {entry.suffix, f".{entry.name}"}:
        return
    names = [f"a name that ends with {' or '.join(able)}"] if able else []
    names += [] if entry.suffix else ["a name without such a suffix, for a folder"]
    written = target.name[-len(promised) :]
    raise UsageError(
        f"{entry.name} is not written to a target that ends with {written}",
        path=target,
        hint=f"give {', or '.join(names)}",
    )


def check_options(target: Format, options: WriteOptions) -> None:
    """Refuse options that the format does not have, and values that it does not know.

    Raises:
        UsageError: With what the format understands.

    """
    known = target.options
    if options.archive:
        for name in ("color_encoding", "depth_encoding"):
            if getattr(options, name) not in {None, "png"}:
                flag = f"--{name.replace('_', '-')} {getattr(options, name)}"
                raise UsageError(f"--archive keeps PNG files, {flag} does not", hint="leave one of them out")
    for name in options.__dataclass_fields__:
        value = getattr(options, name)
        if name in {"jobs", "cameras"} or not value:
            continue
        flag = "--" + {"frame_ids": "frame-id", "topics": "topic"}.get(name, name.replace("_", "-"))
        if name not in known:
            if name == "archive" and target.name == "tum":
                continue  # it is an archive of the PNG files anyway
            raise UsageError(f"{flag} has no meaning for {target.name}", hint="see: tumtools formats")
        if known[name] and value not in known[name]:
            raise UsageError(
                f"{flag} {value} is not possible for {target.name}", hint=f"one of {', '.join(known[name])}"
            )
