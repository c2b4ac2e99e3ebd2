# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What observations say besides images: inertial values, intrinsics, and what the model has no place for."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.formats.rawlog.intrinsics import camera_of
from tumtools.formats.rawlog.pictures import empty

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy.typing as npt

    from tumtools.formats.rawlog.archive import Fields, Record
    from tumtools.model.camera import CameraInfo

IMU_CHANNELS: Final = 31
"""0-2 acceleration X Y Z (m/s2); 3 yaw, 4 pitch, 5 roll rate (rad/s); 6-8 velocity; 9-11 yaw pitch roll;
12-14 position; 15-17 magnetic field; 18 pressure; 19 altitude; 20 temperature; 21-24 orientation x y z w;
25-27 rates and 28-30 acceleration in the global frame."""
_YAW_RATE, _ROLL_RATE = 3, 5
_SWAPPED_UNTIL: Final = 1
"""Versions up to this have yaw and roll rate the other way round."""
_SWAPPED_SIZE_UNTIL: Final = 8
_WITH_STREAMS: Final = frozenset({"CObservation3DRangeScan", "CObservationImage", "CObservationIMU"})


@dataclass(frozen=True, slots=True, eq=False)
class Imu:
    """A `CObservationIMU`.

    Attributes:
        present: Which channels hold a value, bool, shape [31].
        values: As listed at `IMU_CHANNELS`, float64, shape [31]; 0 where absent.

    """

    present: npt.NDArray[np.bool_]
    values: npt.NDArray[np.float64]

    @property
    def has_acceleration(self) -> bool:
        """Whether all three accelerations are there."""
        return bool(self.present[:3].all())

    @property
    def has_more(self) -> bool:
        """Whether anything else is there."""
        return bool(self.present[3:].any())


def imu_of(record: Record) -> Imu:
    """Return the values of a `CObservationIMU`, in today's order."""
    present = np.zeros(IMU_CHANNELS, bool)
    values = np.zeros(IMU_CHANNELS)
    for target, name in ((present, "present"), (values, "values")):
        source = record.array(name)[:IMU_CHANNELS]
        target[: len(source)] = source
        if record.version <= _SWAPPED_UNTIL:
            target[[_YAW_RATE, _ROLL_RATE]] = target[[_ROLL_RATE, _YAW_RATE]]
    return Imu(present, values)


class Cameras:
    """Makes intrinsics of observations; those that are like the ones before are the same object again."""

    def __init__(self) -> None:
        self._latest: dict[str, tuple[Fields, bool, CameraInfo | None]] = {}

    def of(self, record: Record) -> Iterator[tuple[str, CameraInfo]]:
        """Yield the intrinsics that an observation carries, by image stream."""
        if record.type == "CObservation3DRangeScan":
            swapped = record.version <= _SWAPPED_SIZE_UNTIL and _is_external(record)
            names = (("depth", "camera"), ("ir" if record.integer("channel") else "rgb", "camera_intensity"))
            for stream, name in names:
                present = record.integer("has_range" if stream == "depth" else "has_intensity")
                if present and (camera := self._camera(record, name, swapped=swapped)):
                    yield stream, camera
        elif record.type == "CObservationImage" and (camera := self._camera(record, "camera")):
            yield "rgb", camera

    def _camera(self, record: Record, name: str, *, swapped: bool = False) -> CameraInfo | None:
        child = record.child(name)
        if child is None:
            return None
        fields, was_swapped, camera = self._latest.get(name, (None, swapped, None))
        # What is written like the one before is read as the same object.
        if fields is not child.fields or was_swapped != swapped:
            found = camera_of(child, swapped)
            camera = camera if found == camera else found
            self._latest[name] = child.fields, swapped, camera
        return camera


def _is_external(scan: Record) -> bool:
    """Tell whether the images of a scan are external: that of depth, or where there is none, the other."""
    if scan.integer("has_range"):
        return bool(scan.integer("range_external"))
    image = scan.child("intensity")
    return image is not None and bool(image.integer("external"))


def _moves(pose: Record | None) -> bool:
    """Tell whether a pose shifts or turns anything."""
    values = pose.array("values") if pose is not None else None
    return values is not None and values.dtype == np.float64 and _moves_by(values.tobytes())


@lru_cache(maxsize=64)
def _moves_by(values: bytes) -> bool:
    """Tell it of the numbers of a pose: x y z, then a quaternion, scalar first, or a matrix by row."""
    position, rotation = np.split(np.frombuffer(values, "<f8"), [3])
    still = (1, 0, 0, 0) if len(rotation) == 4 else (1, 0, 0, 0, 1, 0, 0, 0, 1)  # noqa: PLR2004 - w x y z
    return bool(position.any()) or len(rotation) != len(still) or not np.allclose(rotation, still)


def not_carried(record: Record, imu: Imu | None = None) -> Iterator[str]:
    """Name what an observation holds and the model has no place for.

    Args:
        record: The observation.
        imu: Its values, if it is a `CObservationIMU`.

    """
    if record.type in _WITH_STREAMS and _moves(record.child("sensor_pose")):
        yield "pose of the sensor on the robot"
    yield from empty(record)
    if record.type == "CObservation3DRangeScan":
        yield from _beside_the_images(record)
    elif imu is not None:
        if not imu.has_acceleration:
            yield "inertial values without acceleration"
        elif imu.has_more:
            yield "inertial values besides acceleration"
    elif record.type not in {"CObservationImage", "CObservationComment"}:
        yield record.type


def _beside_the_images(scan: Record) -> Iterator[str]:
    if scan.integer("point_count") or (scan.integer("has_points", 1) and scan.integer("points_external")):
        yield "point cloud"
    if scan.integer("has_confidence"):
        yield "confidence image"
    if scan.integer("has_labels"):
        yield "pixel labels"
    if scan.fields.get("layers"):
        yield "extra range layers"
    relative = scan.child("intensity_pose")
    if relative is not None and relative.array("values")[:3].any():
        yield "position of the colour camera in the depth camera"
