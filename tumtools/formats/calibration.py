# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Read a calibration from a file: the YAML of ROS's camera_calibration, or the settings of ORB-SLAM.

Source: ROS `camera_calibration_parsers` (YAML); ORB-SLAM2 and 3, `Examples/RGB-D/TUM1.yaml`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import yaml

from tumtools.errors import InputError, MissingInputError
from tumtools.formats import safe_yaml
from tumtools.model.camera import CameraInfo

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

_MAX_BYTES: Final = 1 << 20
_ORB_PREFIXES: Final = ("Camera.", "Camera1.")
_ORB_DISTORTION: Final = ("k1", "k2", "p1", "p2", "k3")


def read_calibration(path: Path) -> CameraInfo:
    """Read the intrinsics of a camera.

    Raises:
        InputError: The file is missing, no YAML, or holds no calibration.

    """
    try:
        text = path.read_bytes()[: _MAX_BYTES + 1].decode("utf-8")
    except FileNotFoundError:
        raise MissingInputError("there is no such calibration", path=path) from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"cannot be read as a calibration: {error}", path=path) from error
    if len(text) > _MAX_BYTES:
        raise InputError("too large for a calibration", path=path)
    try:
        # OpenCV writes a first line that is no YAML of any version since 1.0.
        values = safe_yaml.load(text.removeprefix("%YAML:1.0"))
    except yaml.YAMLError as error:
        raise InputError(f"not YAML: {error}", path=path) from error
    try:
        if isinstance(values, dict):
            if "camera_matrix" in values:
                return _from_ros(values)
            for prefix in _ORB_PREFIXES:
                if f"{prefix}fx" in values:
                    return _from_orb_slam(values, prefix)
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"an incomplete calibration: {type(error).__name__}: {error}", path=path) from error
    raise InputError(
        "no calibration in this file: neither camera_matrix (ROS) nor Camera.fx (ORB-SLAM)", path=path
    )


def _from_ros(values: Mapping[str, object]) -> CameraInfo:
    k = _matrix(values, "camera_matrix", 9)
    identity = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    p = (k[0], k[1], k[2], 0.0, k[3], k[4], k[5], 0.0, k[6], k[7], k[8], 0.0)
    return CameraInfo(
        width=int(str(values["image_width"])),
        height=int(str(values["image_height"])),
        k=k,
        d=_matrix(values, "distortion_coefficients"),
        r=_matrix(values, "rectification_matrix", 9) if "rectification_matrix" in values else identity,
        p=_matrix(values, "projection_matrix", 12) if "projection_matrix" in values else p,
        distortion_model=str(values.get("distortion_model", "plumb_bob")),
    )


def _matrix(values: Mapping[str, object], name: str, count: int | None = None) -> tuple[float, ...]:
    matrix = values[name]
    numbers = tuple(float(number) for number in matrix["data"]) if isinstance(matrix, dict) else ()
    if count is not None and len(numbers) != count:
        raise ValueError(f"{name} has {len(numbers)} numbers instead of {count}")
    return numbers


def _from_orb_slam(values: Mapping[str, object], prefix: str) -> CameraInfo:
    def number(name: str, default: float | None = None) -> float:
        value = values.get(prefix + name, values.get(f"Camera.{name}", default))
        if value is None:
            raise KeyError(prefix + name)
        return float(str(value))

    return CameraInfo.pinhole(
        number("fx"),
        number("fy"),
        number("cx"),
        number("cy"),
        tuple(number(name, 0.0) for name in _ORB_DISTORTION),
        int(number("width", 640)),
        int(number("height", 480)),
    )
