# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What the catalogue knows of a sequence. A value that is not known is None or absent, never zero."""

from __future__ import annotations

import re
from dataclasses import MISSING, dataclass, field, fields, is_dataclass
from typing import TYPE_CHECKING, Final, cast

from tumtools.catalogue.table import build
from tumtools.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from dataclasses import Field

KINDS: Final = ("sequence", "validation", "calibration")

SUFFIXES: Final[dict[str, str]] = {
    "tgz": ".tgz",
    "tar": ".tar",
    "tar.zst": ".tar.zst",
    "zip": ".zip",
    "bag": ".bag",
    "mcap": ".mcap",
    "bag_2hz_pointclouds": "-2hz-with-pointclouds.bag",
    "groundtruth_txt": "-groundtruth.txt",
    "rgb_avi": "-rgb.avi",
    "depth_avi": "-depth.avi",
    "ir_avi": "-ir.avi",
}
"""The files that a sequence can have, and how the name of each ends after the sequence's name."""

ARCHIVES: Final = ("tgz", "tar", "tar.zst", "zip")
"""Those that unpack to a folder in the layout of the benchmark."""
RECORDINGS: Final = (*ARCHIVES, "bag", "mcap")
"""Those that hold a sequence, in the order in which `fetch` takes them by default."""

STANDINGS: Final = ("confirmed", "single")

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+-]{0,199}")
_SHORT = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+-]*(/[A-Za-z0-9][A-Za-z0-9._+-]*)*")
_URL = re.compile(r"https?://[^\s/]+/\S+")


@dataclass(frozen=True, slots=True)
class RemoteFile:
    """A file of a sequence on the net.

    Attributes:
        urls: Where it is, best first.
        bytes: Its size.
        sha256: Its checksum, lower-case hexadecimal.
        md5: The same of MD5; for information, nothing is trusted because of it.
        standing: Of `bytes` and `sha256`: `confirmed` by two or more independent sources, or `single`.
        etag: ETag that the server was seen to send.
        last_modified: Date of the server's file, ISO 8601, UTC.
        tar_bytes: Size of the tar inside.
        members: Number of members of the tar inside.

    """

    urls: tuple[str, ...]
    bytes: int | None = None
    sha256: str | None = None
    md5: str | None = None
    standing: str | None = None
    etag: str | None = None
    last_modified: str | None = None
    tar_bytes: int | None = None
    members: int | None = None


@dataclass(frozen=True, slots=True)
class InnerFile:
    """A file inside the archive: size in bytes and checksum."""

    bytes: int | None = None
    sha256: str | None = None


@dataclass(frozen=True, slots=True)
class GroundTruthFacts:
    """Facts of the ground-truth file and the statistics that the benchmark computes from it.

    Attributes:
        bytes: Size of the file.
        sha256: Its checksum.
        md5: The same of MD5.
        rows: Number of poses.
        first_stamp: Seconds, as the file prints them.
        last_stamp: The same of the last row.
        duration_s: Last minus first stamp.
        duration_with_groundtruth_s: Median step times the number of rows.
        avg_trans_vel_m_s: Mean over displacements of one second (`extract_statistics`).
        avg_rot_vel_deg_s: The same of the rotation.
        page_trajectory_length_m: What the benchmark publishes: smoothed, and it counts across holes.
        path_length_sum_m: Length of the polyline through the poses.
        dimensions_m: Extent along x, y and z.
        median_rate_hz: One over the median step.
        duplicate_stamp_rows: Rows that repeat a stamp.
        duplicate_stamps: The stamps that occur more than once.
        gaps_over_2x_median: Steps longer than twice the median.
        gaps_over_half_s: Steps longer than half a second.
        max_gap_s: The longest step.
        min_dt_s: The shortest step between different stamps.
        inner_file_same_bytes: Whether the file in the archive was seen to have the same bytes.

    """

    bytes: int | None = None
    sha256: str | None = None
    md5: str | None = None
    rows: int | None = None
    first_stamp: str | None = None
    last_stamp: str | None = None
    duration_s: float | None = None
    duration_with_groundtruth_s: float | None = None
    avg_trans_vel_m_s: float | None = None
    avg_rot_vel_deg_s: float | None = None
    page_trajectory_length_m: float | None = None
    path_length_sum_m: float | None = None
    dimensions_m: tuple[float, ...] | None = None
    median_rate_hz: float | None = None
    duplicate_stamp_rows: int | None = None
    duplicate_stamps: tuple[str, ...] | None = None
    gaps_over_2x_median: int | None = None
    gaps_over_half_s: int | None = None
    max_gap_s: float | None = None
    min_dt_s: float | None = None
    inner_file_same_bytes: bool | None = None


