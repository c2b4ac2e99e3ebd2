# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The objects that are written, in each dialect: class versions, spelling of names, constants."""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.formats.rawlog import intrinsics
from tumtools.formats.rawlog.archive import Record, text_bytes
from tumtools.formats.rawlog.classes import CODEC
from tumtools.formats.rawlog.runs import places

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy.typing as npt

    from tumtools.formats.rawlog.archive import Fields, Value
    from tumtools.model.camera import CameraInfo

SCAN_LABEL: Final = "KINECT"
IMU_LABEL: Final = "KINECT_ACC"
VISIBLE, INFRARED = 0, 1

_NAMESPACES: Final = {
    "CPose3D": "mrpt::poses::CPose3D",
    "CMatrixD": "mrpt::math::CMatrixD",
    "TCamera": "mrpt::img::TCamera",
    "CImage": "mrpt::img::CImage",
    "CObservation3DRangeScan": "mrpt::obs::CObservation3DRangeScan",
    "CObservationIMU": "mrpt::obs::CObservationIMU",
    "CObservationComment": "mrpt::obs::CObservationComment",
}


@dataclass(frozen=True, slots=True)
class Dialect:
    """How rawlogs of a time look.

    Attributes:
        name: As on the command line.
        versions: Version of each class.
        spelling: Class name -> as it is written.
        float_depth: Depth files are float32 matrices of metres, not 16-bit counts.
        lossless: Own stamps, header lines and decimals are kept, in file names and in a comment.

    """

    name: str
    versions: Mapping[str, int]
    spelling: Mapping[str, str]
    float_depth: bool = False
    lossless: bool = True

    def record(self, name: str, /, **fields: Value) -> Record:
        """Build an object of a class in its version here."""
        return Record(self.spelling.get(name, name), self.versions[name], fields)


_MODERN_VERSIONS: Final = {
    "CPose3D": 3,
    "TCamera": 6,
    "CImage": 9,
    "CMatrixD": 0,
    "CObservation3DRangeScan": 10,
    "CObservationIMU": 4,
    "CObservationComment": 0,
}
_LEGACY_VERSIONS: Final = {
    "CPose3D": 2,
    "TCamera": 2,
    "CImage": 7,
    "CMatrixF": 0,
    "CMatrixD": 0,
    "CObservation3DRangeScan": 6,
    "CObservationIMU": 2,
    "CObservationComment": 0,
}

DIALECTS: Final[dict[str, Dialect]] = {
    dialect.name: dialect
    for dialect in (
        Dialect("modern", _MODERN_VERSIONS, _NAMESPACES),
        Dialect(
            "legacy",
            _LEGACY_VERSIONS,
            {"CMatrixF": "CMatrix"},  # the name that MRPT had for it then
            float_depth=True,
        ),
        Dialect("converter", _MODERN_VERSIONS, _NAMESPACES, lossless=False),
    )
}

_IDENTITY: Final = {3: (0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1), 2: (0, 0, 0, 1, 0, 0, 0)}
# From the axes of the depth sensor (X forward) to those of an optical frame (Z forward): yaw and roll of
# -90 degrees, with the residues that MRPT's sines and cosines leave.
_SIN, _TINY = 6.123233995736766e-17, 3.749399456654644e-33
_TO_OPTICAL: Final = {
    3: (0, 0, 0, _SIN, _SIN, 1, -1, _TINY, _SIN, -0.0, -1, _SIN),
    2: (0, 0, 0, 0.5, -0.5, 0.5, -0.5),
}
_NO_COUNTS: Final = np.empty(0, np.dtype("<u2"))
_NO_METRES: Final = np.empty(0, np.dtype("<f4"))
_CAMERA_NAME: Final = "camera1"
IMU_VALUES: Final = {4: 31, 2: 15}
"""Numbers of an IMU object, by version."""
_ACCELERATIONS: Final = 3


def _pose(dialect: Dialect, values: Mapping[int, tuple[float, ...]]) -> Record:
    return dialect.record("CPose3D", values=np.array(values[dialect.versions["CPose3D"]], "<f8"))


def camera_record(dialect: Dialect, camera: CameraInfo) -> Record:
    """Return the intrinsics of a camera; what the class has no place for stays in the comment.

    MRPT's own converter exchanged rows and columns before 2.4. No dialect follows it there: MRPT undoes it
    since, but only for depth and only at 640x480, and before it took the size as it stands, or the image's.
    """
    version = dialect.versions["TCamera"]
    distortion, model = intrinsics.distortion_of(camera, version)
    fx, cx, fy, cy = camera.k[0], camera.k[2], camera.k[4], camera.k[5]
    matrix = dialect.record("CMatrixD", rows=3, columns=3, values=np.array(camera.k, "<f8"))
    return dialect.record(
        "TCamera",
        focal_length_metres=0.0,
        distortion=distortion,
        intrinsics=matrix,
        fx_fy_cx_cy=np.array([fx, fy, cx, cy], "<f8"),
        rows=camera.height,
        columns=camera.width,
        name=_CAMERA_NAME,
        model=model,
    )


