# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Plans: the same for the same manifest, without outputs in each other's way, and not to be edited."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from typing import TYPE_CHECKING

import pytest

from tests.batch.batches import FIXTURES, FOUR_TARGETS
from tumtools.batch.manifest import read_manifest
from tumtools.batch.plan import Plan, make_plan, task_id
from tumtools.batch.plan_file import read_plan, write_plan
from tumtools.errors import InputError, UsageError

if TYPE_CHECKING:
    from pathlib import Path


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name in ("full", "early"):
        shutil.copytree(FIXTURES / name, tmp_path / "data" / name)
    return tmp_path


def plan_of(folder: Path, text: str = "", head: str = "", source: str = 'path = "data/*"') -> Plan:
    path = folder / "manifest.toml"
    path.write_text(f'destination = "out"\n{head}\n[[source]]\n{source}\n{text or FOUR_TARGETS}')
    return make_plan(read_manifest(path))


def test_the_same_manifest_gives_the_same_file(folder: Path) -> None:
    plan = plan_of(folder)
    write_plan(plan, folder / "a.json")
    write_plan(plan_of(folder), folder / "b.json")
    assert (folder / "a.json").read_bytes() == (folder / "b.json").read_bytes()
    assert read_plan(folder / "a.json") == plan
    assert len({task.id for task in plan.tasks}) == 8
    assert all(task.bytes_in and task.bytes_out for task in plan.tasks)


def test_any_option_changes_the_task_but_moving_the_destination_does_not(folder: Path) -> None:
    one = '[[target]]\nto = "mcap"\n'
    base = plan_of(folder, one).tasks[0].id
    for more in ('compression = "none"', "every = 2", "strict = true", 'start = "0.1"', 'streams = ["rgb"]'):
        assert plan_of(folder, one + more).tasks[0].id != base
    assert plan_of(folder, one, head="jobs = 4").tasks[0].id == base
    path = folder / "manifest.toml"
    path.write_text(path.read_text().replace('"out"', '"elsewhere"'))
    assert make_plan(read_manifest(path)).tasks[0].id == base


def test_losses_are_told_before_anything_is_written(folder: Path) -> None:
    plan = plan_of(folder, '[[target]]\nto = "mcap"\ndepth_encoding = "16UC1"\n')
    assert any("depth" in loss for loss in plan.tasks[0].losses)