@dataclass(frozen=True, slots=True)
class Entry:
    """A sequence of the catalogue; its fields are the keys of the catalogue file.

    Attributes:
        name: Official name, and name of its folder: `rgbd_dataset_freiburg1_desk`.
        short: Short name: `fr1/desk`.
        aliases: Other names by which it is found.
        camera: `fr1`, `fr2`, `fr3` or `ros-default`.
        category: Heading on the benchmark's page.
        kind: One of `KINDS`.
        page_index: Position on the benchmark's page, 1 for the first.
        public_groundtruth: Whether the ground truth is public.
        streams: What the archive holds.
        empty_streams: Which of them have a file without rows.
        files: Its files, by key of `SUFFIXES`.
        frames: Number of images by stream.
        page_size_gib: Sizes that the benchmark's page prints, in GiB, by file.
        inner_files: Facts of files inside the archive.
        groundtruth: Facts of the ground truth.
        paper_table1: The paper's Table I: duration_s, avg_trans_vel_m_s, avg_rot_vel_deg_s.
        licence: Licence of the data.
        errata: What a user should know that the numbers above do not say.
        sources: Kind of source of the facts, by key; a key covers what is below it.

    """

    name: str
    short: str | None = None
    aliases: tuple[str, ...] = ()
    camera: str | None = None
    category: str | None = None
    kind: str = "sequence"
    page_index: int | None = None
    public_groundtruth: bool | None = None
    streams: tuple[str, ...] = ()
    empty_streams: tuple[str, ...] = ()
    files: Mapping[str, RemoteFile] = field(default_factory=dict)
    frames: Mapping[str, int] = field(default_factory=dict)
    page_size_gib: Mapping[str, float] = field(default_factory=dict)
    inner_files: Mapping[str, InnerFile] = field(default_factory=dict)
    groundtruth: GroundTruthFacts | None = None
    paper_table1: Mapping[str, float] = field(default_factory=dict)
    licence: str | None = None
    errata: tuple[str, ...] = ()
    sources: Mapping[str, str] = field(default_factory=dict)

    @property
    def label(self) -> str:
        """The name to print and to type: the short one if there is one."""
        return self.short or self.name

    def source_of(self, key: str) -> str | None:
        """Return the kind of source of a fact: `tgz.sha256` falls back to `tgz`."""
        while key:
            if key in self.sources:
                return self.sources[key]
            key = key.rpartition(".")[0]
        return None


def parse_entry(value: object, path: str, location: str) -> Entry:
    """Read an entry from a table and check what the types alone do not say.

    A `name` with a slash is taken as the short name, and the slash becomes `_` in the name of the folder.

    Raises:
        InputError: A key or a value is not what it should be; the message says which and where.

    """
    name = value.get("name") if isinstance(value, dict) else None
    if isinstance(name, str):
        location = f"{location} ({name})"
        if "/" in name:
            value = {"short": name, **cast("dict[str, object]", value), "name": name.replace("/", "_")}
    nested: dict[str, type[object]] = {
        "RemoteFile": RemoteFile,
        "InnerFile": InnerFile,
        "GroundTruthFacts": GroundTruthFacts,
    }
    entry = build(Entry, value, path, location, nested)
    for key, ok, message in _rules(entry):
        if not ok:
            raise InputError(message, path=path, location=f"{location}.{key}")
    return entry


def _rules(entry: Entry) -> Iterator[tuple[str, bool, str]]:
    """Yield key, whether it is as it should be, and what to say otherwise."""
    yield (
        "name",
        bool(_NAME.fullmatch(entry.name)),
        "expected letters, digits and . _ + - only, since it names a folder",
    )
    for text in filter(None, (entry.short, *entry.aliases)):
        yield (
            "short" if text == entry.short else "aliases",
            bool(_SHORT.fullmatch(text)),
            f"not a name: {text!r}; expected something like fr1/desk",
        )
    yield "kind", entry.kind in KINDS, f"expected one of {', '.join(KINDS)}, got {entry.kind!r}"
    for key, file in entry.files.items():
        where = f"files.{key}"
        yield where, key in SUFFIXES, f"unknown kind of file; expected one of {', '.join(SUFFIXES)}"
        yield f"{where}.urls", bool(file.urls), "expected at least one URL"
        for url in file.urls:
            message = f"expected http:// or https://, a host and a path, got {url!r}"
            yield f"{where}.urls", bool(_URL.fullmatch(url)), message
        known = file.standing is None or file.standing in STANDINGS
        yield f"{where}.standing", known, f"expected one of {', '.join(STANDINGS)}"
        yield from _sums(where, file.sha256, file.md5)
    for key, inner in entry.inner_files.items():
        yield from _sums(f"inner_files.{key}", inner.sha256)
    if entry.groundtruth is not None:
        yield from _sums("groundtruth", entry.groundtruth.sha256, entry.groundtruth.md5)


def _sums(where: str, sha256: str | None, md5: str | None = None) -> Iterator[tuple[str, bool, str]]:
    for name, digits, text in (("sha256", 64, sha256), ("md5", 32, md5)):
        ok = text is None or bool(re.fullmatch(f"[0-9a-f]{{{digits}}}", text))
        yield f"{where}.{name}", ok, f"expected {digits} lower-case hexadecimal digits"


def as_table(value: object) -> object:
    """Turn an entry, or a part of one, into plain tables: what `parse_entry` reads. Unknown stays absent."""
    if is_dataclass(value):
        pairs = ((field, getattr(value, field.name)) for field in fields(value))
        return {field.name: as_table(item) for field, item in pairs if item or item != _default(field)}
    if isinstance(value, dict):
        return {key: as_table(item) for key, item in value.items()}
    if isinstance(value, tuple):
        return [as_table(item) for item in value]
    return value


def _default(item: Field[object]) -> object:
    return item.default if item.default_factory is MISSING else item.default_factory()
