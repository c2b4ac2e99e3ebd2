# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What MRPT's classes have no place for, as JSON in the comments that a rawlog begins and ends with.

The first is one object: `tumtools` holds the strings of `tumtools.formats.metadata`, `rawlog` what only this
format needs. The last holds the digest of the content, known when all of it has been written.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any, Final

from tumtools.errors import InputError
from tumtools.formats import metadata
from tumtools.model import digest
from tumtools.model.camera import CameraInfo

if TYPE_CHECKING:
    from collections.abc import Mapping

    from tumtools.formats.metadata import Metadata
    from tumtools.model.digest import KeptDigest

_START: Final = '{"rawlog":'
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
        ValueError: They are damaged or of a later version.

    """
    document = _parsed(text)
    try:
        own = document["rawlog"]
        return Notes(
            metadata=metadata.from_strings(document[metadata.RECORD]),
            dialect=str(own["dialect"]),
            counts={stream: int(count) for stream, count in own["counts"].items()},
            frame_ids={stream: str(name) for stream, name in own["frame_ids"].items()},
            accelerometer_remainders_ns=tuple(map(int, own["accelerometer_remainders_ns"])),
            cameras={stream: _camera(entry) for stream, entry in own["cameras"].items()},
        )
    except InputError as error:
        raise ValueError(error.message) from error
    except (AttributeError, KeyError, RecursionError, TypeError) as error:
        msg = f"a part is missing or of the wrong type ({error})"
        raise ValueError(msg) from error


def _parsed(text: str) -> dict[str, Any]:
    try:
        document = json.loads(text)
    except RecursionError as error:
        raise ValueError("the JSON is too deep") from error
    if not isinstance(document, dict):
        raise ValueError("the JSON is no object")  # noqa: TRY004 - of the text, not of a caller
    return document


def _camera(entry: dict[str, Any]) -> CameraInfo:
    k, d, r, p = (tuple(map(float, entry[name])) for name in ("k", "d", "r", "p"))
    return CameraInfo(int(entry["width"]), int(entry["height"]), k, d, r, p, str(entry["distortion_model"]))