@pytest.mark.parametrize(
    ("targets", "head", "source", "message"),
    [
        ("", 'template = "{name}"', 'path = "data/*"', "is the same as"),
        ("", 'template = "{name}/{format}/../x.{ext}"', 'path = "data/*"', "no name below the destination"),
        ("", 'template = ".tumtools/{name}.{ext}"', 'path = "data/*"', "no name below the destination"),
        ('[[target]]\nto = "tum"\n', 'template = "../data/{name}"', 'path = "data/*"', "no name below"),
        ("", "", 'path = "nowhere/*"', "no recording is there"),
        ("", "", 'path = "nowhere"', "there is no such file"),
        ("", "", 'name = "fr1/dusk"', "no sequence is called"),
        ("", "", 'path = "data/*"\nlabel = "x"', "label names one source"),
    ],
)
def test_plans_that_cannot_be_are_refused(
    folder: Path, targets: str, head: str, source: str, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        plan_of(folder, targets, head, source)


def test_outputs_are_not_written_into_sources(folder: Path) -> None:
    path = folder / "manifest.toml"
    path.write_text(
        'destination = "data"\ntemplate = "{name}"\n[[source]]\npath = "data/*"\n[[target]]\nto = "tum"\n'
    )
    with pytest.raises(InputError, match="in the way of a source"):
        make_plan(read_manifest(path))


def test_outputs_inside_of_outputs_are_refused(folder: Path) -> None:
    targets = '[[target]]\nto = "tum"\nlabel = "a"\n[[target]]\nto = "mcap"\nlabel = "a/b"\n'
    with pytest.raises(InputError, match="is inside of"):
        plan_of(folder, targets, 'template = "{name}/{target}"')


def test_a_source_that_is_named_twice_is_planned_once(folder: Path) -> None:
    one = '[[target]]\nto = "mcap"\n'
    assert len(plan_of(folder, one, source='path = "data/*"\n[[source]]\npath = "data/full"').tasks) == 2


def test_the_catalogue_is_filtered(folder: Path) -> None:
    plan = plan_of(
        folder, '[[target]]\nto = "mcap"\n', 'estimate = "off"', 'camera = "fr2"\nexclude = ["*_xyz"]'
    )
    names = {task.source.name for task in plan.tasks}
    assert "rgbd_dataset_freiburg2_desk" in names
    assert all(name.startswith("rgbd_dataset_freiburg2_") and not name.endswith("_xyz") for name in names)


def test_a_damaged_source_is_planned_with_its_problem(folder: Path) -> None:
    (folder / "data" / "broken.mcap").write_bytes(b"\x89MCAP0\r\nnothing")
    plan = plan_of(folder, '[[target]]\nto = "tum"\n')
    assert [bool(task.problem) for task in plan.tasks] == [True, False, False]


def test_of_many_sources_some_are_opened_and_the_others_taken_in_proportion(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for number in range(4):
        shutil.copytree(FIXTURES / "full", folder / "data" / f"full_{number}")
    assert plan_of(folder).opened == 6
    assert plan_of(folder, head='estimate = "size"').opened == 0
    monkeypatch.setattr("tumtools.batch.estimate.MOST_OPENED", 3)
    plan = plan_of(folder, '[[target]]\nto = "mcap"\ndepth_encoding = "16UC1"\n')
    assert plan.opened == 3
    assert [bool(task.losses) for task in plan.tasks] == [True, False] * 3
    assert all(task.bytes_in and task.bytes_out != task.bytes_in for task in plan.tasks)
    write_plan(plan, folder / "plan.json")
    assert read_plan(folder / "plan.json") == plan
    assert plan_of(folder, head='estimate = "open"').opened == 6


def test_a_link_that_leads_nowhere_is_planned_with_its_problem(folder: Path) -> None:
    (folder / "data" / "link.bag").symlink_to(folder / "nowhere.bag")
    for how in ("auto", "size"):
        plan = plan_of(folder, head=f'estimate = "{how}"')
        assert sorted(task.source.name for task in plan.tasks if task.problem) == ["link"] * 4


@pytest.mark.parametrize("change", ["output", "order", "remove"])
def test_edited_plans_are_refused(folder: Path, change: str) -> None:
    path = folder / "plan.json"
    write_plan(plan_of(folder), path)
    document = json.loads(path.read_text())
    if change == "output":
        document["tasks"][0]["output"] = "../../etc/x"
    elif change == "order":
        document["tasks"].reverse()
    else:
        del document["tasks"][0]
    path.write_text(json.dumps(document))
    with pytest.raises(InputError, match="not edited"):
        read_plan(path)


@pytest.mark.parametrize("output", ["../x.mcap", "/etc/x", "a//b", ".tumtools/ledger/x"])
def test_plans_of_strangers_cannot_write_elsewhere(folder: Path, output: str) -> None:
    plan = plan_of(folder, '[[target]]\nto = "mcap"\n')
    task = plan.tasks[0]
    forged = replace(task, output=output, id=task_id(task.source, task.target, output, plan.policy))
    write_plan(replace(plan, tasks=(forged,)), folder / "plan.json")
    with pytest.raises(InputError, match="not what its id says"):
        read_plan(folder / "plan.json")


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"schema_version": 1}', '{"schema_version": 9}'])
def test_what_is_no_plan_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "plan.json").write_text(text)
    with pytest.raises(InputError):
        read_plan(tmp_path / "plan.json")


