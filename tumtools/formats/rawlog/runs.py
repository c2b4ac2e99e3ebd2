# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Inertial observations that differ in nothing but time and values: read many at a time.

Nine of ten objects of a recording are such: the rows of one accelerometer, all of the same length.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.formats.rawlog.archive import text_bytes
from tumtools.model.time import stamp_to_ticks

if TYPE_CHECKING:
    import numpy.typing as npt

    from tumtools.formats.rawlog.archive import Input, Record

TICKS: Final = range(stamp_to_ticks(-(2**63)) + 1, stamp_to_ticks(2**63 - 1) + 1)
"""Times that can be a stamp: from 1678 to 2262."""
_END_MARK, _TIME, _COUNT = 1, 8, 4
"""Bytes of an object's end mark, of a time, of the count of a vector."""
_VECTOR_UNTIL: Final = 3
"""Versions of `CObservationIMU` up to this have a count before their values."""
_ROWS: Final = 32
"""Objects that are compared at a time; between two images there are about twenty."""


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """Objects behind one that they are like.

    Attributes:
        record: That one.
        ticks: Their times, uint64 [n]; none is 0.
        values: Their values in the order of the file, [n, channels].

    """

    record: Record
    ticks: npt.NDArray[np.uint64]
    values: npt.NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.ticks)


def places(version: int, label: str, nbytes: int) -> tuple[int, int]:
    """Return where time and values of a `CObservationIMU` begin, counted from its end (negative).

    From there: end mark, label with its length, values, before version 4 their count, time.

    Args:
        version: Of the class.
        label: Of the sensor.
        nbytes: Of all values.

    """
    values = -(_END_MARK + len(text_bytes(label)) + nbytes)
    return values - _TIME - (_COUNT if version <= _VECTOR_UNTIL else 0), values


def read_run(source: Input, record: Record) -> Run | None:
    """Read the objects that follow one and are like it, as far as they are at hand; None if there are none.

    An object that needs a closer look, as its time is none or no stamp, ends the run.
    """
    if record.type != "CObservationIMU" or record.old_framing:
        return None
    template = np.frombuffer(source.since(record.offset), np.uint8)
    if not template.size:
        return None
    known = record.array("values")
    time, values = (
        template.size + place for place in places(record.version, record.text("label"), known.nbytes)
    )
    variable = np.zeros(template.size, bool)
    variable[time : time + _TIME] = True
    variable[values : values + known.nbytes] = True
    tables = []
    more = True
    while more:
        data = source.at_hand(_ROWS * template.size)
        table = np.frombuffer(data, np.uint8, count=len(data) // template.size * template.size)
        table = table.reshape(-1, template.size)
        alike = ((table == template) | variable).all(axis=1) & _in_range(_ticks(table, time))
        count = len(alike) if alike.all() else int(np.argmin(alike))
        source.take(count * template.size)
        tables.append(table[:count])
        more = count == _ROWS
    rows = np.concatenate(tables)
    if not len(rows):
        return None
    numbers = _columns(rows, values, known.nbytes).view(known.dtype)
    return Run(record, _ticks(rows, time), numbers.astype(np.float64))


def _in_range(ticks: npt.NDArray[np.uint64]) -> npt.NDArray[np.bool_]:
    found: npt.NDArray[np.bool_] = (ticks >= np.uint64(TICKS.start)) & (ticks < np.uint64(TICKS.stop))
    return found


def _ticks(table: npt.NDArray[np.uint8], start: int) -> npt.NDArray[np.uint64]:
    return _columns(table, start, _TIME).view("<u8")[:, 0].astype(np.uint64, copy=False)


def _columns(table: npt.NDArray[np.uint8], start: int, size: int) -> npt.NDArray[np.uint8]:
    return np.ascontiguousarray(table[:, start : start + size])
