# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The classes of MRPT that tumtools reads and writes, every version, as data.

Read from MRPT's released sources (0.9 to 3.x) and checked against files that MRPT wrote. The fields are
in the order of the stream; `since` and `until` are versions of the class.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from tumtools.formats.rawlog.fields import (
    Block,
    Child,
    Children,
    Class,
    Codec,
    Condition,
    Field,
    Groups,
    Names,
    Number,
    Text,
    Vector,
)

if TYPE_CHECKING:
    from tumtools.formats.rawlog.archive import Fields

FLAG: Final = Number("B")
U8, I8, U32, I32, U64 = Number("B"), Number("b"), Number("I"), Number("i"), Number("Q")
F32, F64 = Number("f"), Number("d")
TIME: Final = U64
"""Ticks of 100 ns since 1601; 0 is no time."""
TEXT, CHILD, CHILDREN = Text(), Child(), Children()
BYTES: Final = Vector("u1")


def _int(fields: Fields, name: str, default: int = 0) -> int:
    value = fields.get(name, default)
    return value if isinstance(value, int) else default


def _set(name: str, default: int = 0) -> Condition:
    """Return the condition that a flag is set; versions without the flag mean `default`."""
    return lambda fields: bool(_int(fields, name, default))


def _not(name: str) -> Condition:
    return lambda fields: not _int(fields, name)


def _cells(fields: Fields) -> int:
    return _int(fields, "rows") * _int(fields, "columns")


# --- images: an external file name, or a grey or colour body (CImage versions 2 to 10) ---------------

ZIP_ABOVE: Final = 16384
"""CImage version 4 deflates grey images larger than this many bytes."""
DEPTH_CODES: Final = ("u1", "i1", "<u2", "<i2", "<i4", "<f4", "<f8")
"""Pixel types of CImage version 9, by number."""


def _grey(fields: Fields) -> bool:
    return not _int(fields, "external") and not _int(fields, "colour")


def _colour(fields: Fields) -> bool:
    return not _int(fields, "external") and bool(_int(fields, "colour"))


def _grey_and(zipped: bool, above: bool = False) -> Condition:
    """Grey; deflated as the flag says (`above`: as the size says)."""

    def condition(fields: Fields) -> bool:
        state = _int(fields, "byte_count") > ZIP_ABOVE if above else bool(_int(fields, "zipped"))
        return _grey(fields) and state is zipped

    return condition


def _colour_jpeg(fields: Fields) -> bool:
    return _colour(fields) and _int(fields, "width") >= 1 and _int(fields, "height") >= 1


def _colour_raw(fields: Fields) -> bool:
    return _colour(fields) and _int(fields, "width") < 0 and _int(fields, "height") < 0


def _rgb_bytes(fields: Fields) -> int:
    return 3 * abs(_int(fields, "width") * _int(fields, "height"))


_GREY_BYTES: Final = Block("u1", "byte_count")

_CIMAGE: Final = Class(
    (*range(11), 100),
    (
        Field("width", U32, until=0),
        Field("height", U32, until=0),
        Field("channels", U32, until=0),
        Field("origin_top_left", FLAG, until=0),
        Field("data", BYTES, until=0),
        Field("jpeg", BYTES, since=1, until=1),
        Field("external", FLAG, since=6),
        Field("file", TEXT, since=6, when=_set("external")),
        Field("colour", FLAG, since=2, until=10, when=_not("external")),
        Field("width", I32, since=2, until=10, when=_grey),
        Field("height", I32, since=2, until=10, when=_grey),
        Field("origin", I32, since=2, until=9, when=_grey),
        Field("byte_count", I32, since=2, until=9, when=_grey),
        Field("byte_count", U32, since=10, until=10, when=_grey),
        Field("pixel_type", I32, since=9, until=10, when=_grey),
        Field("zipped", FLAG, since=5, until=9, when=_grey),
        Field("data", _GREY_BYTES, since=2, until=2, when=_grey),
        Field("zlib", BYTES, since=3, until=3, when=_grey),
        Field("zlib", BYTES, since=4, until=4, when=_grey_and(True, above=True)),
        Field("data", _GREY_BYTES, since=4, until=4, when=_grey_and(False, above=True)),
        Field("zlib", BYTES, since=5, until=9, when=_grey_and(True)),
        Field("data", _GREY_BYTES, since=5, until=9, when=_grey_and(False)),
        Field("data", _GREY_BYTES, since=10, until=10, when=_grey),
        Field("jpeg", BYTES, since=2, until=6, when=_colour),
        Field("width", I32, since=7, until=10, when=_colour),
        Field("height", I32, since=7, until=10, when=_colour),
        Field("jpeg", BYTES, since=7, until=9, when=_colour_jpeg),
        Field("data", Block("u1", _rgb_bytes), since=8, until=9, when=_colour_raw),
        Field("data", Block("u1", _rgb_bytes), since=10, until=10, when=_colour),
    ),
)

# --- 3D scans -----------------------------------------------------------------------------------------

_POINTS: Final = _set("has_points", 1)
_RANGE: Final = _set("has_range", 1)
_LABELS: Final = _set("has_labels")


