# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The messages that tumtools writes: definitions for ROS 1 and ROS 2, md5 sums, type hashes.

Source: common_interfaces, geometry2 and rcl_interfaces of ROS 2 Humble; common_msgs of ROS 1 Noetic.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Final

from tumtools.formats.ros.codec import MessageType
from tumtools.formats.ros.definitions import gather, md5_sum

if TYPE_CHECKING:
    from tumtools.formats.ros.recording import MessageEncoding

IMAGE: Final = "sensor_msgs/msg/Image"
COMPRESSED_IMAGE: Final = "sensor_msgs/msg/CompressedImage"
CAMERA_INFO: Final = "sensor_msgs/msg/CameraInfo"
IMU: Final = "sensor_msgs/msg/Imu"
POSE_STAMPED: Final = "geometry_msgs/msg/PoseStamped"
TF_MESSAGE: Final = "tf2_msgs/msg/TFMessage"
OLD_TF_MESSAGE: Final = "tf/msg/tfMessage"
STRING: Final = "std_msgs/msg/String"

_SHARED: Final = {
    "geometry_msgs/msg/Point": "float64 x\nfloat64 y\nfloat64 z\n",
    "geometry_msgs/msg/Vector3": "float64 x\nfloat64 y\nfloat64 z\n",
    "geometry_msgs/msg/Quaternion": "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n",
    "geometry_msgs/msg/Pose": "Point position\nQuaternion orientation\n",
    "geometry_msgs/msg/Transform": "Vector3 translation\nQuaternion rotation\n",
    "sensor_msgs/msg/RegionOfInterest": (
        "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n"
    ),
    POSE_STAMPED: "std_msgs/Header header\nPose pose\n",
    "geometry_msgs/msg/TransformStamped": (
        "std_msgs/Header header\nstring child_frame_id\nTransform transform\n"
    ),
    TF_MESSAGE: "geometry_msgs/TransformStamped[] transforms\n",
    STRING: "string data\n",
    IMAGE: (
        "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\n"
        "uint8 is_bigendian\nuint32 step\nuint8[] data\n"
    ),
    COMPRESSED_IMAGE: "std_msgs/Header header\nstring format\nuint8[] data\n",
    IMU: (
        "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n"
        "geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n"
        "geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n"
    ),
}

ROS2_DEFINITIONS: Final = _SHARED | {
    "builtin_interfaces/msg/Time": "int32 sec\nuint32 nanosec\n",
    "std_msgs/msg/Header": "builtin_interfaces/Time stamp\nstring frame_id\n",
    "geometry_msgs/msg/Quaternion": "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n",
    CAMERA_INFO: (
        "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\n"
        "float64[] d\nfloat64[9] k\nfloat64[9] r\nfloat64[12] p\n"
        "uint32 binning_x\nuint32 binning_y\nRegionOfInterest roi\n"
    ),
}
ROS1_DEFINITIONS: Final = _SHARED | {
    "std_msgs/msg/Header": "uint32 seq\ntime stamp\nstring frame_id\n",
    CAMERA_INFO: (
        "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\n"
        "float64[] D\nfloat64[9] K\nfloat64[9] R\nfloat64[12] P\n"
        "uint32 binning_x\nuint32 binning_y\nRegionOfInterest roi\n"
    ),
    OLD_TF_MESSAGE: "geometry_msgs/TransformStamped[] transforms\n",
}

TYPE_HASHES: Final = {
    IMAGE: "RIHS01_d31d41a9a4c4bc8eae9be757b0beed306564f7526c88ea6a4588fb9582527d47",
    COMPRESSED_IMAGE: "RIHS01_15640771531571185e2efc8a100baf923961a4d15d5569652e6cb6691e8e371a",
    CAMERA_INFO: "RIHS01_b3dfd68ff46c9d56c80fd3bd4ed22c7a4ddce8c8348f2f59c299e73118e7e275",
    IMU: "RIHS01_7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b",
    POSE_STAMPED: "RIHS01_10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8",
    TF_MESSAGE: "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
    STRING: "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18",
}
"""Type hashes (REP 2016), as rosbag2 keeps them from version 7 of its metadata on."""


def ros1_name(name: str) -> str:
    """Return the spelling of ROS 1: `sensor_msgs/Image`."""
    package, _, kind = name.split("/")
    return f"{package}/{kind}"


@cache
def definition(name: str, encoding: MessageEncoding) -> str:
    """Return the text of a message with its dependencies."""
    return gather(name, ROS1_DEFINITIONS if encoding == "ros1" else ROS2_DEFINITIONS)


@cache
def ros1_md5_sum(name: str) -> str:
    """Return the md5 sum that a ROS 1 bag must carry."""
    return md5_sum(name, ROS1_DEFINITIONS)


@cache
def message_type(name: str, encoding: MessageEncoding) -> MessageType:
    """Return the codec of one of our own messages."""
    return MessageType(definition(name, encoding), name, encoding)
