# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What a container has no field for, as strings that every container can keep.

A MCAP file has them in a metadata record, a rosbag2 in `custom_data`, a ROS 1 bag in a message, a rawlog in
its leading comment.
"""

from __future__ import annotations

import json
import math
import re
import zlib
from dataclasses import asdict, dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from tumtools.errors import InputError
from tumtools.formats.tum.text import fit_layout, parse_literal
from tumtools.model.camera import CAMERAS
from tumtools.model.sequence import STREAMS
from tumtools.model.text import TextLayout
from tumtools.model.time import MAX_DECIMALS

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy.typing as npt

    from tumtools.model.sequence import Sequence

RECORD: Final = "tumtools"
"""Name of the record, key or topic, wherever there is one."""
DIGEST_RECORD: Final = "tumtools.digest"
"""Name of the record or key that holds the digest of the content."""
VERSION: Final = "1"
_CRC: Final = "crc32"

_VALUE_FORMAT = re.compile(r"%(\.\d{1,2}[fe]|r)")


@dataclass(frozen=True, slots=True)
class Metadata:
    """Facts about a sequence that travel beside its data.

    Attributes:
        name: Name of the sequence.
        camera: Its camera, if known.
        depth_units_per_metre: Of depth that is kept as counts.
        licence: Of the data.
        citation: Of the data.
        streams: All streams that are there, with or without rows -> where (a topic, a label).
        text: Look of the text files.
        row_order: For streams whose rows are not sorted by stamp: for each row in the order of stamps, its
            row number in file order.

    """

    name: str
    camera: str | None = None
    depth_units_per_metre: float | None = None
    licence: str | None = None
    citation: str | None = None
    streams: Mapping[str, str] = field(default_factory=dict)
    text: Mapping[str, TextLayout] = field(default_factory=dict)
    row_order: Mapping[str, tuple[int, ...]] = field(default_factory=dict)


def gather(sequence: Sequence, places: Mapping[str, str], camera: str | None = None) -> Metadata:
    """Collect the metadata of a sequence.

    Args:
        sequence: What is written.
        places: Stream -> where the container keeps it.
        camera: Name of the calibration that is written instead of the sequence's own.

    """
    info = sequence.info
    depth = info.images.get("depth")
    stamps = {stream: sequence.image_stamps(stream) for stream in info.images}
    if sequence.groundtruth is not None:
        stamps["groundtruth"] = sequence.groundtruth.stamps
    if sequence.accelerometer is not None:
        stamps["accelerometer"] = sequence.accelerometer.stamps
    orders = {stream: order_by_stamp(values) for stream, values in stamps.items()}
    return Metadata(
        name=info.name,
        camera=camera or info.camera,
        depth_units_per_metre=depth.depth_units_per_metre if depth else None,
        licence=info.licence,
        citation=info.citation,
        streams={stream: places.get(stream, "") for stream in STREAMS if stream in stamps},
        text={stream: info.text[stream] for stream in STREAMS if stream in info.text},
        row_order={stream: order for stream, order in orders.items() if order is not None},
    )


def order_by_stamp(stamps: npt.NDArray[np.int64]) -> tuple[int, ...] | None:
    """Return the rows in stable order of their stamps, None if they are in it."""
    if len(stamps) < 2 or (stamps[1:] >= stamps[:-1]).all():  # noqa: PLR2004 - one row is in order
        return None
    return tuple(np.argsort(stamps, kind="stable").tolist())


def fitting(
    layout: TextLayout, stream: str, stamps: npt.NDArray[np.int64], values: npt.NDArray[np.float64]
) -> TextLayout:
    """Return the layout without literal rows that do not say what the data says, and with enough decimals.

    The data may have been cut or moved in time by another tool, or the metadata changed.

    Args:
        layout: As the container keeps it.
        stream: Its stream.
        stamps: Of the rows in file order, shape [n].
        values: Shape [n, k]; k = 0 for image lists.

    """

    def fits(row: int, text: str) -> bool:
        if not 0 <= row < len(stamps):
            return False
        try:
            stamp, numbers, _ = parse_literal(text, stream)
        except ValueError:
            return False
        return stamp == stamps[row] and np.array_equal(numbers, values[row], equal_nan=True)

    literal = {row: text for row, text in layout.overrides.items() if fits(row, text)}
    return fit_layout(replace(layout, overrides=literal), stamps, values)


KEYS: Final = frozenset({"version", _CRC, *(one.name for one in fields(Metadata))})
"""All that `to_strings` writes; other keys beside them are somebody else's."""


