# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Fields of messages that a sequence has no place for are losses, if they say something."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from tests.formats.mcap.foreign import ONE, ZERO, Foreign
from tests.formats.ros.published import MS, START, T, header, write_messages
from tests.memory import Memory, accelerometer, groundtruth
from tumtools.convert import ConvertOptions, convert
from tumtools.diff import diff
from tumtools.errors import LossRefusedError
from tumtools.formats.mcap.recording import McapRecording
from tumtools.formats.options import ReadOptions, WriteOptions
from tumtools.formats.registry import FORMATS
from tumtools.formats.ros import messages
from tumtools.formats.ros.besides import Lateness, has_window, lateness
from tumtools.model.signals import Trajectory
from tumtools.sources import open_source
from tumtools.transform import Selection

if TYPE_CHECKING:
    from pathlib import Path

    from tumtools.formats.ros.recording import MessageEncoding

NAN = float("nan")
AT_REST = {"position": ZERO, "orientation": ONE}
NONE = (0.0,) * 9
UNKNOWN = (-1.0, *NONE[1:])
TURNED = (0.0, 0.0, 1.0, 0.0)
SOME = (0.1, *NONE[1:])
INERTIAL, COVARIANCES = "inertial values besides acceleration", "covariances"


def losses(path: Path, **topics: str) -> dict[tuple[str, str], int]:
    with open_source(path, ReadOptions(topics=topics)) as sequence:
        assert all(loss.why for loss in sequence.info.not_carried)
        return {(loss.stream, loss.what): loss.count for loss in sequence.info.not_carried}


def imu(
    orientation: tuple[float, ...] = (0.0, 0.0, 0.0, 1.0),
    rates: tuple[float, ...] = (0.0, 0.0, 0.0),
    covariances: tuple[tuple[float, ...], ...] = (NONE, NONE, NONE),
) -> dict[str, object]:
    turned = dict(zip("xyzw", orientation, strict=True))
    turning = dict(zip("xyz", rates, strict=True))
    names = ("orientation", "angular_velocity", "linear_acceleration")
    values = zip(names, (turned, turning, ZERO), covariances, strict=True)
    return {
        k: v for name, value, cov in values for k, v in ((name, value), (f"{name}_covariance", list(cov)))
    }


@pytest.mark.parametrize("encoding", ["cdr", "ros1"])
@pytest.mark.parametrize(
    ("fields", "told"),
    [
        (imu(), None),
        (imu((0.0,) * 4), None),
        (imu((NAN,) * 4, (NAN,) * 3), None),
        (imu(TURNED, (1.0, 2.0, 3.0), (UNKNOWN, UNKNOWN, UNKNOWN)), None),
        (imu(covariances=((NAN,) * 9, NONE, NONE)), None),
        (imu(TURNED), INERTIAL),
        (imu((0.0, 0.0, 0.0, -1.0)), INERTIAL),
        (imu(rates=(0.0, 0.0, 1e-9)), INERTIAL),
        (imu(rates=(NAN, 0.0, 1.0)), INERTIAL),
        (imu(TURNED, (1.0, 0.0, 0.0), (UNKNOWN, NONE, NONE)), INERTIAL),
        (imu(covariances=(SOME, UNKNOWN, NONE)), COVARIANCES),
        (imu(covariances=(UNKNOWN, SOME, NONE)), COVARIANCES),
        (imu(covariances=(UNKNOWN, UNKNOWN, SOME)), COVARIANCES),
    ],
)
def test_what_an_imu_says_beside_accelerations_is_told_with_the_number_of_messages(
    fields: dict[str, object], told: str | None, encoding: MessageEncoding, tmp_path: Path
) -> None:
    path = tmp_path / "x.mcap"
    with Foreign(path, encoding) as file:
        for number in range(5):
            file.write("/imu", messages.IMU, START + number, **(fields if number in {1, 4} else imu()))
    assert losses(path) == ({} if told is None else {("/imu", told): 2})
    with open_source(path) as sequence:
        if told:
            with pytest.raises(LossRefusedError):
                convert(sequence, tmp_path / "y", "tum", options=ConvertOptions(strict=True))
        convert(sequence, tmp_path / "y", "tum")


