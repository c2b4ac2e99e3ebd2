# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The plan: the tasks of a manifest, each named by a hash of what it does."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, field, fields, replace
from typing import TYPE_CHECKING, Final

from tumtools.batch.estimate import estimate
from tumtools.batch.expand import CATALOGUE, Source, expand
from tumtools.batch.places import real_place
from tumtools.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from tumtools.batch.estimate import Estimate
    from tumtools.batch.expand import Found
    from tumtools.batch.manifest import Manifest, Policy, Target

_HASH_VERSION: Final = 1
_LONGEST_NAME: Final = 200
"""Bytes; file systems take 255, of which staging needs some."""
LEDGER_FOLDER: Final = ".tumtools"
"""Below the destination; no output may have a name in it."""


@dataclass(frozen=True, slots=True)
class Task:
    """One conversion.

    Attributes:
        id: Hash of the source, the options and the output: 32 hexadecimal digits.
        source: Where it comes from.
        target: What it becomes.
        output: Name below the destination, parts separated by `/`.
        bytes_in: Size of the source, estimated; 0 if unknown.
        bytes_out: Size of the output, estimated; 0 if unknown.
        losses: What would be lost, as far as it can be told without converting.
        problem: Why the source could not be looked at; empty if it could.

    """

    id: str
    source: Source
    target: Target
    output: str
    bytes_in: int = 0
    bytes_out: int = 0
    losses: tuple[str, ...] = ()
    problem: str = ""


@dataclass(frozen=True, slots=True)
class Plan:
    """All tasks of a manifest.

    Attributes:
        destination: Absolute folder, or URL of a store.
        policy: What holds for all tasks.
        targets: As in the manifest.
        tasks: In the order of sources, then targets.
        opened: How many sources were opened to estimate sizes and losses; what the others would lose is
            not known before they are converted.

    """

    destination: str
    policy: Policy
    targets: tuple[Target, ...]
    tasks: tuple[Task, ...] = field(repr=False)
    opened: int = 0

    @property
    def id(self) -> str:
        """A hash of all that is in it."""
        head = [
            self.destination,
            asdict(self.policy),
            [asdict(target) for target in self.targets],
            self.opened,
        ]
        sha = hashlib.sha256(json.dumps(head, sort_keys=True).encode())
        for task in self.tasks:
            source = [getattr(task.source, item.name) for item in fields(Source)]
            rest = [task.id, task.target.label, task.output, task.bytes_in, task.bytes_out, task.losses]
            sha.update(json.dumps([*source, *rest, task.problem], sort_keys=True).encode())
        return sha.hexdigest()[:32]

    def shard(self, index: int, count: int) -> Plan:
        """Return the tasks of each `count`-th source from the `index`-th (1 = first) on.

        So a source is read on one machine. Where there are fewer sources than parts, each `count`-th task.
        """
        numbers: dict[str, int] = {}
        for task in self.tasks:
            numbers.setdefault(task.source.uri, len(numbers))
        if len(numbers) < count:
            return replace(self, tasks=self.tasks[index - 1 :: count])
        mine = (task for task in self.tasks if numbers[task.source.uri] % count == index - 1)
        return replace(self, tasks=tuple(mine))


def make_plan(manifest: Manifest, progress: Callable[[int], None] | None = None) -> Plan:
    """Make the plan of a manifest; the same manifest and sources give the same plan.

    Args:
        manifest: What is wanted.
        progress: Told of each source.

    Raises:
        InputError: A source does not exist, or two outputs would be in each other's way; with the line.

    """
    tasks: list[Task] = []
    found = expand(manifest)
    estimates = estimate([one.source for one in found], manifest.targets, manifest.estimate)
    for one, guesses in zip(found, estimates.each, strict=True):
        tasks.extend(_tasks(manifest, one, guesses))
        if progress is not None:
            progress(1)
    _check_outputs(manifest, tasks, [one.line for one in found for _ in manifest.targets])
    return Plan(manifest.destination, manifest.policy, manifest.targets, tuple(tasks), estimates.opened)