def is_metadata(strings: Mapping[str, str]) -> bool:
    """Tell whether strings that others may write to as well are ours, be they damaged."""
    return bool({_CRC, "streams"} & strings.keys())


def to_strings(metadata: Metadata) -> dict[str, str]:
    """Return the metadata as strings; nested values as JSON; nothing for what is unknown."""
    result = {"version": VERSION}
    for one in fields(metadata):
        value = getattr(metadata, one.name)
        if isinstance(value, str):
            # A name may come from a folder whose name is no UTF-8, and containers hold nothing else.
            result[one.name] = value.encode("utf-8", "backslashreplace").decode()
        elif value:
            result[one.name] = _to_json(value)
    return result | {_CRC: _crc(result)}


def _crc(strings: Mapping[str, str]) -> str:
    """Return a checksum of what is ours; not every container has one for what is beside its messages."""
    lines = "".join(f"{key}={strings[key]}\n" for key in sorted(KEYS & strings.keys()) if key != _CRC)
    return f"{zlib.crc32(lines.encode('utf-8', 'surrogatepass')):08x}"


def _to_json(value: object) -> str:
    return json.dumps(value, default=asdict, sort_keys=True, separators=(",", ":"))


def parse_object(text: str | bytes) -> dict[str, str]:
    """Read strings that a container keeps as one JSON object.

    Raises:
        ValueError: It is something else; says what.

    """
    try:
        document: object = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"no JSON can be read ({error})") from error
    if not isinstance(document, dict) or not all(isinstance(value, str) for value in document.values()):
        raise ValueError("the JSON is no object of strings")
    return document


def from_strings(strings: Mapping[str, str]) -> Metadata:
    """Read the metadata.

    Raises:
        InputError: It is of a later version, or not what `to_strings` writes.

    """
    version = strings.get("version")
    if version != VERSION:
        raise InputError(
            f"its tumtools metadata has version {version}, this tumtools reads version {VERSION}",
            hint="update tumtools",
        )
    if strings.get(_CRC) != _crc(strings):
        raise InputError(
            "the CRC of its tumtools metadata is wrong", hint="the file is damaged; get it again"
        )
    try:
        units = strings.get("depth_units_per_metre")
        text = json.loads(strings.get("text", "{}"))
        order = json.loads(strings.get("row_order", "{}"))
        return Metadata(
            name=strings["name"],
            camera=camera if (camera := strings.get("camera")) in CAMERAS else None,
            depth_units_per_metre=_units(units) if units else None,
            licence=strings.get("licence"),
            citation=strings.get("citation"),
            streams={str(k): str(v) for k, v in json.loads(strings.get("streams", "{}")).items()},
            text={str(stream): _layout(layout) for stream, layout in text.items()},
            row_order={str(stream): _order(rows) for stream, rows in order.items()},
        )
    except (KeyError, ValueError, TypeError, AttributeError, RecursionError) as error:
        raise InputError(f"its tumtools metadata is damaged: {type(error).__name__}: {error}") from error


def _units(text: str) -> float:
    units = float(text)
    if not 0 < units < math.inf:
        raise ValueError(f"{text} depth units per metre")
    return units


def _order(rows: list[int]) -> tuple[int, ...]:
    """Check that each row is named once."""
    order = tuple(map(int, rows))
    if sorted(order) != list(range(len(order))):
        raise ValueError("an order of rows that does not name each row once")
    return order


def _layout(values: dict[str, Any]) -> TextLayout:  # Any: fresh from JSON, checked field by field
    overrides = {int(row): str(text) for row, text in values["overrides"].items()}
    decimals, value_format = int(values["stamp_decimals"]), str(values["value_format"])
    if not 0 <= decimals <= MAX_DECIMALS or not _VALUE_FORMAT.fullmatch(value_format):
        raise ValueError(f"a text layout with {decimals} decimals and the value format {value_format!r}")
    return TextLayout(
        head=str(values["head"]),
        stamp_decimals=decimals,
        value_format=value_format,
        separator=str(values["separator"]),
        newline=str(values["newline"]),
        overrides=overrides,
        tail=str(values["tail"]),
        final_newline=bool(values["final_newline"]),
    )