@dataclass(frozen=True, slots=True)
class ScanKind:
    """What a scan has in common with others.

    Attributes:
        has_image: Whether there is a file of colour or infrared.
        has_depth: Whether there is a depth file.
        range_units: Metres per count of the depth file.
        channel: `VISIBLE` or `INFRARED`.
        depth_camera: An encoded `camera_record`.
        image_camera: Another one.

    """

    has_image: bool
    has_depth: bool
    range_units: float
    channel: int
    depth_camera: bytes
    image_camera: bytes


_TICKS: Final = struct.Struct("<Q")
_TICKS_MARK: Final = 0xF1F2F3F4F5F6F7F8
_IMAGE_MARK, _DEPTH_MARK = "<name of the image file>", "<name of the depth file>"
"""What stands in a template for what each scan has of its own."""


class Scans:
    """Scans whose images are external files, as objects; those of a kind share a template."""

    def __init__(self, dialect: Dialect) -> None:
        self._dialect = dialect
        self._templates: dict[ScanKind, list[bytes]] = {}
        self._shared: Fields = {
            "max_range": 5.0,
            "sensor_pose": CODEC.encode(_pose(dialect, _IDENTITY)),
            "has_points": 0,
            "rows": 0,
            "columns": 0,
            "range": _NO_COUNTS,
            "has_confidence": 0,
            "intensity_pose": CODEC.encode(_pose(dialect, _TO_OPTICAL)),
            "std_error": 0.01,
            "label": SCAN_LABEL,
            "points_external": 0,
            "points_file": "",
            "range_is_depth": 1,
            "has_labels": 0,
            "layers": [],
        }
        if dialect.float_depth:
            no_metres = dialect.record("CMatrixF", rows=0, columns=0, values=_NO_METRES)
            self._shared["range_matrix"] = CODEC.encode(no_metres)

    def encode(self, kind: ScanKind, ticks: int, image_file: str = "", depth_file: str = "") -> bytes:
        """Return a scan as it is written.

        Args:
            kind: What it has in common with others.
            ticks: Time, in units of 100 ns since 1601.
            image_file: Name of the colour or infrared file; empty if there is none.
            depth_file: Name of the depth file; empty if there is none.

        """
        template = self._templates.get(kind)
        if template is None:
            template = self._templates[kind] = self._template(kind)
        own = dict(zip(_MARKS, _own_bytes(ticks, image_file, depth_file), strict=True))
        return b"".join([own.get(part, part) for part in template])

    def _template(self, kind: ScanKind) -> list[bytes]:
        """Return the bytes of a kind, marks and what is between them by turns."""
        image = self._dialect.record("CImage", external=1, file=_IMAGE_MARK if kind.has_image else "")
        record = self._dialect.record(
            "CObservation3DRangeScan",
            **self._shared,
            has_range=int(kind.has_depth),
            range_units=kind.range_units,
            has_intensity=int(kind.has_image),
            intensity=image,
            camera=kind.depth_camera,
            camera_intensity=kind.image_camera,
            time=_TICKS_MARK,
            range_external=int(kind.has_depth),
            range_file=_DEPTH_MARK if kind.has_depth else "",
            channel=kind.channel,
        )
        return re.split(b"(" + b"|".join(map(re.escape, _MARKS)) + b")", CODEC.encode(record))


def _own_bytes(ticks: int, image_file: str, depth_file: str) -> tuple[bytes, bytes, bytes]:
    return _TICKS.pack(ticks), text_bytes(image_file), text_bytes(depth_file)


_MARKS: Final = _own_bytes(_TICKS_MARK, _IMAGE_MARK, _DEPTH_MARK)


def comment_bytes(dialect: Dialect, text: str, ticks: int) -> bytes:
    """Return a comment object as it is written."""
    return CODEC.encode(dialect.record("CObservationComment", text=text, time=ticks, label=""))


class ImuRows:
    """Accelerometer rows as objects: one template, stamped with all times and values at once."""

    def __init__(self, dialect: Dialect) -> None:
        version = dialect.versions["CObservationIMU"]
        count = IMU_VALUES[version]
        present = np.zeros(count, np.uint8)
        present[:_ACCELERATIONS] = 1
        record = dialect.record(
            "CObservationIMU",
            sensor_pose=_pose(dialect, _IDENTITY),
            present=present,
            time=0,
            values=np.zeros(count, "<f8"),
            label=IMU_LABEL,
        )
        self._template = np.frombuffer(CODEC.encode(record), np.uint8)
        time, values = places(version, IMU_LABEL, 8 * count)
        self._time, self._values = len(self._template) + time, len(self._template) + values

    def encode(self, ticks: npt.NDArray[np.int64], values: npt.NDArray[np.float64]) -> bytes:
        """Return the objects of some rows, one after another.

        Args:
            ticks: Shape [n].
            values: m/s2, shape [n, 3].

        """
        rows = np.tile(self._template, (len(ticks), 1))
        rows[:, self._time : self._time + 8] = ticks.astype("<u8").view(np.uint8).reshape(-1, 8)
        stored = np.ascontiguousarray(values, "<f8").view(np.uint8).reshape(-1, 8 * _ACCELERATIONS)
        rows[:, self._values : self._values + 8 * _ACCELERATIONS] = stored
        return rows.tobytes()