def _label_dtype(fields: Fields) -> str:
    """Labels have 1, 2, 4 or 8 bytes; 3 are stored as 4, and 5 to 7 as 8."""
    size = _int(fields, "label_bytes")
    return "u1" if size <= 1 else "<u2" if size <= 2 else "<u4" if size <= 4 else "<u8"  # noqa: PLR2004 - bytes of the types


def _label_cells(fields: Fields) -> int:
    return _int(fields, "label_rows") * _int(fields, "label_columns")


_LAYER: Final = (
    Field("name", TEXT),
    Field("columns", U32),
    Field("rows", U32),
    Field("values", Block("<u2", _cells)),
)

_SCAN_3D: Final = Class(
    tuple(range(11)),
    (
        Field("max_range", F32),
        Field("sensor_pose", CHILD),
        Field("has_points", FLAG, since=1),
        Field("point_count", U32, when=_POINTS),
        Field("x", Block("<f4", "point_count"), when=_POINTS),
        Field("y", Block("<f4", "point_count"), when=_POINTS),
        Field("z", Block("<f4", "point_count"), when=_POINTS),
        Field("valid", Block("u1", "point_count"), until=0, when=_POINTS),
        Field("pixel_column", Block("<u2", "point_count"), since=8, when=_POINTS),
        Field("pixel_row", Block("<u2", "point_count"), since=8, when=_POINTS),
        Field("has_range", FLAG, since=1),
        Field("range_units", F32, since=9),
        Field("range_matrix", CHILD, since=1, until=8, when=_RANGE),
        Field("rows", U32, since=9, when=_RANGE),
        Field("columns", U32, since=9, when=_RANGE),
        Field("range", Block("<u2", _cells), since=9, when=_RANGE),
        Field("has_intensity", FLAG, since=1),
        Field("intensity", CHILD, since=1, when=_set("has_intensity")),
        Field("has_confidence", FLAG, since=1),
        Field("confidence", CHILD, since=1, when=_set("has_confidence")),
        Field("camera", CHILD, since=2),
        Field("camera_intensity", CHILD, since=4),
        Field("intensity_pose", CHILD, since=4),
        Field("std_error", F32),
        Field("time", TIME),
        Field("label", TEXT),
        Field("points_external", FLAG, since=3),
        Field("points_file", TEXT, since=3),
        Field("range_external", FLAG, since=3),
        Field("range_file", TEXT, since=3),
        Field("range_is_depth", FLAG, since=5),
        Field("channel", I8, since=6),
        Field("has_labels", FLAG, since=7),
        Field("label_version", U8, since=7, when=_LABELS),
        Field("label_bytes", U8, since=7, when=_LABELS),
        Field("label_rows", U32, since=7, when=_LABELS),
        Field("label_columns", U32, since=7, when=_LABELS),
        Field("labels", Block(_label_dtype, _label_cells), since=7, when=_LABELS),
        Field("label_names", Names(), since=7, when=_LABELS),
        Field("layers", Groups(_LAYER), since=10),
    ),
)

# --- 2D motion ----------------------------------------------------------------------------------------

_FROM_ODOMETRY: Final = _not("method")


def _not_from_odometry(fields: Fields) -> bool:
    return bool(_int(fields, "method"))


_MOVEMENT_2D: Final = Class(
    (4, 5, 6, 7),
    (
        Field("method", I32),
        Field("increment", CHILD, when=_FROM_ODOMETRY),
        Field("model", I32, when=_FROM_ODOMETRY),
        Field("gaussian", Block("<f4", 6), when=_FROM_ODOMETRY),
        Field("particles", I32, when=_FROM_ODOMETRY),
        Field("thrun", Block("<f4", 4), when=_FROM_ODOMETRY),
        Field("thrun_extra", Block("<f4", 2), since=5, when=_FROM_ODOMETRY),
        Field("pdf", CHILD, when=_not_from_odometry),
        Field("has_velocity", FLAG),
        Field("velocity", Block("<f4", 2), until=6),
        Field("velocity", Block("<f8", 3), since=7, when=_set("has_velocity")),
        Field("has_encoders", FLAG),
        Field("encoders", Block("<i4", 2), until=6),
        Field("encoders", Block("<i4", 2), since=7, when=_set("has_encoders")),
        Field("time", TIME, since=6),
    ),
)

# --- the table ----------------------------------------------------------------------------------------

