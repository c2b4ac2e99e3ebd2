# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What MRPT's classes have no place for, as JSON in the comments that a rawlog begins and ends with.

The first is one object: `tumtools` holds the strings of `tumtools.formats.metadata`, `rawlog` what only this
format needs. The last holds the digest of the content, known when all of it has been written.
"""

from __future__ import annotations

import json
import zlib
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any, Final

from tumtools.errors import InputError
from tumtools.formats import metadata
from tumtools.model import digest
from tumtools.model.camera import CameraInfo
from tumtools.model.sequence import STREAMS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from tumtools.formats.metadata import Metadata
    from tumtools.model.digest import KeptDigest

_START: Final = '{"rawlog":'
_CRC: Final = "crc32"
_NS_PER_TICK: Final = 100
_MOST_ROWS: Final = 2**31 - 1
_MOST_NUMBERS: Final = 64
"""Of one array of a camera; no model of distortion has as many coefficients."""
_CAMERA_NUMBERS: Final = {"k": 9, "d": None, "r": 9, "p": 12}
_DIGEST_START: Final = f'{{"{metadata.DIGEST_RECORD}":'


@dataclass(frozen=True, slots=True)
class Notes:
    """What is kept of a sequence besides its observations.

    Attributes:
        metadata: What every container keeps.
        dialect: Dialect of the rawlog.
        counts: Images or rows of each stream that the sequence has, empty ones too.
        frame_ids: Coordinate frame of each stream.
        accelerometer_remainders_ns: What a tick of 100 ns cannot hold of the stamp of each row, in order
            of time; empty if all are 0.
        cameras: Intrinsics that the sequence carries, by stream.

    """

    metadata: Metadata
    dialect: str
    counts: Mapping[str, int] = field(default_factory=dict)
    frame_ids: Mapping[str, str] = field(default_factory=dict)
    accelerometer_remainders_ns: tuple[int, ...] = ()
    cameras: Mapping[str, CameraInfo] = field(default_factory=dict)


def dump(notes: Notes) -> str:
    """Return the text of the comment."""
    own = asdict(notes)
    del own["metadata"]
    own = json.loads(json.dumps(own))  # lists for tuples, as they are read
    own[_CRC] = _crc(own)
    document = {"rawlog": own, metadata.RECORD: metadata.to_strings(notes.metadata)}
    return json.dumps(document, separators=(",", ":"), sort_keys=True)


def dump_digest(strings: Mapping[str, str]) -> str:
    """Return the text of the comment that holds the digest."""
    return json.dumps({metadata.DIGEST_RECORD: dict(strings)}, separators=(",", ":"), sort_keys=True)


def is_notes(text: str) -> bool:
    """Tell whether a comment is ours and holds notes, be they damaged."""
    return text.startswith(_START)


def is_digest(text: str) -> bool:
    """Tell whether a comment is ours and holds a digest, be it damaged."""
    return text.startswith(_DIGEST_START)


def parse_digest(text: str) -> Mapping[str, KeptDigest] | None:
    """Return the digest in a comment of ours; None if it is one of another version.

    Raises:
        ValueError: It is damaged.

    """
    document = _parsed(text).get(metadata.DIGEST_RECORD)
    if not isinstance(document, dict):
        raise ValueError("the digest is no JSON object")  # noqa: TRY004 - of the text, not of a caller
    strings = {str(name): str(value) for name, value in document.items()}
    if digest.is_damaged(strings):
        raise ValueError("the digest is not what tumtools writes")
    return digest.from_strings(strings)


def parse(text: str) -> Notes:
    """Return the notes in a comment of ours.

    Raises:
        InputError: They are of a later version.
        ValueError: They are damaged.

    """
    try:
        document = _parsed(text)
        own = document["rawlog"]
        _check(own)
        return _notes(own, metadata.from_strings(document[metadata.RECORD]))
    except InputError:
        raise
    except (AttributeError, KeyError, RecursionError, TypeError, ValueError, OverflowError) as error:
        what = f"there is no {error}" if isinstance(error, KeyError) else str(error)
        raise ValueError(what) from error


def _parsed(text: str) -> dict[str, Any]:
    try:
        document = json.loads(text)
    except RecursionError as error:
        raise ValueError("the JSON is too deep") from error
    if not isinstance(document, dict):
        raise ValueError("the JSON is no object")  # noqa: TRY004 - of the text, not of a caller
    return document


def _check(own: Mapping[str, object]) -> None:
    crc = _crc(own)
    if own.get(_CRC, crc) != crc:  # files of the first days have none
        raise ValueError("its CRC is wrong")


def _crc(own: Mapping[str, object]) -> str:
    text = json.dumps({key: own[key] for key in own if key != _CRC}, separators=(",", ":"), sort_keys=True)
    return f"{zlib.crc32(text.encode()):08x}"


def _notes(own: Mapping[str, object], kept: Metadata) -> Notes:
    remainders = own["accelerometer_remainders_ns"]
    if not isinstance(remainders, list):
        raise TypeError("accelerometer_remainders_ns is no list")
    return Notes(
        metadata=kept,
        dialect=str(own["dialect"]),
        counts={stream: _integer("counts", count, _MOST_ROWS) for stream, count in _by_stream(own, "counts")},
        frame_ids={stream: str(name) for stream, name in _by_stream(own, "frame_ids")},
        accelerometer_remainders_ns=tuple(
            _integer("accelerometer_remainders_ns", rest, _NS_PER_TICK - 1) for rest in remainders
        ),
        cameras={stream: _camera(entry) for stream, entry in _by_stream(own, "cameras")},
    )


def _by_stream(own: Mapping[str, object], name: str) -> list[tuple[str, object]]:
    """Return an entry that has a value for some streams."""
    values = own[name]
    if not isinstance(values, dict) or not values.keys() <= set(STREAMS):
        raise TypeError(f"{name} is no table by stream")
    return list(values.items())


def _integer(name: str, value: object, most: int) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value <= most:
        raise ValueError(f"{str(value)[:20]} in {name}, not a whole number of 0 to {most}")
    return value


def _camera(entry: object) -> CameraInfo:
    if not isinstance(entry, dict):
        raise TypeError("a camera is no table")
    k, d, r, p = (_floats(name, entry[name], count) for name, count in _CAMERA_NUMBERS.items())
    width, height = (_integer(name, entry[name], _MOST_ROWS) for name in ("width", "height"))
    return CameraInfo(width, height, k, d, r, p, str(entry["distortion_model"]))


def _floats(name: str, values: object, count: int | None) -> tuple[float, ...]:
    """Check that these are numbers; they may be NaN, as those of a camera that is not calibrated."""
    if not isinstance(values, list) or len(values) > _MOST_NUMBERS or count not in {None, len(values)}:
        raise ValueError(f"{name} of a camera is no list of {'' if count is None else count} numbers")
    if not all(isinstance(value, float | int) and not isinstance(value, bool) for value in values):
        raise TypeError(f"{name} of a camera holds other things than numbers")
    return tuple(float(value) for value in values)