def test_only_plans_are_replaced(folder: Path) -> None:
    plan = plan_of(folder)
    before = (folder / "manifest.toml").read_bytes()
    with pytest.raises(UsageError, match="what is there is no plan"):
        write_plan(plan, folder / "manifest.toml")
    assert (folder / "manifest.toml").read_bytes() == before
    (folder / "plan.json").touch()
    write_plan(plan, folder / "plan.json")
    write_plan(plan, folder / "plan.json")


@pytest.mark.parametrize("pattern", ["*", "*/*", "o*"])
def test_a_pattern_does_not_match_the_destination(folder: Path, pattern: str) -> None:
    source = f'path = "{pattern}"\nexclude = ["*.toml"]'
    head = 'estimate = "off"'
    (folder / "other").mkdir()
    before = plan_of(folder, head=head, source=source)
    shutil.copytree(FIXTURES / "full", folder / "out" / "full" / "full")
    assert plan_of(folder, head=head, source=source) == before


def test_a_pattern_in_the_destination_is_meant(folder: Path) -> None:
    (folder / "manifest.toml").write_text(
        'destination = "data"\ntemplate = "{name}.{ext}"\n'
        '[[source]]\npath = "data/*"\n[[target]]\nto = "mcap"\n'
    )
    assert len(make_plan(read_manifest(folder / "manifest.toml")).tasks) == 2


@pytest.mark.parametrize("linked", ["source", "destination"])
def test_outputs_are_not_written_into_sources_by_another_name(folder: Path, linked: str) -> None:
    data = (folder / "data").rename(folder / "real")
    if linked == "source":
        (folder / "link").symlink_to(data / "full")
        source, destination = "link", data / "full" / "out"
    else:
        (folder / "out").symlink_to(data)
        source, destination = "real/full", folder / "out" / "full"
    (folder / "manifest.toml").write_text(
        f'destination = "{destination}"\n[[source]]\npath = "{source}"\n[[target]]\nto = "mcap"\n'
    )
    with pytest.raises(InputError, match="in the way of a source"):
        make_plan(read_manifest(folder / "manifest.toml"))


def test_outputs_do_not_replace_sources_in_a_store(tmp_path: Path) -> None:
    (tmp_path / "manifest.toml").write_text(
        'destination = "s3://lab"\ntemplate = "{parent}/{name}.{ext}"\n'
        '[[source]]\npath = "s3://lab/day/rec.bag"\n[[target]]\nto = "rosbag1"\n'
    )
    with pytest.raises(InputError, match="in the way of a source"):
        make_plan(read_manifest(tmp_path / "manifest.toml"))


def test_a_shard_has_all_targets_of_its_sources(folder: Path) -> None:
    plan = plan_of(folder)
    first, second = (plan.shard(index, 2) for index in (1, 2))
    assert {task.source.name for task in first.tasks} == {"early"}
    assert {task.source.name for task in second.tasks} == {"full"}
    parts = [plan.shard(index, 3).tasks for index in (1, 2, 3)]  # more parts than sources
    assert [len(part) for part in parts] == [3, 3, 2]
    assert {task.id for part in parts for task in part} == {task.id for task in plan.tasks}


def test_names_that_file_systems_do_not_take_are_refused(folder: Path) -> None:
    with pytest.raises(InputError, match="too long"):
        plan_of(folder, source=f'path = "data/full"\nlabel = "{"x" * 250}"')


def test_a_strict_target_that_would_lose_something_is_told(folder: Path) -> None:
    (folder / "data" / "full" / "notes.txt").write_text("of the day\n")
    plan = plan_of(folder, '[[target]]\nto = "mcap"\nstrict = true\n')
    assert ["mcap is strict: " in task.problem for task in plan.tasks] == [False, True]


def test_a_filter_that_matches_nothing_names_the_cameras(folder: Path) -> None:
    with pytest.raises(InputError, match="cameras: fr1, fr2, fr3"):
        plan_of(folder, source='camera = "fr9"')


