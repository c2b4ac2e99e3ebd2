# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Camera intrinsics and the benchmark's calibrations (its file formats page; the paper's Table II)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

Matrix3x3 = tuple[float, ...]
MAX_SIDE: Final = 65_535
"""Rows or columns of an image; no camera has more."""


@dataclass(frozen=True, slots=True, eq=False)
class CameraInfo:
    """Intrinsics as in ROS `sensor_msgs/CameraInfo`: pinhole and distortion.

    Two are equal if all their numbers are; recordings have NaN in them, which equals another NaN here.

    Attributes:
        width: Columns.
        height: Rows.
        k: Intrinsic matrix, nine numbers by row: fx 0 cx, 0 fy cy, 0 0 1 (pixels).
        d: Distortion; for `plumb_bob` k1 k2 p1 p2 k3.
        r: Rectification, nine numbers by row.
        p: Projection, twelve numbers by row.
        distortion_model: ROS name of the model.

    """

    width: int
    height: int
    k: tuple[float, ...]
    d: tuple[float, ...]
    r: tuple[float, ...]
    p: tuple[float, ...]
    distortion_model: str = "plumb_bob"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, CameraInfo) and self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())

    def _key(self) -> tuple[object, ...]:
        numbers = (*self.k, *self.r, *self.p, *self.d)
        known = tuple(None if math.isnan(number) else number for number in numbers)
        return self.width, self.height, self.distortion_model, len(self.k), len(self.r), len(self.p), known

    @property
    def is_plausible(self) -> bool:
        """Whether this can be a camera: numbers throughout, focal lengths, and a size that images have."""
        numbers = (*self.k, *self.r, *self.p, *self.d)
        sizes = range(1, MAX_SIDE + 1)
        focal_lengths = self.k[0], self.k[4]  # 0 is said of a camera that is not calibrated
        return (
            all(map(math.isfinite, numbers))
            and min(focal_lengths) >= 0
            and self.width in sizes
            and self.height in sizes
        )

    @classmethod
    def pinhole(
        cls,
        fx: float,
        fy: float,
        cx: float,
        cy: float,
        d: tuple[float, ...] = (0.0,) * 5,
        width: int = 640,
        height: int = 480,
    ) -> CameraInfo:
        """Build from focal lengths and principal point (pixels): R identity, P from K."""
        return cls(
            width=width,
            height=height,
            k=(fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0),
            d=d,
            r=(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
            p=(fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0),
        )

    def scaled_to(self, width: int, height: int) -> CameraInfo:
        """Return the intrinsics for the same view at another resolution (pixel centres at +0.5)."""
        if (width, height) == (self.width, self.height):
            return self
        sx, sy = width / self.width, height / self.height
        fx, cx, fy, cy = self.k[0], self.k[2], self.k[4], self.k[5]
        return CameraInfo.pinhole(
            fx * sx, fy * sy, (cx + 0.5) * sx - 0.5, (cy + 0.5) * sy - 0.5, self.d, width, height
        )


ROS_DEFAULT: Final = "ros-default"
"""OpenNI's factory numbers; what the benchmark advises for its registered depth."""

CALIBRATIONS: Final[dict[tuple[str, str], CameraInfo]] = {
    (ROS_DEFAULT, "rgb"): CameraInfo.pinhole(525.0, 525.0, 319.5, 239.5),
    (ROS_DEFAULT, "ir"): CameraInfo.pinhole(525.0, 525.0, 319.5, 239.5),
    ("fr1", "rgb"): CameraInfo.pinhole(
        517.3, 516.5, 318.6, 255.3, (0.2624, -0.9531, -0.0054, 0.0026, 1.1633)
    ),
    ("fr2", "rgb"): CameraInfo.pinhole(
        520.9, 521.0, 325.1, 249.7, (0.2312, -0.7849, -0.0033, -0.0001, 0.9172)
    ),
    ("fr3", "rgb"): CameraInfo.pinhole(535.4, 539.2, 320.1, 247.6),
    ("fr1", "ir"): CameraInfo.pinhole(591.1, 590.1, 331.0, 234.0, (-0.0410, 0.3286, 0.0087, 0.0051, -0.5643)),
    ("fr2", "ir"): CameraInfo.pinhole(
        580.8, 581.8, 308.8, 253.0, (-0.2297, 1.4766, 0.0005, -0.0075, -3.4194)
    ),
    ("fr3", "ir"): CameraInfo.pinhole(567.6, 570.2, 324.7, 250.1),
}
"""Calibrations by camera and sensor, at 640x480."""

CAMERAS: Final = ("fr1", "fr2", "fr3", ROS_DEFAULT)


def calibration(camera: str, stream: str, width: int = 640, height: int = 480) -> CameraInfo:
    """Return the calibration for a stream.

    Depth is registered to colour, so both share the colour camera's intrinsics.

    Args:
        camera: One of `CAMERAS`.
        stream: `rgb`, `depth` or `ir`.
        width: Columns of the images.
        height: Rows of the images.

    Raises:
        KeyError: The camera is unknown.

    """
    return CALIBRATIONS[camera, "ir" if stream == "ir" else "rgb"].scaled_to(width, height)


def camera_of_name(name: str | None) -> str | None:
    """Tell the camera from a benchmark name: `rgbd_dataset_freiburg1_xyz` and `fr1/xyz` are fr1."""
    text = (name or "").lower()
    for number in "123":
        if f"freiburg{number}_" in text or text.startswith((f"fr{number}/", f"fr{number}_")):
            return f"fr{number}"
    return None