def test_frame_ids_of_signals_are_kept_and_those_of_single_messages_told(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    with Foreign(path) as file:
        for number in range(5):
            file.write("/imu", messages.IMU, START + number, frame_id=f"imu{number // 4}", **imu())
            file.write(
                "/pose", messages.POSE_STAMPED, START + number, frame_id=f"map{number % 2}",
                pose={"position": ZERO, "orientation": ONE},
            )  # fmt: skip
    what = "frame ids of single messages"
    assert losses(path) == {("accelerometer", what): 1, ("groundtruth", what): 2}
    with open_source(path) as sequence:
        assert sequence.info.frame_ids == {"accelerometer": "imu0", "groundtruth": "map0"}
        convert(sequence, tmp_path / "y.mcap", "mcap")
    with open_source(tmp_path / "y.mcap") as again:
        assert again.info.frame_ids == {"accelerometer": "imu0", "groundtruth": "map0"}


@pytest.mark.parametrize("encoding", ["cdr", "ros1"])
def test_times_of_recording_are_told_where_they_are_not_the_stamps(
    encoding: MessageEncoding, tmp_path: Path
) -> None:
    path = tmp_path / "x.mcap"
    with Foreign(path, encoding) as file:
        for number in range(5):
            stamp, late = START + number * MS, (0, 0, 7, -30, 20)[number]
            file.image("/rgb", stamp, number, late=late)
            file.write("/imu", messages.IMU, stamp, late=-late, **imu())
            file.write("/pose", messages.POSE_STAMPED, stamp, pose=AT_REST)
            still = {"translation": ZERO, "rotation": ONE}
            moved = {"translation": ZERO | {"x": float(number)}, "rotation": ONE}
            for topic, transforms in {"/tf": {"xy": still, "ab": moved}, "/tf_static": {"bc": still}}.items():
                named = [
                    {"header": file.header(stamp, edge[0]), "child_frame_id": edge[1], "transform": one}
                    for edge, one in transforms.items()
                    if number  # a message may have none
                ]
                file.write(topic, messages.TF_MESSAGE, stamp, late=abs(late), transforms=named)
    with open_source(path, ReadOptions(topics={"groundtruth": "/pose"})) as sequence:
        found = [loss for loss in sequence.info.not_carried if loss.what == "times of recording"]
    assert [(loss.stream, loss.count, loss.largest_error, loss.unit) for loss in found] == [
        ("rgb", 3, 30e-9, "s"),
        ("accelerometer", 3, 30e-9, "s"),
    ]
    with open_source(path, ReadOptions(topics={"groundtruth": "/tf:a.b"})) as sequence:
        found = [loss for loss in sequence.info.not_carried if loss.what == "times of recording"]
    assert [(loss.stream, loss.count) for loss in found] == [
        ("rgb", 3),
        ("accelerometer", 3),
        ("groundtruth", 3),
    ]


def test_what_is_lost_of_streams_that_are_not_asked_for_is_no_loss(tmp_path: Path) -> None:
    with Foreign(tmp_path / "x.mcap") as file:
        for number in range(3):
            file.image("/rgb", START + number * MS, number, late=7)
            file.write("/imu", messages.IMU, START + number, late=5, **imu(TURNED))
            file.pose(START + number, 0.0)
    with open_source(tmp_path / "x.mcap") as sequence:
        found = {}
        for streams in (("groundtruth",), ("rgb", "groundtruth"), ("accelerometer",), None):
            options = ConvertOptions(Selection(streams=streams), dry_run=True)
            report = convert(sequence, tmp_path / "y.mcap", "mcap", options=options)
            found[streams] = {(loss.stream, loss.what) for loss in report.losses}
    late, more = (
        {("rgb", "times of recording")},
        {("accelerometer", "times of recording"), ("/imu", INERTIAL)},
    )
    assert found == {
        ("groundtruth",): set(),
        ("rgb", "groundtruth"): late,
        ("accelerometer",): more,
        None: late | more,
    }


def test_what_is_lost_of_ground_truth_that_is_not_written_is_no_loss(tmp_path: Path) -> None:
    with Foreign(tmp_path / "x.mcap") as file:
        for number in range(3):
            file.write("/pose", messages.POSE_STAMPED, START + number, late=7, pose=AT_REST)
            file.write("/imu", messages.IMU, START + number, **imu())
    with open_source(tmp_path / "x.mcap") as sequence:
        options = ConvertOptions(dry_run=True)
        lost = {
            where: convert(
                sequence, tmp_path / "y.mcap", "mcap", WriteOptions(groundtruth=where), options
            ).losses
            for where in ("pose", "none")
        }
    assert [loss.what for loss in lost["pose"]] == ["times of recording"]
    assert lost["none"] == ()


def test_times_of_any_size_are_compared() -> None:
    least, most = -(2**63), 2**63 - 1
    log_times, stamps = np.array([least, least, most, 7, -3]), np.array([0, most, least, 7, -4])
    assert lateness(log_times, stamps) == Lateness(4, 2**64 - 1)
    assert lateness(log_times[:1], stamps[:1]) == Lateness(1, 2**63)
    assert lateness(log_times[:0], stamps[:0]) == Lateness()


POSE = T["geometry_msgs/msg/Pose"](
    T["geometry_msgs/msg/Point"](1.0, 2.0, 3.0), T["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
)


def _with_covariance(number: float) -> object:
    covariance = np.zeros(36)
    covariance[7] = number
    return T["geometry_msgs/msg/PoseWithCovariance"](POSE, covariance)


def _odometry(n: int, variance: float, speed: float, child: str) -> object:
    vector = T["geometry_msgs/msg/Vector3"]
    twist = T["geometry_msgs/msg/Twist"](vector(0.0, speed, 0.0), vector(0.0, 0.0, 0.0))
    moving = T["geometry_msgs/msg/TwistWithCovariance"](twist, np.zeros(36))
    head = header(START + n * MS, "map")
    return T["nav_msgs/msg/Odometry"](head, child, _with_covariance(variance), moving)


def test_what_poses_say_beside_the_pose_is_told(tmp_path: Path) -> None:
    kind = "geometry_msgs/msg/PoseWithCovarianceStamped"
    made = [T[kind](header(START + n * MS, "map"), _with_covariance(n % 2)) for n in range(6)]
    write_messages(tmp_path / "a.bag", [(START + n * MS, "/pose", kind, one) for n, one in enumerate(made)])
    assert losses(tmp_path / "a.bag") == {("/pose", COVARIANCES): 3}
    kind = "nav_msgs/msg/Odometry"
    for name, (variance, speed, child), told in (
        ("nothing", (0.0, 0.0, ""), {}),
        ("all", (0.5, 1.0, "base"), {COVARIANCES: 4, "velocities": 4, "child frame ids": 4}),
    ):
        path = tmp_path / f"{name}.bag"
        made = [_odometry(n, variance, speed, child) for n in range(4)]
        write_messages(path, [(START + n * MS, "/odom", kind, one) for n, one in enumerate(made)])
        assert losses(path) == {("/odom", what): count for what, count in told.items()}


def _window(**changes: object) -> dict[str, object]:
    size = {"height": 6, "width": 8}
    roi = {"x_offset": 0, "y_offset": 0, "height": 0, "width": 0, "do_rectify": False}
    roi |= {name: value for name, value in changes.items() if name in roi}
    return {**size, "binning_x": 0, "binning_y": 0, "roi": roi} | {
        name: value for name, value in changes.items() if name.startswith("binning")
    }


@pytest.mark.parametrize(
    ("changes", "is_told"),
    [
        ({}, False),
        ({"binning_x": 1, "binning_y": 1}, False),
        ({"height": 6, "width": 8}, False),
        ({"binning_x": 2}, True),
        ({"binning_y": 2}, True),
        ({"x_offset": 1}, True),
        ({"height": 3, "width": 8}, True),
        ({"do_rectify": True}, True),
    ],
)
def test_a_window_of_a_calibration_is_one_if_it_is_not_the_whole_image(
    changes: dict[str, object], is_told: bool
) -> None:
    assert has_window(_window(**changes)) == is_told


def test_a_window_is_told_with_the_number_of_calibrations(tmp_path: Path) -> None:
    k = np.array([5.0, 0, 4, 0, 5, 3, 0, 0, 1])
    p = np.zeros(12)
    region = T["sensor_msgs/msg/RegionOfInterest"]
    image = T["sensor_msgs/msg/Image"]
    for name, roi, told in (("a", (0, 0, 0, 0), 0), ("b", (1, 2, 3, 4), 4)):
        entries = []
        for n in range(4):
            stamp = START + n * MS
            info = T["sensor_msgs/msg/CameraInfo"](
                header(stamp, "cam"), 6, 8, "plumb_bob", np.zeros(5), k, np.eye(3).ravel(), p, 0, 0,
                region(*roi, False),
            )  # fmt: skip
            pixels = image(header(stamp, "cam"), 6, 8, "mono8", 0, 8, np.zeros(48, np.uint8))
            entries += [
                (stamp, "/cam/image_raw", "sensor_msgs/msg/Image", pixels),
                (stamp, "/cam/camera_info", "sensor_msgs/msg/CameraInfo", info),
            ]
        write_messages(tmp_path / f"{name}.bag", entries)
        found = losses(tmp_path / f"{name}.bag")
        what = "binning, region of interest or rectification"
        assert found == ({("/cam/camera_info", what): told} if told else {})


def test_poses_at_whose_time_not_all_transforms_are_known_are_told(tmp_path: Path) -> None:
    kind = "tf/msg/tfMessage"
    vector, quaternion = T["geometry_msgs/msg/Vector3"], T["geometry_msgs/msg/Quaternion"]

    def tf(n: int, parent: str, child: str) -> tuple[int, str, str, object]:
        stamp = START + n * MS
        motion = T["geometry_msgs/msg/Transform"](vector(float(n), 0.0, 0.0), quaternion(0.0, 0.0, 0.0, 1.0))
        one = T["geometry_msgs/msg/TransformStamped"](header(stamp, parent), child, motion)
        return stamp, "/tf", kind, T[kind]([one])

    path = tmp_path / "x.bag"
    write_messages(
        path, [tf(n, "world", "body") for n in range(10)] + [tf(n, "body", "cam") for n in range(2, 8)]
    )
    found = losses(path, groundtruth="/tf:world.cam")
    assert found == {("groundtruth", "poses not carried over"): 4}
    assert losses(path, groundtruth="/tf:world.body") == {("groundtruth", "transforms not carried over"): 6}


@pytest.mark.parametrize("name", ["mcap", "rosbag1", "rosbag2"])
@pytest.mark.parametrize("layout", ["published", "modern"])
def test_our_own_recordings_say_nothing_that_is_lost(name: str, layout: str, tmp_path: Path) -> None:
    source = Memory(
        {"rgb": [START], "depth": [START], "ir": [START]},
        accelerometer=accelerometer(*range(START, START + 50 * MS, MS)),
        groundtruth=groundtruth(*range(START, START + 50 * MS, MS)),
    )
    path = tmp_path / f"x{FORMATS[name].suffix}"
    for groundtruth_as in ("pose", "tf", "both"):
        convert(
            source, path, name, WriteOptions(layout=layout, groundtruth=groundtruth_as),
            ConvertOptions(force=True),
        )  # fmt: skip
        with open_source(path) as sequence:
            assert (sequence.info.not_carried, sequence.info.warnings) == ((), ())
            assert isinstance(sequence.groundtruth, Trajectory)


@pytest.mark.real
def test_real_recordings_say_more(real_data: Path) -> None:
    odometry = dict.fromkeys((COVARIANCES, "velocities", "child frame ids"), 3060)
    found = losses(real_data / "bags" / "robot_localization_test2.bag")
    assert {what: n for (stream, what), n in found.items() if stream.endswith("/odom")} == odometry
    assert {what: n for (stream, what), n in found.items() if stream == "/imu/data"} == {
        INERTIAL: 3061,
        COVARIANCES: 3061,
    }
    found = losses(real_data / "bags" / "evo" / "nav2_turtlebot.mcap", groundtruth="/amcl_pose")
    assert found["/amcl_pose", COVARIANCES] == 135


@pytest.mark.parametrize("poses", ["tf", "both"])
def test_transforms_that_others_added_to_a_recording_of_ours_are_told(poses: str, tmp_path: Path) -> None:
    given = Memory({}, groundtruth=groundtruth(START, START + 1, START + 2))
    convert(given, tmp_path / "ours.mcap", "mcap", WriteOptions(groundtruth=poses))
    assert losses(tmp_path / "ours.mcap") == {}
    ours = McapRecording(tmp_path / "ours.mcap")
    with Foreign(tmp_path / "x.mcap") as file:
        file.copy(ours)
        for number in range(2):
            moved = {"translation": ZERO, "rotation": ONE}
            named = {
                "header": file.header(START + number, "odom"),
                "child_frame_id": "base",
                "transform": moved,
            }
            file.write("/tf", messages.TF_MESSAGE, START + number, transforms=[named])
    assert losses(tmp_path / "x.mcap") == {("/tf", "transforms not carried over"): 2}
    with open_source(tmp_path / "x.mcap") as sequence:
        assert sequence.groundtruth is not None
        assert len(sequence.groundtruth) == 3


def test_a_recording_of_ours_that_was_played_and_recorded_again_has_its_own_stamps(tmp_path: Path) -> None:
    given = Memory({"rgb": [START, START + MS], "depth": [START + 5]}, accelerometer=accelerometer(START))
    convert(given, tmp_path / "ours.mcap", "mcap")
    ours = McapRecording(tmp_path / "ours.mcap")
    with Foreign(tmp_path / "x.mcap") as file:
        file.copy(ours, later=1000)
    with open_source(tmp_path / "x.mcap") as sequence:
        assert sequence.image_stamps("rgb").tolist() == [START, START + MS]
        assert sequence.image_stamps("depth").tolist() == [START + 5]
        assert {loss.what for loss in sequence.info.not_carried} == {"times of recording"}
        report = convert(sequence, tmp_path / "back.mcap", "mcap")
    assert {loss.what for loss in report.losses} == {"times of recording"}
    with open_source(tmp_path / "back.mcap") as back, open_source(tmp_path / "ours.mcap") as before:
        assert diff(before, back).same
