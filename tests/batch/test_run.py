# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Runs: what is proven is left alone, everything else is done, one failure stays one failure."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import threading
import time
from collections import Counter
from dataclasses import replace
from importlib.metadata import EntryPoint, EntryPoints
from typing import TYPE_CHECKING

import pytest

from tests.batch.batches import FIXTURES
from tumtools.batch.claims import Claim, Claims
from tumtools.batch.engines import create_engine
from tumtools.batch.engines.engine import Completed, EngineLostError, EngineSettings
from tumtools.batch.engines.inline import InlineEngine
from tumtools.batch.ledger import Entry, Ledger
from tumtools.batch.losses import sum_up
from tumtools.batch.manifest import read_manifest
from tumtools.batch.owner import Owner, this_process
from tumtools.batch.plan import Plan, make_plan
from tumtools.batch.run import RunOptions, chosen, run
from tumtools.batch.status import status
from tumtools.batch.stores import open_store
from tumtools.batch.stores.local import LocalStore
from tumtools.errors import FetchError, OutputError, UsageError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path


def plan_of(folder: Path, head: str = "", targets: str = '[[target]]\nto = "mcap"\n') -> Plan:
    path = folder / "manifest.toml"
    path.write_text(f'destination = "out"\n{head}\n[[source]]\npath = "data/*"\n{targets}')
    return make_plan(read_manifest(path))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name in ("full", "early", "fr3"):
        shutil.copytree(FIXTURES / name, tmp_path / "data" / name)
    return tmp_path


def run_inline(plan: Plan, **how: bool) -> dict[str, int]:
    """Run and count `worked done`, `kept done`, `worked failed` and so on."""
    options = RunOptions(**how)  # type: ignore[arg-type]  # flags only
    outcomes = run(plan, chosen(plan, options), create_engine("inline", EngineSettings()), options)
    return dict(
        Counter(
            f"{outcome.how} {outcome.entry.state if outcome.entry else ''}".strip() for outcome in outcomes
        )
    )


def states(plan: Plan) -> dict[str, int]:
    return dict(Counter(standing.state for standing in status(plan)))


def entry_of(plan: Plan, name: str) -> Entry:
    task = next(task for task in plan.tasks if task.source.name == name)
    entry = Ledger(open_store(plan.destination)).read(task.id)
    assert entry is not None
    return entry


def test_what_is_done_is_kept(folder: Path) -> None:
    plan = plan_of(folder)
    assert states(plan) == {"pending": 3}
    assert run_inline(plan) == {"worked done": 3}
    assert run_inline(plan) == {"kept done": 3}
    assert states(plan) == {"done": 3}


@pytest.mark.parametrize("change", ["remove", "truncate", "same size", "ledger", "source"])
def test_what_is_not_proven_is_done_again(folder: Path, change: str) -> None:
    plan = plan_of(folder)
    run_inline(plan)
    output = folder / "out/full/full.mcap"
    before = output.read_bytes()
    if change == "remove":
        output.unlink()
    elif change == "truncate":
        output.write_bytes(before[:-1])
    elif change == "same size":
        output.write_bytes(before[:-1] + b"x")
    elif change == "ledger":
        next((folder / "out/.tumtools/ledger").glob(f"*/{plan.tasks[2].id}.json")).write_text("{")
    else:
        with (folder / "data/full/groundtruth.txt").open("a") as file:
            file.write("# another line\n")
    assert states(plan) in ({"done": 2, "changed": 1}, {"done": 2, "pending": 1})
    assert run_inline(plan) == {"worked done": 1, "kept done": 2}
    assert states(plan) == {"done": 3}
    if change != "source":
        assert output.read_bytes() == before


def test_times_that_differ_are_no_matter_where_the_bytes_are_the_same(folder: Path) -> None:
    plan = plan_of(folder)
    run_inline(plan)
    os.utime(folder / "out/full/full.mcap", ns=(1, 1))
    os.utime(folder / "data/full/rgb.txt", ns=(1, 1))
    assert run_inline(plan) == {"kept done": 3}