CLASSES: Final[dict[str, Class]] = {
    "CPose2D": Class(
        (0, 1), (Field("values", Block("<f4", 3), until=0), Field("values", Block("<f8", 3), 1))
    ),
    "CPoint3D": Class(
        (0, 1), (Field("values", Block("<f4", 3), until=0), Field("values", Block("<f8", 3), 1))
    ),
    "CPose3DQuat": Class((0,), (Field("values", Block("<f8", 7)),)),
    # 0 and 1: a 4x4 matrix; 2: x y z and the quaternion, scalar first; 3: x y z and the rotation by row.
    "CPose3D": Class(
        (0, 1, 2, 3),
        (
            Field("matrix", CHILD, until=1),
            Field("values", Block("<f8", 7), since=2, until=2),
            Field("values", Block("<f8", 12), since=3),
        ),
    ),
    # 21 numbers: the diagonal, then the upper triangle by row; of x y z yaw pitch roll.
    "CPose3DPDFGaussian": Class(
        (0, 1),
        (
            Field("mean", CHILD),
            Field("matrix", CHILD, until=0),
            Field("covariance", Block("<f8", 21), since=1),
        ),
    ),
    "CPosePDFGaussian": Class((2,), (Field("mean", CHILD), Field("covariance", Block("<f8", 6)))),
    "CMatrixF": Class(
        (0,), (Field("rows", U32), Field("columns", U32), Field("values", Block("<f4", _cells)))
    ),
    "CMatrixD": Class(
        (0,), (Field("rows", U32), Field("columns", U32), Field("values", Block("<f8", _cells)))
    ),
    "TCamera": Class(
        tuple(range(7)),
        (
            Field("focal_length_metres", F64),
            Field("distortion", Block("<f8", 5), until=2),
            Field("distortion", Block("<f8", 8), since=3),
            Field("intrinsics", CHILD, until=3),
            Field("fx_fy_cx_cy", Block("<f8", 4), since=4),
            Field("old_distortion", CHILD, until=0),
            Field("rows", U32, since=2),
            Field("columns", U32, since=2),
            Field("name", TEXT, since=5),
            Field("model", U8, since=6),
        ),
    ),
    "CImage": _CIMAGE,
    "CObservation3DRangeScan": _SCAN_3D,
    "CObservationIMU": Class(
        tuple(range(5)),
        (
            Field("sensor_pose", CHILD),
            Field("present", BYTES, until=3),
            Field("present", Block("u1", 31), since=4),
            Field("time", TIME),
            Field("values", Vector("<f4"), until=0),
            Field("values", Vector("<f8"), since=1, until=3),
            Field("values", Block("<f8", 31), since=4),
            Field("label", TEXT),
        ),
    ),
    "CObservationImage": Class(
        tuple(range(5)),
        (
            Field("sensor_pose", CHILD),
            Field("distortion", CHILD, until=3),
            Field("intrinsics", CHILD, until=3),
            Field("camera", CHILD, since=4),
            Field("image", CHILD),
            Field("time", TIME, since=1),
            Field("focal_length_metres", F64, since=2, until=3),
            Field("label", TEXT, since=3),
        ),
    ),
    "CObservationComment": Class(
        (0, 1), (Field("text", TEXT), Field("time", TIME), Field("label", TEXT, since=1))
    ),
    "CObservationOdometry": Class(
        (0, 1, 2),
        (
            Field("odometry", CHILD),
            Field("label", TEXT),
            Field("time", TIME),
            Field("has_encoders", FLAG, since=1),
            Field("encoders", Block("<i4", 2), since=1, until=1),
            Field("encoders", Block("<i4", 2), since=2, when=_set("has_encoders")),
            Field("has_velocity", FLAG, since=1),
            Field("velocity", Block("<f4", 2), since=1, until=1),
            Field("velocity", Block("<f8", 3), since=2, when=_set("has_velocity")),
        ),
    ),
    "CObservationRobotPose": Class(
        (0, 1),
        (
            Field("pose", CHILD),
            Field("label", TEXT),
            Field("time", TIME),
            Field("sensor_pose", CHILD, since=1),
        ),
    ),
    "CObservation2DRangeScan": Class(
        tuple(range(9)),
        (
            Field("aperture", F32),
            Field("right_to_left", FLAG),
            Field("max_range", F32),
            Field("sensor_pose", CHILD),
            Field("pose_covariance", CHILD, until=5),
            Field("count", U32),
            Field("ranges", Block("<f4", "count")),
            Field("valid", Block("u1", "count"), since=1),
            Field("std_error", F32, since=2),
            Field("time", TIME, since=3),
            Field("beam_aperture", F32, since=4),
            Field("label", TEXT, since=5),
            Field("delta_pitch", F64, since=5),
            Field("has_intensity", FLAG, since=7),
            Field("intensity", Block("<i4", "count"), since=7, when=_set("has_intensity")),
            Field("sweep_duration", F32, since=8),
        ),
    ),
    "CSensoryFrame": Class(
        (0, 1, 2), (Field("id", U32, until=1), Field("time", TIME, until=0), Field("objects", CHILDREN))
    ),
    "CActionCollection": Class((0,), (Field("objects", CHILDREN),)),
    "CActionRobotMovement2D": _MOVEMENT_2D,
    "CActionRobotMovement3D": Class(
        (1,),
        (
            Field("method", U32),
            Field("pdf", CHILD),
            Field("has_velocities", BYTES),
            Field("velocities", Vector("<f4")),
            Field("time", TIME),
        ),
    ),
    "CRawlog": Class((0, 1), (Field("objects", CHILDREN), Field("comment", CHILD))),
}

CODEC: Final = Codec(CLASSES)