def test_a_sequence_that_is_to_be_fetched_is_no_problem(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TUMTOOLS_CACHE", str(folder / "cache"))
    one = '[[target]]\nto = "mcap"\n'
    (task,) = plan_of(folder, one, source='name = "fr1/desk"\nfetch = true').tasks
    assert (task.problem, task.bytes_in > 10**8) == ("", True)
    (task,) = plan_of(folder, one, source='name = "fr1/desk"').tasks
    assert "`fetch = true`" in task.problem


CALIBRATION = """\
image_width: 640
image_height: 480
camera_matrix: {rows: 3, cols: 3, data: [500.0, 0, 320.0, 0, 500.0, 240.0, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}
rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}
projection_matrix: {rows: 3, cols: 4, data: [500.0, 0, 320.0, 0, 0, 500.0, 240.0, 0, 0, 0, 1, 0]}
"""


def test_the_file_of_a_calibration_is_part_of_the_plan(folder: Path) -> None:
    (folder / "cal.yaml").write_text(CALIBRATION)
    target = '[[target]]\nto = "rosbag1"\ncamera = "cal.yaml"\n'
    plan = plan_of(folder, target)
    options = plan.targets[0].write_options()
    assert (options.camera, options.cameras["rgb"].k[0], options.cameras["depth"].k[2]) == (None, 500, 320)
    write_plan(plan, folder / "plan.json")
    assert read_plan(folder / "plan.json") == plan
    (folder / "cal.yaml").write_text(CALIBRATION.replace("500.0", "501.0"))
    assert {task.id for task in plan_of(folder, target).tasks}.isdisjoint(task.id for task in plan.tasks)


@pytest.mark.parametrize("camera", ["nosuch.yaml", "fr9"])
def test_a_calibration_that_is_not_there_is_refused_with_its_line(folder: Path, camera: str) -> None:
    with pytest.raises(InputError, match="there is no such calibration") as caught:
        plan_of(folder, f'[[target]]\nto = "rosbag1"\ncamera = "{camera}"\n')
    assert caught.value.location == "line 7"
    assert "fr1, fr2, fr3" in str(caught.value.hint)


def test_an_edited_destination_is_said_to_be_that(folder: Path) -> None:
    path = folder / "plan.json"
    write_plan(plan_of(folder), path)
    path.write_text(path.read_text().replace('/out"', '/elsewhere"'))
    with pytest.raises(InputError, match="the destination, the policy, a target or a task was changed"):
        read_plan(path)


@pytest.mark.parametrize(
    "kind", ["folder", "empty folder", "link to a folder", "other json", "link to nothing"]
)
def test_a_plan_replaces_no_folder_and_nothing_of_others(folder: Path, kind: str) -> None:
    plan, path = plan_of(folder), folder / "place"
    if kind == "folder":
        path = folder / "data"
    elif kind == "empty folder":
        path.mkdir()
    elif kind == "link to a folder":
        path.symlink_to(folder / "data")
    elif kind == "other json":
        path.write_text('{\n "schema_version": 1,\n "plans": "mine"\n}\n')
    else:
        path.symlink_to(folder / "nowhere")
    before = sorted(folder.rglob("*"))
    with pytest.raises(UsageError):
        write_plan(plan, path)
    assert sorted(folder.rglob("*")) == before


@pytest.mark.parametrize(
    "second",
    ['label = "other"', 'label = "other"\nsalvage = true', 'label = "x"\ntopics = { rgb = "/a" }'],
)
def test_a_source_that_is_to_be_read_in_two_ways_is_two_tasks(folder: Path, second: str) -> None:
    source = f'path = "data/full"\n[[source]]\npath = "data/full"\n{second}'
    plan = plan_of(folder, '[[target]]\nto = "mcap"\n', source=source)
    assert len({task.output for task in plan.tasks}) == 2
    write_plan(plan, folder / "plan.json")
    assert read_plan(folder / "plan.json") == plan


@pytest.mark.parametrize("second", ["salvage = true", 'topics = { rgb = "/a" }'])
def test_two_ways_to_read_a_source_into_one_output_are_refused_with_the_line(
    folder: Path, second: str
) -> None:
    source = f'path = "data/*"\n[[source]]\npath = "data/full"\n{second}'
    with pytest.raises(InputError, match="is the same as") as caught:
        plan_of(folder, '[[target]]\nto = "mcap"\n', source=source)
    assert caught.value.location == "line 5"


def test_a_source_that_is_to_be_fetched_by_one_of_two_is_fetched(folder: Path) -> None:
    for fetch in ("", "fetch = true\n"):
        one, other = f'name = "fr1/desk"\n{fetch}', 'camera = "fr1"\nfetch = true\n'
        (task, *_) = plan_of(
            folder, '[[target]]\nto = "mcap"\n', 'estimate = "off"', f"{one}[[source]]\n{other}"
        ).tasks
        assert (task.source.name, task.source.fetch) == ("rgbd_dataset_freiburg1_desk", True)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('"digest": true', '"digest": false'),
        ('"jobs": 1', '"jobs": 2'),
        ('"bytes_in":', '"bytes_in":1'),
        ('"opened": 2', '"opened": 1'),
        ('"uri":', '"fetch":true,"uri":'),
        ('"output":', '"problem":"none","output":'),
    ],
)
def test_a_plan_that_was_edited_anywhere_is_refused(folder: Path, old: str, new: str) -> None:
    path = folder / "plan.json"
    write_plan(plan_of(folder), path)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError, match="plans are not edited"):
        read_plan(path)