def test_outputs_stay_when_their_sources_go(folder: Path) -> None:
    plan = plan_of(folder)
    run_inline(plan)
    shutil.rmtree(folder / "data/full")
    assert run_inline(plan) == {"kept done": 3}


def test_other_options_make_the_output_anew(folder: Path) -> None:
    run_inline(plan_of(folder))
    before = (folder / "out/full/full.mcap").read_bytes()
    other = plan_of(folder, targets='[[target]]\nto = "mcap"\ncompression = "none"\n')
    assert run_inline(other) == {"worked done": 3}
    assert (folder / "out/full/full.mcap").read_bytes() != before


def test_a_damaged_source_fails_alone_and_retry_does_only_that(folder: Path) -> None:
    image = next((folder / "data/full/rgb").glob("*.png"))
    good = image.read_bytes()
    image.write_bytes(good[:-20])
    plan = plan_of(folder)
    assert run_inline(plan) == {"worked failed": 1, "worked done": 2}
    assert states(plan) == {"failed": 1, "done": 2}
    assert image.name in entry_of(plan, "full").reason
    assert not (folder / "out/full").exists() or list((folder / "out/full").iterdir()) == []
    image.write_bytes(good)
    assert run_inline(plan, retry=True) == {"worked done": 1}
    assert entry_of(plan, "full").attempts == 2
    assert states(plan) == {"done": 3}


@pytest.mark.parametrize(
    ("how", "outcome"), [("warn", "worked done"), ("skip", "worked skipped"), ("fail", "worked failed")]
)
def test_findings_are_dealt_with_as_the_manifest_says(folder: Path, how: str, outcome: str) -> None:
    path = folder / "data/full/groundtruth.txt"
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join([*lines[:5], lines[6], lines[5], *lines[7:]]))  # stamps go back
    plan = plan_of(folder, f'on_findings = "{how}"\nfail_on = "warning"')
    counts = run_inline(plan)
    entry = entry_of(plan, "full")
    assert any("groundtruth.txt" in finding for finding in entry.findings)
    assert counts[outcome] >= 1
    if how == "skip":
        assert run_inline(plan)["kept skipped"] == counts[outcome]
        path.write_text("".join(lines))
        run_inline(plan)
        assert not any("groundtruth.txt" in finding for finding in entry_of(plan, "full").findings)


def test_what_somebody_else_works_on_is_left_to_them(folder: Path) -> None:
    plan = plan_of(folder)
    with Claims(open_store(plan.destination)).hold(plan.tasks[0].id, 0) as claim:
        assert claim is not None
        assert states(plan) == {"running": 1, "pending": 2}
        assert run_inline(plan, claim=True) == {"busy": 1, "worked done": 2}
    assert run_inline(plan, claim=True) == {"worked done": 1, "kept done": 2}


def test_shards_are_all_of_the_plan_once(folder: Path) -> None:
    plan = plan_of(folder)
    shards = [plan.shard(index, 2) for index in (1, 2)]
    assert [run_inline(shard) for shard in shards] == [{"worked done": 2}, {"worked done": 1}]
    assert run_inline(plan) == {"kept done": 3}


