# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""MRPT's `TCamera` and our intrinsics, both ways."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.model.camera import CameraInfo

if TYPE_CHECKING:
    import numpy.typing as npt

    from tumtools.formats.rawlog.archive import Record

_NONE, _PLUMB_BOB, _KANNALA_BRANDT = 0, 1, 2
_PLACES: Final = 8
_ALL_PLACES_SINCE: Final = 3
_FISHEYE: Final = (0, 1, 4, 5)
_SLOTS: Final[dict[str, tuple[int, ...]]] = {
    "plumb_bob": (0, 1, 2, 3, 4),
    "rational_polynomial": (0, 1, 2, 3, 4, 5, 6, 7),
    "equidistant": _FISHEYE,
    "kannala_brandt": _FISHEYE,
}
"""Where the coefficients of a model are among k1 k2 p1 p2 k3 k4 k5 k6."""


def camera_of(record: Record | None, swapped: bool = False) -> CameraInfo | None:
    """Return the intrinsics of a `TCamera`; None if they are not set.

    Args:
        record: The camera.
        swapped: Rows and columns may be the other way round, as TUM sequences had it before MRPT 2.4; they
            are if the principal point does not lie as in an upright image.

    """
    if record is None or record.type != "TCamera":
        return None
    if "fx_fy_cx_cy" in record:
        fx, fy, cx, cy = record.array("fx_fy_cx_cy").tolist()
    else:
        matrix = record.child("intrinsics")
        values = [] if matrix is None else matrix.array("values").tolist()
        if len(values) != 9:  # noqa: PLR2004 - 3 x 3
            return None
        fx, cx, fy, cy = values[0], values[2], values[4], values[5]
    rows, columns = record.integer("rows", 480), record.integer("columns", 640)
    if swapped and rows > columns and cx >= cy:
        rows, columns = columns, rows
    if not (fx > 0 and fy > 0 and rows and columns):
        return None
    pinhole = CameraInfo.pinhole(fx, fy, cx, cy, width=columns, height=rows)
    model, slots = _model_of(record)
    distortion = record.array("distortion").tolist()
    return replace(pinhole, d=tuple(distortion[slot] for slot in slots), distortion_model=model)


def _model_of(record: Record) -> tuple[str, tuple[int, ...]]:
    """Return the model by its ROS name, and where its coefficients are."""
    if record.integer("model") == _KANNALA_BRANDT:
        return "equidistant", _SLOTS["equidistant"]
    plain = _SLOTS["plumb_bob"]
    if record.array("distortion")[len(plain) :].any():
        return "rational_polynomial", _SLOTS["rational_polynomial"]
    return "plumb_bob", plain


def distortion_of(camera: CameraInfo, version: int) -> tuple[npt.NDArray[np.float64], int]:
    """Return the coefficients and the model of a camera as a version of `TCamera` holds them.

    Versions before 3 have five coefficients; what does not fit is left out.
    """
    places = np.zeros(_PLACES)
    slots = _SLOTS.get(camera.distortion_model, ())
    for slot, value in zip(slots, camera.d, strict=False):
        places[slot] = value
    model = _KANNALA_BRANDT if slots == _SLOTS["equidistant"] else _PLUMB_BOB if places.any() else _NONE
    return places if version >= _ALL_PLACES_SINCE else places[: len(_SLOTS["plumb_bob"])], model
