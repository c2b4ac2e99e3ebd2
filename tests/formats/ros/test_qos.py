# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""With which quality of service topics were offered is a loss, where it is not what we write."""

from __future__ import annotations

import sqlite3
import sys
from contextlib import closing
from typing import TYPE_CHECKING

import pytest
import yaml
from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from tests.formats.mcap.foreign import ONE, ZERO, Foreign
from tests.memory import START, full
from tumtools.convert import ConvertOptions, convert
from tumtools.errors import LossRefusedError
from tumtools.formats.options import ReadOptions, WriteOptions
from tumtools.formats.registry import FORMATS
from tumtools.formats.ros import messages
from tumtools.formats.ros.qos import beyond_ours, qos_profile
from tumtools.sources import open_source
from tumtools.transform import Selection

if TYPE_CHECKING:
    from pathlib import Path

    from tumtools.formats.ros.recording import MessageEncoding
    from tumtools.model.sequence import Sequence

NOT_KEPT = "QoS profile not kept"
NOT_READ = ("profiles that cannot be read",)
SENSOR = "- {reliability: best_effort, durability: volatile, history: keep_last, depth: 5}"
DEEP = "- {depth: 100}"


def profile(**changes: object) -> str:
    """Return what we write, with some of it changed and in another order."""
    ((ours),) = yaml.safe_load(qos_profile(latched=False))
    return yaml.safe_dump([dict(reversed((ours | changes).items()))], sort_keys=False)


def seconds(sec: int, nsec: int = 0) -> dict[str, int]:
    return {"sec": sec, "nsec": nsec}


def told(sequence: Sequence) -> list[tuple[str, int, str]]:
    found = [loss for loss in sequence.info.not_carried if loss.what == NOT_KEPT]
    assert not any(loss.alters for loss in found)
    return [(loss.stream, loss.count, loss.why.split(",")[0]) for loss in found]


@pytest.mark.parametrize("words", [False, True])
def test_what_we_write_is_nothing_beyond_it_in_either_spelling(words: bool) -> None:
    for latched in (False, True):
        text = qos_profile(latched=latched, words=words)
        assert beyond_ours([text, text + "\n" + text], latched=latched) == ()
        assert beyond_ours([yaml.safe_dump(yaml.safe_load(text))], latched=latched) == ()
    assert beyond_ours([qos_profile(latched=True, words=words)], latched=False) == (
        "transient_local, depth 1",
    )
    assert beyond_ours([qos_profile(latched=False, words=words)], latched=True) == ("volatile, depth 10",)


@pytest.mark.parametrize(
    "changes",
    [
        {"history": 3, "depth": 0},  # what others keep of a publisher is not known
        {"history": "unknown", "depth": 7},
        {"history": 0, "depth": 0, "reliability": 0, "durability": 0, "liveliness": 0},
        {"reliability": "system_default", "durability": "UNKNOWN", "liveliness": 4},
        {"deadline": seconds(0), "lifespan": seconds(0), "liveliness_lease_duration": seconds(0)},
        {"deadline": seconds(2147483647, 4294967295), "lifespan": seconds(2147483647, 2147483647)},
        {"deadline": None, "depth": None, "history": None},
    ],
)
def test_a_profile_that_leaves_something_to_others_says_nothing_beyond_ours(
    changes: dict[str, object],
) -> None:
    assert beyond_ours([profile(**changes)], latched=False) == ()


@pytest.mark.parametrize("text", ["", "null", "[]", "- {}", "- {}\n- {reliability: 1}\n"])
def test_no_profile_is_nothing_beyond_ours(text: str) -> None:
    assert beyond_ours([text], latched=False) == beyond_ours([text], latched=True) == ()


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"reliability": 2}, "best_effort"),
        ({"reliability": "best_effort"}, "best_effort"),
        ({"durability": 1}, "transient_local"),
        ({"history": 2}, "keep_all"),
        ({"history": "keep_all", "depth": 0}, "keep_all"),
        ({"depth": 5}, "depth 5"),
        ({"deadline": seconds(0, 100_000_000)}, "deadline 0.1 s"),
        ({"lifespan": seconds(10)}, "lifespan 10 s"),
        ({"liveliness": "manual_by_topic"}, "manual_by_topic"),
        ({"liveliness_lease_duration": seconds(2)}, "liveliness_lease_duration 2 s"),
        ({"avoid_ros_namespace_conventions": True}, "avoid_ros_namespace_conventions true"),
        ({"reliability": 9}, "reliability 9"),
        ({"priority": 3}, "priority 3"),
        ({"depth": 5, "reliability": 2, "durability": 1}, "best_effort, transient_local, depth 5"),
    ],
)
def test_what_a_profile_says_beyond_ours_is_named(changes: dict[str, object], said: str) -> None:
    assert beyond_ours([profile(**changes)], latched=False) == (said,)