def test_outputs_stay_when_their_sources_are_out_of_reach(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plan = plan_of(folder)
    run_inline(plan)

    def fail(source: object) -> None:
        raise FetchError("no route to host")

    monkeypatch.setattr("tumtools.batch.proof.measure_source", fail)
    assert run_inline(plan) == {"kept done": 3}
    told = {(standing.state, standing.unknown) for standing in status(plan)}
    assert told == {("unknown", "the source cannot be compared: no route to host")}


class LosesAnswers(InlineEngine):
    """Does the work, and tells that the worker was lost."""

    def as_completed(self) -> Iterator[Completed]:
        for completed in super().as_completed():
            yield Completed(completed.job, None, "lost")


def test_a_worker_that_is_lost_after_its_entry_is_written_has_not_failed(folder: Path) -> None:
    plan = plan_of(folder)
    outcomes = list(run(plan, list(plan.tasks), LosesAnswers(EngineSettings()), RunOptions()))
    assert [outcome.entry.state for outcome in outcomes if outcome.entry] == ["done"] * 3
    assert states(plan) == {"done": 3}


class Loses(InlineEngine):
    """Loses each job before it is begun, and leaves a claim."""

    claim: Claim | None = None

    def as_completed(self) -> Iterator[Completed]:
        if self.claim is not None:
            store = open_store(self._jobs[0].destination)
            store.create(f".tumtools/claims/{self.claim.task}.json", self.claim.encoded())
        while self._jobs:
            yield Completed(self._jobs.popleft(), None, "lost")


def lose_all(plan: Plan, **how: bool) -> dict[str, int]:
    options = RunOptions(**how)  # type: ignore[arg-type]  # flags only
    outcomes = run(plan, list(plan.tasks), Loses(EngineSettings()), options)
    return dict(Counter(f"{outcome.how} {outcome.entry.state}" for outcome in outcomes if outcome.entry))


@pytest.mark.parametrize("skipped", [False, True])
def test_what_is_done_stays_done_when_the_worker_that_looks_at_it_is_lost(
    folder: Path, skipped: bool
) -> None:
    if skipped:
        (folder / "data/full/rgb.txt").write_text("# nothing\n0.5 rgb/nowhere.png\n")
    plan = plan_of(folder, 'on_findings = "skip"')
    run_inline(plan)
    before, ledger = states(plan), [entry_of(plan, task.source.name) for task in plan.tasks]
    assert ("skipped" in before) == skipped
    assert sum(count for how, count in lose_all(plan).items() if how.startswith("kept")) == 3
    assert [entry_of(plan, task.source.name) for task in plan.tasks] == ledger
    assert states(plan) == before


def test_what_could_not_be_checked_in_full_is_told_and_stays_in_the_ledger(folder: Path) -> None:
    plan = plan_of(folder)
    run_inline(plan)
    assert lose_all(plan, full=True) == {"worked failed": 3}
    assert states(plan) == {"done": 3}
    assert run_inline(plan) == {"kept done": 3}


@pytest.mark.parametrize("how", ["the output is gone", "the worker had claimed it"])
def test_what_is_disproved_fails_when_its_worker_is_lost(
    folder: Path, how: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    plan = plan_of(folder)
    run_inline(plan)
    task = next(task for task in plan.tasks if task.source.name == "full")
    if how == "the output is gone":
        (folder / "out/full/full.mcap").unlink()
    else:
        child = subprocess.Popen([sys.executable, "-c", ""])
        owner = replace(this_process(), pid=child.pid)
        child.wait()
        claim = Claim(task.id, "theirs", 2, time.time() + 60, owner)
        monkeypatch.setattr(Loses, "claim", claim)
    assert lose_all(plan) == {"worked failed": 1, "kept done": 2}
    assert states(plan) == {"failed": 1, "done": 2}
    assert run_inline(plan, retry=True) == {"worked done": 1}


def test_a_loss_that_cannot_be_noted_is_told(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(self: Ledger, entry: Entry) -> None:
        raise OutputError("the disk is gone")

    plan = plan_of(folder)
    monkeypatch.setattr(Ledger, "write", fail)
    (outcome, *_) = run(plan, list(plan.tasks), Loses(EngineSettings()), RunOptions())
    assert outcome.entry is not None
    assert outcome.entry.reason == "lost; that could not be noted in the ledger"


def test_a_store_that_is_lost_before_the_claim_is_released_does_no_harm(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(self: LocalStore, name: str, old: bytes, new: bytes | None) -> bool:
        if new is None:
            raise OutputError("the disk is gone")
        return replace(self, name, old, new)

    replace = LocalStore.replace
    plan = plan_of(folder)
    with monkeypatch.context() as patch:
        patch.setattr(LocalStore, "replace", fail)
        assert run_inline(plan) == {"worked done": 3}
    assert states(plan) == {"done": 3}
    assert run_inline(plan) == {"kept done": 3}


def test_engines_of_others_are_found_by_their_entry_points(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    entry = EntryPoint("mine", "tumtools.batch.engines.inline:InlineEngine", "tumtools.engines")
    found = EntryPoints([entry])
    monkeypatch.setattr("tumtools.batch.engines.entry_points", lambda group: found.select(group=group))
    plan = plan_of(folder)
    outcomes = list(run(plan, list(plan.tasks), create_engine("mine", EngineSettings()), RunOptions()))
    assert {outcome.how for outcome in outcomes} == {"worked"}
    assert states(plan) == {"done": 3}
    with pytest.raises(UsageError, match="no engine 'yours'") as caught:
        create_engine("yours", EngineSettings())
    assert "mine" in str(caught.value.hint)


def raises(settings: EngineSettings) -> None:
    raise KeyError(settings.workers)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("nosuch.module:Engine", "ModuleNotFoundError: No module named"),
        ("tumtools.batch.engines.inline:NoSuch", "AttributeError"),
        ("tests.batch.test_run:raises", "KeyError: 1"),
    ],
)
def test_an_engine_of_others_that_cannot_be_started_is_theirs(
    monkeypatch: pytest.MonkeyPatch, value: str, message: str
) -> None:
    found = EntryPoints([EntryPoint("mine", value, "tumtools.engines")])
    monkeypatch.setattr("tumtools.batch.engines.entry_points", lambda group: found.select(group=group))
    with pytest.raises(UsageError, match=f"the engine mine .{value}. cannot be started: {message}"):
        create_engine("mine", EngineSettings())


class Breaks(InlineEngine):
    """Is gone after the first job."""

    def as_completed(self) -> Iterator[Completed]:
        yield next(super().as_completed())
        raise RuntimeError("out of steam")

    def shutdown(self) -> None:
        raise RuntimeError("no brakes either")


def test_an_engine_of_others_that_breaks_is_theirs_and_what_is_done_stays(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = EntryPoints([EntryPoint("mine", "tests.batch.test_run:Breaks", "tumtools.engines")])
    monkeypatch.setattr("tumtools.batch.engines.entry_points", lambda group: found.select(group=group))
    plan = plan_of(folder)
    engine = create_engine("mine", EngineSettings())
    message = "the engine mine .tests.batch.test_run:Breaks. failed: RuntimeError: out of steam"
    released: list[bool] = []
    monkeypatch.setattr("tumtools.batch.run._Runner.release", lambda _: released.append(True))
    with pytest.raises(EngineLostError, match=message):
        list(run(plan, list(plan.tasks), engine, RunOptions()))
    assert released == [True]
    assert states(plan) == {"done": 1, "pending": 2}
    assert run_inline(plan) == {"kept done": 1, "worked done": 2}


def test_engines_whose_name_is_taken_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    value = "tumtools.batch.engines.inline:InlineEngine"
    names = ("inline", "mine", "mine")
    found = EntryPoints([EntryPoint(name, value, "tumtools.engines") for name in names])
    monkeypatch.setattr("tumtools.batch.engines.entry_points", lambda group: found.select(group=group))
    told: list[str] = []
    for name in ("inline", "mine"):
        create_engine(name, EngineSettings(say=told.append))
    assert [text.partition(";")[0] for text in told] == [
        "the engine inline is that of tumtools",
        f"the engine mine is {value}",
    ]


def test_what_is_waited_for_is_said_once(folder: Path) -> None:
    plan = plan_of(folder)
    store, task = open_store(plan.destination), plan.tasks[0]
    owner = Owner("elsewhere 7", 42, 1)
    claim = Claim(task.id, "theirs", 1, time.time() + 3, owner)
    store.create(f".tumtools/claims/{task.id}.json", claim.encoded())
    told: list[str] = []
    options = RunOptions(lease=1.0, say=told.append)
    outcomes = list(run(plan, chosen(plan, options), InlineEngine(EngineSettings()), options))
    assert len(outcomes) == 3
    until = time.strftime("%H:%M:%S", time.localtime(claim.expires))
    (text,) = told
    assert text.startswith(f"waiting for {task.output}: process 42 on elsewhere works on it; ")
    assert text.endswith(f"its claim expires at {until}")


@pytest.mark.parametrize("how", ["skip", "fail"])
def test_an_older_output_of_what_is_not_converted_is_told(folder: Path, how: str) -> None:
    plan = plan_of(folder, f'on_findings = "{how}"')
    run_inline(plan)
    assert not any(standing.stale for standing in status(plan))
    (folder / "data/full/rgb.txt").write_text("# nothing\n0.5 rgb/nowhere.png\n")
    run_inline(plan)
    assert [standing.task.source.name for standing in status(plan) if standing.stale] == ["full"]
    (folder / "out/full/full.mcap").unlink()
    assert not any(standing.stale for standing in status(plan))


def test_a_catalogue_sequence_that_is_not_there_says_how_to_get_it(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TUMTOOLS_CACHE", str(folder / "cache"))
    path = folder / "manifest.toml"
    path.write_text('destination = "out"\n[[source]]\nname = "fr1/desk"\n[[target]]\nto = "mcap"\n')
    plan = make_plan(read_manifest(path))
    assert "not in the cache" in plan.tasks[0].problem
    assert run_inline(plan) == {"worked failed": 1}
    assert "tumtools fetch fr1/desk" in entry_of(plan, "rgbd_dataset_freiburg1_desk").reason


def test_a_full_run_does_again_what_is_damaged_behind_its_size_and_time(folder: Path) -> None:
    plan = plan_of(folder)
    run_inline(plan)
    output = folder / "out/full/full.mcap"
    before, stat = output.read_bytes(), output.stat()
    output.write_bytes(before[:100] + b"X" + before[101:])
    os.utime(output, ns=(stat.st_atime_ns, stat.st_mtime_ns))
    assert run_inline(plan) == {"kept done": 3}
    (changed,) = [standing for standing in status(plan, full=True) if standing.state == "changed"]
    assert changed.changed == "the output has other bytes than the ledger says"
    assert run_inline(plan, full=True) == {"worked done": 1, "kept done": 2}
    assert output.read_bytes() == before


@pytest.mark.parametrize("change", ["image", "image gone", "folder gone"])
def test_a_folder_that_was_altered_is_made_anew(folder: Path, change: str) -> None:
    plan = plan_of(folder, targets='[[target]]\nto = "tum"\n')
    run_inline(plan)
    output = folder / "out/full/full.tum"
    before = {path.name: path.read_bytes() for path in output.rglob("*") if path.is_file()}
    image = next((output / "rgb").iterdir())
    if change == "image":
        image.write_bytes(b"x")
    elif change == "image gone":
        image.unlink()
    else:
        shutil.rmtree(output)
    assert run_inline(plan) == {"worked done": 1, "kept done": 2}
    assert {path.name: path.read_bytes() for path in output.rglob("*") if path.is_file()} == before


@pytest.mark.parametrize("change", ["notes", "list gone"])
def test_files_that_may_be_somebody_elses_are_not_removed(folder: Path, change: str) -> None:
    plan = plan_of(folder, targets='[[target]]\nto = "tum"\n')
    run_inline(plan)
    output = folder / "out/full/full.tum"
    if change == "notes":
        (output / "notes.txt").write_text("mine")
    else:
        (output / "rgb.txt").unlink()  # now nothing tells that the images are the sequence's
    before = sorted(output.rglob("*"))
    assert run_inline(plan) == {"worked failed": 1, "kept done": 2}
    assert "is no part of its sequence" in entry_of(plan, "full").reason
    assert sorted(output.rglob("*")) == before
    shutil.rmtree(output)
    assert run_inline(plan, retry=True) == {"worked done": 1}


@pytest.mark.parametrize(
    "content",
    [
        "",
        "{",
        "[]",
        "null",
        "7",
        '{"schema_version": 1}',
        '{"schema_version": []}',
        "\x00" * 100,
        "[" * 10**5,
    ],
)
def test_an_entry_that_is_damaged_is_none(folder: Path, content: str) -> None:
    plan = plan_of(folder)
    run_inline(plan)
    next((folder / "out/.tumtools/ledger").glob(f"*/{plan.tasks[0].id}.json")).write_text(content)
    assert states(plan) == {"done": 2, "pending": 1}
    assert run_inline(plan) == {"worked done": 1, "kept done": 2}


@pytest.mark.parametrize("value", [None, 7, "x", [], {}, [7], {"bytes": "x"}, float("nan"), 10**400, True])
def test_an_entry_with_a_wrong_type_anywhere_is_none(folder: Path, value: object) -> None:
    plan = plan_of(folder)
    run_inline(plan)
    path = next((folder / "out/.tumtools/ledger").glob(f"*/{plan.tasks[0].id}.json"))
    good = json.loads(path.read_text())
    for key in good:
        path.write_text(json.dumps(good | {key: value}))
        found = states(plan)
        assert found in ({"done": 2, "pending": 1}, {"done": 3}, {"done": 2, "changed": 1}), key
    path.write_text(json.dumps(good | {"state": value, "started": value, "versions": value}))
    assert run_inline(plan) == {"worked done": 1, "kept done": 2}


def test_a_destination_that_is_a_file_is_one_error(folder: Path) -> None:
    plan = plan_of(folder)
    (folder / "out").write_text("a file")
    with pytest.raises(OutputError, match="the destination cannot be written to"):
        run_inline(plan)


def test_a_link_made_after_the_plan_does_not_lead_to_the_source(folder: Path) -> None:
    path = folder / "manifest.toml"
    path.write_text(
        'destination = "out"\ntemplate = "{name}"\n[[source]]\npath = "data/*"\n'
        '[[target]]\nto = "tum"\nevery = 2\n'
    )
    plan = make_plan(read_manifest(path))
    (folder / "out").symlink_to("data")
    before = sorted(file.name for file in (folder / "data").rglob("*.png"))
    assert run_inline(plan) == {"worked failed": 3}
    assert "in the way of its source" in entry_of(plan, "full").reason
    assert sorted(file.name for file in (folder / "data").rglob("*.png")) == before


def test_what_was_lost_is_added_up_for_each_target(folder: Path) -> None:
    for name in ("full", "early"):
        (folder / "data" / name / "notes.txt").write_text("of the day\n")
    plan = plan_of(folder, targets='[[target]]\nto = "mcap"\n[[target]]\nto = "rawlog"\n')
    run_inline(plan)
    losses = sum_up((standing.task, standing.entry) for standing in status(plan))
    found = {(one.target, one.outputs): one.loss.count for one in losses if "notes.txt" in one.loss.stream}
    assert found == {
        ("mcap", ("early/early.mcap", "full/full.mcap")): 2,
        ("rawlog", ("early/early.rawlog", "full/full.rawlog")): 2,
    }


def test_another_manifest_after_the_plan_changes_nothing_until_the_next_plan(folder: Path) -> None:
    plan = plan_of(folder)
    run_inline(plan)
    other = plan_of(folder, targets='[[target]]\nto = "mcap"\nevery = 2\n')
    assert run_inline(plan) == {"kept done": 3}
    assert states(other) == {"pending": 3}
    assert run_inline(other) == {"worked done": 3}
    assert states(plan) == {"changed": 3}


def test_a_task_without_threads_has_no_bug(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise RuntimeError("can't start new thread")

    plan = plan_of(folder)
    monkeypatch.setattr("tumtools.batch.task.convert", fail)
    assert run_inline(plan) == {"worked failed": 3}
    entry = entry_of(plan, "full")
    assert (entry.bug, "--memory-limit" in entry.reason, "Traceback" in entry.reason) == (False, True, False)


def test_two_runs_at_once_share_the_work(folder: Path) -> None:
    for number in range(6):
        shutil.copytree(FIXTURES / "early", folder / "data" / f"early_{number}")
    plan, found = plan_of(folder), []
    threads = [threading.Thread(target=lambda: found.append(run_inline(plan))) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sum(counts.get("worked done", 0) for counts in found) == 9
    assert [sum(counts.values()) for counts in found] == [9, 9]
    assert {entry_of(plan, task.source.name).attempts for task in plan.tasks} == {1}


def test_the_address_of_a_scheduler_is_for_dask() -> None:
    for name in ("local", "inline"):
        with pytest.raises(UsageError, match="--address"):
            create_engine(name, EngineSettings(address="tcp://127.0.0.1:1"))
