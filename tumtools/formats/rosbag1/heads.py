# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The heads of many messages of a ROS 1 bag at once, as programs write them, instead of field by field."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.formats.ros.batches import rows_at
from tumtools.formats.rosbag1.records import Op, encode_fields, encode_header
from tumtools.model.time import NANOSECONDS_PER_SECOND

if TYPE_CHECKING:
    import numpy.typing as npt

    from tumtools.formats.rosbag1.records import Block

_ORDERS: Final = ((b"conn", b"time", b"op"), (b"conn", b"op", b"time"), (b"op", b"conn", b"time"))
"""Of the fields: ours, that of rosbag in C++, and that of rosbag in Python."""
_COLUMNS: Final = {
    b"conn": [("connection", "<u4")],
    b"time": [("seconds", "<u4"), ("nanoseconds", "<u4")],
    b"op": [("op", "u1")],
}
"""What a field is as columns of numbers."""
_EMPTY: Final = {b"conn": bytes(4), b"time": bytes(8), b"op": bytes([Op.MESSAGE])}
"""Fields with the values of no message in particular, but for the last one."""


def _layout(order: tuple[bytes, ...]) -> tuple[np.dtype[np.void], dict[str, bytes]]:
    """Return the columns of a head, and what those hold that are the same in all of them."""
    length = encode_header(Op.MESSAGE, {name: _EMPTY[name] for name in order if name != b"op"}, 0)[:4]
    columns: list[tuple[str, str]] = [("length of the head", "V4")]
    constants = {"length of the head": length}
    for name in order:
        key = f"before {name.decode()}"
        constants[key] = encode_fields({name: _EMPTY[name]})[: -len(_EMPTY[name])]
        columns += [(key, f"V{len(constants[key])}"), *_COLUMNS[name]]
    return np.dtype([*columns, ("length", "<u4")]), {**constants, "op": _EMPTY[b"op"]}


_LAYOUTS: Final = [_layout(order) for order in _ORDERS]
_SIZE: Final = _LAYOUTS[0][0].itemsize


def find_messages(
    block: Block,
    offsets: npt.NDArray[np.int64],
    connections: npt.NDArray[np.uint32],
    times: npt.NDArray[np.int64],
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]] | None:
    """Find many messages at once, if they are written as most programs do.

    Args:
        block: Where they are.
        offsets: Where an index says that they are, shape [n].
        connections: Of which connection they are, shape [n].
        times: Their log times in nanoseconds, shape [n].

    Returns:
        Where the data of each begins, and its length, int64, shape [n] each. None if their headers do not
        have their fields in one of the usual orders, or if anything is not as the index says:
        `records.find_message` reads the one and names the other.

    """
    data = np.frombuffer(block.data, np.uint8)
    if offsets.max(initial=0) > len(data) - _SIZE:
        return None
    heads = rows_at(data, offsets, _SIZE)
    for layout, constants in _LAYOUTS:
        found = heads.view(layout)[:, 0]
        said = found["seconds"].astype(np.int64) * NANOSECONDS_PER_SECOND + found["nanoseconds"]
        right = (found["connection"] == connections) & (said == times)
        for name, value in constants.items():
            right &= found[name] == np.frombuffer(value, layout[name])
        lengths = found["length"].astype(np.int64)
        starts = offsets + _SIZE
        right &= starts + lengths <= len(data)
        # Messages do not overlap; one that is named again and again would be copied as often.
        if right.all() and int(lengths.sum()) <= len(data):
            return starts, lengths
    return None