def test_of_several_publishers_those_are_named_that_differ_from_ours_and_each_other() -> None:
    texts = [profile() + profile(depth=100) + profile(reliability=2), profile(depth=100), SENSOR]
    assert beyond_ours(texts, latched=False) == ("depth 100", "best_effort", "best_effort, depth 5")


BOMB = "- a0: &a0 [x, x]\n" + "".join(
    f"  a{n}: &a{n} [*a{n - 1}, *a{n - 1}, *a{n - 1}, *a{n - 1}]\n" for n in range(1, 40)
)


@pytest.mark.parametrize(
    "text",
    [
        "[", "a: b", "7", "- 7", "- [a]", "\x00", "- &a [*a]", "- !!python/object:os.system x",
        "- !!timestamp x", "- {? [a] : b}", "[" * 1000, "- " * 30_000, "#" * 10**6,
    ],
)  # fmt: skip
def test_a_text_that_is_no_list_of_profiles_is_named_as_such(text: str) -> None:
    assert beyond_ours([text], latched=False) == NOT_READ


@pytest.mark.parametrize(
    "value",
    ["[]", "{}", "{sec: -1, nsec: 0}", "{sec: '\u00b2', nsec: 1}", f"{{sec: {'9' * 5000}, nsec: 1}}", "x"],
)
def test_a_value_that_makes_no_sense_is_named_as_it_is(value: str) -> None:
    for key in ("deadline", "reliability", "depth", "anything"):
        (said,) = beyond_ours([f"- {{{key}: {value}}}"], latched=False)
        assert said.startswith(key)


def test_a_text_that_grows_when_it_is_read_takes_no_memory() -> None:
    ((said),) = beyond_ours([BOMB], latched=False)
    assert len(said) <= 200


def write_robot(path: Path, extra: dict[str, dict[str, str]], encoding: MessageEncoding = "cdr") -> None:
    """Write one message each of what a sequence is read from, and of what it is not."""
    with Foreign(path, encoding, extra=extra) as file:
        file.image("/cam/image", START, 0, frame_id="cam")
        file.calibration("/cam/camera_info", START, 525.0)
        file.compressed("/depth/image", START, 0, stream="depth")
        file.imu(START, 1.0)
        for number in range(3):
            for topic, edge in {"/tf": ("map", "base"), "/tf_static": ("base", "cam")}.items():
                one = {
                    "header": file.header(START + number, edge[0]),
                    "child_frame_id": edge[1],
                    "transform": {"translation": ZERO | {"x": number * (topic == "/tf")}, "rotation": ONE},
                }
                file.write(topic, messages.TF_MESSAGE, START + number, transforms=[one])
        file.other("/else", "Other", "jsonschema")


ALL = ("/cam/image", "/cam/camera_info", "/depth/image", "/imu/data", "/tf", "/tf_static", "/else")


def offered(**topics: str) -> dict[str, dict[str, str]]:
    return {topic: {"offered_qos_profiles": text} for topic, text in topics.items()}


