# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What MRPT's classes have no place for, as JSON in the comment that a rawlog begins with."""

from __future__ import annotations

import json
import re
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any, Final

from tumtools.model.camera import CameraInfo
from tumtools.model.text import TextLayout

if TYPE_CHECKING:
    from collections.abc import Mapping

_KEY: Final = "tumtools"
_SCHEMA: Final = 1
_LAYOUT_PATTERNS: Final = {
    "stamp_decimals": re.compile(r"[0-9]"),
    "value_format": re.compile(r"%r|%\.\d{1,2}[ef]"),
    "separator": re.compile(r"[,\s]{1,100}"),
    "newline": re.compile(r"\r?\n"),
}
"""What a layout may be, so that a damaged one is not used."""


@dataclass(frozen=True, slots=True)
class Notes:
    """What is kept of a sequence besides its observations.

    Attributes:
        dialect: Dialect of the rawlog.
        name: Of the sequence.
        camera: Of the sequence.
        licence: Of the data.
        citation: Of the data.
        counts: Images or rows of each stream that the sequence has, empty ones too.
        text: Layout of each text file but the ground truth's, which is a file of its own.
        frame_ids: Coordinate frame of each stream.
        depth_units_per_metre: Counts that float depth came from, exactly.
        accelerometer_remainders_ns: What a tick of 100 ns cannot hold of the stamp of each row, in order
            of time; empty if all are 0.
        rows: Row in the source of each image or accelerometer row in order of time, where that differs.
        cameras: Intrinsics that the sequence carries, by stream.

    """

    dialect: str
    name: str
    camera: str | None = None
    licence: str | None = None
    citation: str | None = None
    counts: Mapping[str, int] = field(default_factory=dict)
    text: Mapping[str, TextLayout] = field(default_factory=dict)
    frame_ids: Mapping[str, str] = field(default_factory=dict)
    depth_units_per_metre: float | None = None
    accelerometer_remainders_ns: tuple[int, ...] = ()
    rows: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    cameras: Mapping[str, CameraInfo] = field(default_factory=dict)


def dump(notes: Notes) -> str:
    """Return the text of the comment."""
    return json.dumps({_KEY: {"schema": _SCHEMA, **asdict(notes)}}, separators=(",", ":"), sort_keys=True)


def parse(text: str) -> Notes | None:
    """Return the notes in a comment; None if it is somebody else's comment.

    Raises:
        ValueError: It is ours, and damaged or of a later schema.

    """
    if not text.startswith('{"' + _KEY + '"'):
        return None
    try:
        document: dict[str, Any] = json.loads(text)[_KEY]
        schema = document.pop("schema")
        if schema != _SCHEMA:
            msg = f"schema {schema} is not known, only {_SCHEMA}"
            raise ValueError(msg)
        return Notes(
            **{
                **document,
                "name": str(document["name"]),
                "counts": {stream: int(count) for stream, count in document["counts"].items()},
                "frame_ids": {stream: str(name) for stream, name in document["frame_ids"].items()},
                "text": {stream: _layout(entry) for stream, entry in document["text"].items()},
                "accelerometer_remainders_ns": tuple(map(int, document["accelerometer_remainders_ns"])),
                "rows": {stream: tuple(map(int, rows)) for stream, rows in document["rows"].items()},
                "cameras": {stream: _camera(entry) for stream, entry in document["cameras"].items()},
            }
        )
    except (AttributeError, KeyError, RecursionError, TypeError) as error:
        msg = f"a part is missing or of the wrong type ({error})"
        raise ValueError(msg) from error


def _layout(entry: dict[str, Any]) -> TextLayout:
    overrides = {int(row): str(line) for row, line in entry["overrides"].items()}
    for name, pattern in _LAYOUT_PATTERNS.items():
        if not pattern.fullmatch(str(entry[name])):
            msg = f"{name} is {entry[name]!r}"
            raise ValueError(msg)
    return TextLayout(**{**entry, "overrides": overrides})


def _camera(entry: dict[str, Any]) -> CameraInfo:
    numbers = {name: tuple(map(float, entry[name])) for name in ("k", "d", "r", "p")}
    return CameraInfo(**{**entry, **numbers})