def test_wrong_types_in_a_plan_are_refused(folder: Path) -> None:
    path = folder / "plan.json"
    plan = plan_of(folder, head='estimate = "off"')
    write_plan(plan, path)
    good = path.read_text()
    places = {
        "head": ("schema_version", "plan", "destination", "policy", "targets", "opened", "tasks"),
        "policy": ("validate", "digest", "jobs"),
        "target": ("to", "label", "write", "start", "every", "streams", "verify"),
        "task": ("id", "source", "target", "output", "bytes_in", "losses", "problem"),
        "source": ("uri", "name", "topics", "salvage", "camera"),
    }
    for place, names in places.items():
        for name in names:
            for value in (7, None, [], {}, [7], {"a": 7}, "x", 10**400, float("inf"), True):
                head = json.loads(good)
                task = head["tasks"][0]
                tables = {
                    "head": head,
                    "policy": head["policy"],
                    "target": head["targets"][0],
                    "task": task,
                    "source": task["source"],
                }
                tables[place][name] = value
                path.write_text(json.dumps(head))
                try:
                    assert read_plan(path) == plan
                except InputError as error:
                    told = error.message
                    assert not any(word in told for word in ("None", "__init__", "'str'")), (name, value)


@pytest.mark.parametrize("key", ["tasks", "plan", "targets", "policy"])
def test_a_plan_without_one_of_its_parts_says_which(folder: Path, key: str) -> None:
    path = folder / "plan.json"
    write_plan(plan_of(folder), path)
    document = json.loads(path.read_text())
    del document[key]
    path.write_text(json.dumps(document))
    with pytest.raises(InputError, match=key):
        read_plan(path)


def test_manifests_and_plans_are_no_recordings_for_a_pattern(folder: Path) -> None:
    (folder / "sequences").mkdir()
    shutil.copytree(folder / "data" / "full", folder / "full")
    shutil.rmtree(folder / "data")
    shutil.rmtree(folder / "sequences")
    first = plan_of(folder, source='path = "*"')
    assert {task.source.name for task in first.tasks} == {"full"}
    write_plan(first, folder / "plan.json")
    assert plan_of(folder, source='path = "*"') == first
