# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Plans as JSON: a task a line, so that plans can be compared, and nothing that changes with the day."""

from __future__ import annotations

import json
import os
from dataclasses import asdict, dataclass, fields
from typing import TYPE_CHECKING, Final

from tumtools.batch.expand import Source
from tumtools.batch.manifest import Policy, Target  # noqa: TC001 - types of fields are looked at
from tumtools.batch.places import check_place
from tumtools.batch.plan import Plan, Task, is_output_name, task_id
from tumtools.batch.plan_head import is_plan_file
from tumtools.batch.records import build, load
from tumtools.errors import InputError, MissingInputError, OutputError, UsageError
from tumtools.staging import refuse_folder, staged_file

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

SCHEMA_VERSION: Final = 1
_SOURCE_DEFAULTS: Final = {item.name: item.default for item in fields(Source)} | {"topics": {}}
_TASK_DEFAULTS: Final = {item.name: item.default for item in fields(Task)}
_HINT: Final = "make it anew with `tumtools batch plan`"


def write_plan(plan: Plan, path: Path) -> None:
    """Write a plan, in place of an older one.

    Raises:
        UsageError: There is a folder, or a file that is no plan.
        OutputError: It cannot be written.

    """
    _refuse_foreign(path)
    head = {
        "schema_version": SCHEMA_VERSION,
        "plan": plan.id,
        "destination": plan.destination,
        "policy": asdict(plan.policy),
        "targets": [asdict(target) for target in plan.targets],
        "opened": plan.opened,
    }
    with staged_file(path, force=True) as place, place.open("w", encoding="utf-8") as file:
        file.write(json.dumps(head, indent=1)[:-2] + ',\n "tasks": [')
        for number, task in enumerate(plan.tasks):
            file.write((",\n" if number else "\n") + json.dumps(_task_table(task), separators=(",", ":")))
        file.write("\n]}\n")


def _refuse_foreign(path: Path) -> None:
    """Refuse to replace anything but an older plan, such as the manifest or a folder of recordings."""
    refuse_folder(path)
    try:
        if not os.path.lexists(path):
            return
        if path.is_file() and (path.stat().st_size == 0 or is_plan_file(path)):
            return
    except OSError as error:
        raise OutputError(f"cannot be read: {error.strerror}", path=path) from error
    raise UsageError(
        "what is there is no plan; it is not replaced", path=path, hint="name another file for the plan"
    )


def _task_table(task: Task) -> dict[str, object]:
    """Return a task without what is as usual."""
    source = {
        name: getattr(task.source, name)
        for name, default in _SOURCE_DEFAULTS.items()
        if getattr(task.source, name) != default
    }
    table: dict[str, object] = {
        "id": task.id,
        "source": source,
        "target": task.target.label,
        "output": task.output,
    }
    for name in ("bytes_in", "bytes_out", "losses", "problem"):
        if getattr(task, name) != _TASK_DEFAULTS[name]:
            table[name] = getattr(task, name)
    return table


def read_plan(path: Path) -> Plan:
    """Read a plan and check that its tasks are what their ids say.

    Raises:
        MissingInputError: There is no such file.
        InputError: It is not a plan, of another version, or has been changed.

    """
    try:
        document = load(path.read_bytes())
    except FileNotFoundError:
        raise MissingInputError(
            "there is no such plan", path=path, hint="`tumtools batch plan MANIFEST -o PLAN` makes one"
        ) from None
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", path=path) from error
    except ValueError as error:
        raise InputError(f"no JSON object: {error}", path=path, hint=_HINT) from error
    version = document.get("schema_version")
    if version != SCHEMA_VERSION:
        found = f"this is of version {json.dumps(version)[:40]}" if version is not None else "this is none"
        raise InputError(f"expected a plan of version {SCHEMA_VERSION}, {found}", path=path, hint=_HINT)
    try:
        plan = _plan(document)
    except ValueError as error:
        raise InputError(f"not a plan: {error}", path=path, hint=_HINT) from error
    for number, task in enumerate(plan.tasks):
        if not is_output_name(task.output) or task.id != task_id(
            task.source, task.target, task.output, plan.policy
        ):
            raise InputError(
                "the task is not what its id says; plans are not edited",
                path=path,
                location=f"tasks[{number}]",
                hint="change the manifest and plan again",
            )
    if document.get("plan") != plan.id:
        raise InputError(
            "the destination, the policy, a target or a task was changed; plans are not edited",
            path=path,
            hint=_HINT,
        )
    return plan


@dataclass(frozen=True, slots=True)
class _Head:
    """A plan but for its tasks, as it is written."""

    schema_version: int
    plan: str
    destination: str
    policy: Policy
    targets: tuple[Target, ...]
    opened: int


@dataclass(frozen=True, slots=True)
class _TaskTable:
    """A task as it is written; see `plan.Task`."""

    id: str
    source: Source
    target: str
    output: str
    bytes_in: int = 0
    bytes_out: int = 0
    losses: tuple[str, ...] = ()
    problem: str = ""


def _plan(document: Mapping[str, object]) -> Plan:
    head = build(_Head, {key: value for key, value in document.items() if key != "tasks"})
    problem = check_place(head.destination)
    if problem:
        raise ValueError(problem)
    tables = document.get("tasks")
    if not isinstance(tables, list):
        message = "tasks: expected a list"
        raise ValueError(message)  # noqa: TRY004 - what was read is wrong, not the caller
    targets = {target.label: target for target in head.targets}
    sources: dict[str, Source] = {}  # one object for all tasks of a source: a third of the memory
    return Plan(
        destination=head.destination,
        policy=head.policy,
        targets=head.targets,
        tasks=tuple(_task(table, targets, sources) for table in tables),
        opened=head.opened,
    )


def _task(document: object, targets: Mapping[str, Target], sources: dict[str, Source]) -> Task:
    table = build(_TaskTable, document)
    if table.target not in targets:
        message = f"task {table.output}: no target {table.target!r}"
        raise ValueError(message)
    source = sources.setdefault(repr(table.source), table.source)
    values = {item.name: getattr(table, item.name) for item in fields(_TaskTable)}
    return Task(**{**values, "source": source, "target": targets[table.target]})