def _tasks(manifest: Manifest, found: Found, guesses: list[Estimate]) -> Iterator[Task]:
    source = found.source
    for target, guess in zip(manifest.targets, guesses, strict=True):
        output = _output(manifest, found, target)
        yield Task(
            id=task_id(source, target, output, manifest.policy),
            source=source,
            target=target,
            output=output,
            bytes_in=guess.bytes_in,
            bytes_out=guess.bytes_out,
            losses=guess.losses,
            problem=guess.problem,
        )


def _output(manifest: Manifest, found: Found, target: Target) -> str:
    source = found.source
    output = manifest.template.format(
        name=source.name,
        parent=source.parent,
        ext=target.ext,
        format=target.to,
        target=target.label,
        camera=source.camera or "unknown",
    )
    if not is_output_name(output):
        raise InputError(
            f"{source.uri} would be written to {output!r}, which is no name below the destination",
            path=manifest.path,
            location=f"line {found.line}",
            hint="change template, or give the source a label",
        )
    if any(len(part.encode("utf-8", "surrogateescape")) > _LONGEST_NAME for part in output.split("/")):
        raise InputError(
            f"{source.uri} would be written to {output!r}; names of more than {_LONGEST_NAME} bytes are too "
            "long for many file systems",
            path=manifest.path,
            location=f"line {found.line}",
            hint="change template, or give the source a label",
        )
    return output


def is_output_name(output: str) -> bool:
    """Whether a name stays below the destination, and out of the ledger."""
    parts = output.split("/")
    return (
        not any(part in {"", ".", ".."} for part in parts)
        and parts[0] != LEDGER_FOLDER
        and "\0" not in output
    )


def task_id(source: Source, target: Target, output: str, policy: Policy) -> str:
    """Hash what decides about the output; not the destination, so that a tree can be moved."""
    what = {
        "version": _HASH_VERSION,
        "source": source.uri,
        "topics": dict(source.topics),
        "salvage": source.salvage,
        "to": target.to,
        "write": {key: value for key, value in target.write.items() if value},
        "selection": [target.start, target.end, target.every, target.streams],
        "strict": target.strict,
        "verify": target.verify,
        "output": output,
        "validate": [policy.validate, policy.on_findings, policy.fail_on],
    }
    text = json.dumps(what, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def _check_outputs(manifest: Manifest, tasks: list[Task], lines: list[int]) -> None:
    """Refuse outputs that are the same, inside each other, or in the way of a source."""
    by_output: dict[str, Task] = {}
    for task, line in zip(tasks, lines, strict=True):
        other = by_output.setdefault(task.output, task)
        if other is not task:
            raise _clash(manifest, task, other, "the same as", line)
    for task, line in zip(tasks, lines, strict=True):
        for parent in _parents(task.output):
            if parent in by_output:
                raise _clash(manifest, task, by_output[parent], "inside of", line)
    root = real_place(manifest.destination)
    uris = {task.source.uri for task in tasks}
    sources = {real_place(uri) for uri in uris if not uri.startswith(CATALOGUE)}
    around = {parent for source in sources for parent in _parents(source)}
    inside = any(place in sources for place in (root, *_parents(root)))
    for task, line in zip(tasks, lines, strict=True):
        place = f"{root}/{task.output}"
        holders = (f"{root}/{parent}" for parent in _parents(task.output))
        if inside or place in around or place in sources or any(holder in sources for holder in holders):
            raise InputError(
                f"{place} would be in the way of a source",
                path=manifest.path,
                location=f"line {line}",
                hint="change the destination",
            )


def _parents(output: str) -> Iterator[str]:
    end = output.find("/")
    while end >= 0:
        yield output[:end]
        end = output.find("/", end + 1)


def _clash(manifest: Manifest, task: Task, other: Task, how: str, line: int) -> InputError:
    return InputError(
        f"the output {task.output} of {task.source.uri} as {task.target.label} is {how} {other.output} of "
        f"{other.source.uri} as {other.target.label}",
        path=manifest.path,
        location=f"line {line}",
        hint="tell them apart in the template with {target}, {parent} or {ext}; or label or exclude a source",
    )


def by_id(plan: Plan) -> Mapping[str, Task]:
    """Return the tasks by their id."""
    return {task.id: task for task in plan.tasks}