@pytest.mark.parametrize("to", FORMATS)
def test_each_topic_that_is_read_is_told_with_its_stream_for_every_target(to: str, tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    write_robot(path, offered(**dict.fromkeys(ALL, SENSOR)))
    with open_source(path, ReadOptions(topics={"groundtruth": "/tf:map.cam"})) as sequence:
        assert told(sequence) == [
            ("rgb", 1, "/cam/image was offered with best_effort"),
            ("depth", 1, "/depth/image was offered with best_effort"),
            ("accelerometer", 1, "/imu/data was offered with best_effort"),
            ("groundtruth", 1, "/tf was offered with best_effort"),
            ("rgb", 1, "/cam/camera_info was offered with best_effort"),
            ("groundtruth", 1, "/tf_static was offered with best_effort"),
        ]
        strict = ConvertOptions(strict=True)
        with pytest.raises(LossRefusedError):
            convert(sequence, tmp_path / "y", to, options=strict)
        report = convert(sequence, tmp_path / "y", to)
    assert [loss.stream for loss in report.losses if loss.what == NOT_KEPT].count("rgb") == 2
    assert report.verified


def test_what_robots_offer_by_default_is_no_loss(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    usual = offered(**dict.fromkeys(ALL, profile(history=3, depth=0)))
    write_robot(path, usual | offered(**{"/tf_static": qos_profile(latched=True, words=True)}))
    with open_source(path, ReadOptions(topics={"groundtruth": "/tf:map.cam"})) as sequence:
        assert told(sequence) == []


def test_topics_that_are_not_read_are_not_told(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    write_robot(path, offered(**dict.fromkeys(("/tf", "/tf_static", "/else"), DEEP)))
    with open_source(path, ReadOptions(topics={"groundtruth": "/tf:map.cam"})) as sequence:
        assert [stream for stream, *_ in told(sequence)] == ["groundtruth"] * 2
    with Foreign(path, extra=offered(**{"/tf": DEEP, "/imu/data": DEEP})) as file:
        file.imu(START, 1.0)
        file.image("/cam/image", START, 0, frame_id="elsewhere")
        moved = {"translation": ZERO, "rotation": ONE}
        one = {"header": file.header(START, "a"), "child_frame_id": "b", "transform": moved}
        file.write("/tf", messages.TF_MESSAGE, START, transforms=[one])
    with open_source(path) as sequence:
        assert sequence.groundtruth is None
        assert told(sequence) == [("accelerometer", 1, "/imu/data was offered with depth 100")]


def test_a_topic_without_messages_is_no_loss(tmp_path: Path) -> None:
    with Foreign(tmp_path / "x.mcap", extra=offered(**{"/imu/data": DEEP})) as file:
        file.image("/cam/image", START, 0)
        file.channel("/imu/data", messages.IMU)
    with open_source(tmp_path / "x.mcap", ReadOptions(topics={"accelerometer": "/imu/data"})) as sequence:
        assert sequence.info.not_carried == ()


@pytest.mark.parametrize(
    ("streams", "topics"),
    [
        (("depth",), {"/depth/image"}),
        (("rgb",), {"/cam/image", "/cam/camera_info"}),
        (("groundtruth", "accelerometer"), {"/imu/data", "/tf", "/tf_static"}),
        (None, set(ALL[:-1])),
    ],
)
def test_profiles_of_streams_that_are_not_asked_for_are_no_loss(
    streams: tuple[str, ...] | None, topics: set[str], tmp_path: Path
) -> None:
    path = tmp_path / "x.mcap"
    write_robot(path, offered(**dict.fromkeys(ALL, DEEP)))
    options = ConvertOptions(Selection(streams=streams), dry_run=True)
    with open_source(path, ReadOptions(topics={"groundtruth": "/tf:map.cam"})) as sequence:
        losses = convert(sequence, tmp_path / "y", "tum", options=options).losses
    assert {loss.why.split()[0] for loss in losses if loss.what == NOT_KEPT} == topics


def test_of_many_profiles_the_first_are_shown(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    text = "".join(profile(depth=depth) for depth in (1, 2, 3, 4, 5, 10))
    with Foreign(path, extra=offered(**{"/imu/data": text})) as file:
        file.imu(START, 1.0)
    with open_source(path) as sequence:
        (loss,) = sequence.info.not_carried
    assert (loss.stream, loss.count) == ("accelerometer", 5)
    assert "offered with depth 1; with depth 2; with depth 3 and 2 more profiles" in loss.why


@pytest.mark.parametrize("distro", ["foxy", "humble", "jazzy"])
@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_recordings_of_ours_have_no_other_profiles(storage: str, distro: str, tmp_path: Path) -> None:
    convert(full(), tmp_path / "x", "rosbag2", WriteOptions(storage=storage, ros_distro=distro))
    with open_source(tmp_path / "x") as sequence:
        assert sequence.info.not_carried == ()


def qos(reliability: QosReliability, depth: int) -> Qos:
    forever = QosTime(9223372036, 854775807)
    return Qos(
        QosHistory.KEEP_LAST, depth, reliability, QosDurability.VOLATILE, forever, forever,
        QosLiveliness.AUTOMATIC, forever, False,
    )  # fmt: skip


@pytest.mark.parametrize("version", [8, 9])
@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_profiles_of_rosbag2_are_read_from_either_version_and_storage(
    version: int, storage: str, tmp_path: Path
) -> None:
    store = get_typestore(Stores.ROS2_HUMBLE)
    imu = messages.message_type(messages.IMU, "cdr")
    time = {"sec": START // 10**9, "nanosec": 0}
    values = {"orientation": ONE, "angular_velocity": ZERO, "linear_acceleration": ZERO}
    covariances = {f"{name}_covariance": [0.0] * 9 for name in values}
    zero = {"header": {"stamp": time, "frame_id": "imu"}, **values, **covariances}
    for name, offers, expected in (
        ("equal", [qos(QosReliability.RELIABLE, 10)] * 2, []),
        ("none", [], []),
        (
            "others",
            [qos(QosReliability.RELIABLE, 10), qos(QosReliability.BEST_EFFORT, 5)],
            [("accelerometer", 1, "/imu was offered with best_effort")],
        ),
    ):
        with Writer(
            tmp_path / name, version=version, storage_plugin=StoragePlugin[storage.upper()]
        ) as writer:
            place = writer.add_connection("/imu", messages.IMU, typestore=store, offered_qos_profiles=offers)
            writer.write(place, START, imu.encode(zero))
        with open_source(tmp_path / name) as sequence:
            assert told(sequence) == expected


def change_topics(folder: Path, profiles: object) -> None:
    """Change the profiles in metadata.yaml."""
    file = folder / "metadata.yaml"
    document = yaml.safe_load(file.read_text())
    for topic in document["rosbag2_bagfile_information"]["topics_with_message_count"]:
        topic["topic_metadata"]["offered_qos_profiles"] = profiles
    file.write_text(yaml.safe_dump(document))


@pytest.mark.parametrize("place", ["metadata.yaml", "topics"])
def test_profiles_are_told_wherever_a_recording_keeps_them(place: str, tmp_path: Path) -> None:
    convert(full(), tmp_path / "x", "rosbag2")
    if place == "topics":
        with closing(sqlite3.connect(tmp_path / "x" / "x_0.db3")) as database:
            database.execute("UPDATE topics SET offered_qos_profiles = ?", (DEEP,))
            database.commit()
    else:
        change_topics(tmp_path / "x", [{"depth": 100}])
    with open_source(tmp_path / "x") as sequence:
        assert {stream for stream, *_ in told(sequence)} == {
            *sequence.info.images,
            "accelerometer",
            "groundtruth",
        }


@pytest.mark.parametrize("profiles", [None, "", [], "[", 7, {"a": [1]}, [[[]]], "\x07", "deep", "loop"])
def test_profiles_of_any_kind_are_no_reason_to_stop(profiles: object, tmp_path: Path) -> None:
    convert(full(), tmp_path / "x", "rosbag2")
    change_topics(tmp_path / "x", profiles)
    file = tmp_path / "x" / "metadata.yaml"
    depth = sys.getrecursionlimit() // 10 * 4  # it is read, but cannot be written again
    text = {"deep": "[" * depth + "]" * depth, "loop": "&loop [*loop]"}.get(str(profiles))
    if text:
        file.write_text(file.read_text().replace(f"profiles: {profiles}", f"profiles: {text}", 1))
    with open_source(tmp_path / "x") as sequence:
        assert len(list(sequence.images())) == 9
        assert bool(told(sequence)) == bool(profiles)


def test_a_database_without_profiles_has_none(tmp_path: Path) -> None:
    convert(full(), tmp_path / "x", "rosbag2")
    file = tmp_path / "x" / "x_0.db3"
    with closing(sqlite3.connect(file)) as database:
        database.execute("ALTER TABLE topics DROP COLUMN offered_qos_profiles")
        database.execute("ALTER TABLE topics ADD COLUMN offered_qos_profiles TEXT")
        database.commit()
    with open_source(file) as sequence:
        assert told(sequence) == []


def test_latched_topics_of_ros_1_are_told_but_for_transforms_that_do_not_change(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    write_robot(
        path, {topic: {"latching": "1"} for topic in ("/cam/camera_info", "/tf_static", "/else")}, "ros1"
    )
    with open_source(path, ReadOptions(topics={"groundtruth": "/tf:map.cam"})) as sequence:
        found = [loss for loss in sequence.info.not_carried if "latch" in loss.what]
    assert [(loss.stream, loss.what) for loss in found] == [("rgb", "latching not kept")]
    assert found[0].why.startswith("/cam/camera_info was latched")


@pytest.mark.real
def test_profiles_of_a_real_robot(real_data: Path) -> None:
    path = real_data / "bags" / "evo" / "nav2_turtlebot.mcap"
    for topic, expected in {
        "/odom": [],
        "/amcl_pose": [("groundtruth", 1, "/amcl_pose was offered with transient_local")],
        "/tf:map.base_link": [("groundtruth", 1, "/tf was offered with depth 100")],
    }.items():
        with open_source(path, ReadOptions(topics={"groundtruth": topic})) as sequence:
            assert told(sequence) == expected
