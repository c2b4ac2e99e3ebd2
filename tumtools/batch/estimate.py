# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What a task will read, write and lose, as far as it can be told without looking at pixels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from tumtools.batch.expand import CATALOGUE
from tumtools.batch.places import is_remote
from tumtools.convert import prepare
from tumtools.errors import TumtoolsError
from tumtools.formats import registry
from tumtools.formats.options import ReadOptions, WriteOptions
from tumtools.sources import locate, open_source
from tumtools.transform import RescaledDepth, parse_selection

if TYPE_CHECKING:
    from pathlib import Path

    from tumtools.batch.expand import Source
    from tumtools.batch.manifest import Target
    from tumtools.model.sequence import Sequence


@dataclass(frozen=True, slots=True)
class Estimate:
    """What is expected of a task; see `plan.Task`."""

    bytes_in: int = 0
    bytes_out: int = 0
    losses: tuple[str, ...] = ()
    problem: str = ""


def estimate(source: Source, targets: tuple[Target, ...], how: str) -> list[Estimate]:
    """Return an estimate for each target.

    Args:
        source: The recording; those of a store are not looked at.
        targets: What it becomes.
        how: `open` it, look at its `size` only, or `off`.

    """
    if how == "off" or is_remote(source.uri):
        return [Estimate()] * len(targets)
    try:
        path = locate(source.uri.removeprefix(CATALOGUE))
        bytes_in = _size(path)
        if how == "size":
            return [Estimate(bytes_in, bytes_in)] * len(targets)
        with open_source(path, ReadOptions(source.topics, source.salvage)) as sequence:
            return [_of_target(sequence, target, bytes_in) for target in targets]
    except TumtoolsError as error:
        return [Estimate(problem=str(error).partition("\n")[0])] * len(targets)


def _of_target(sequence: Sequence, target: Target, bytes_in: int) -> Estimate:
    writer = registry.get(target.to).writer
    options = WriteOptions(**target.write)  # type: ignore[arg-type]  # the manifest has checked the types
    try:
        selection = parse_selection(sequence, target.start, target.end, target.every, target.streams)
        prepared = prepare(sequence, selection, writer.needs(options))
        plan = writer.plan(prepared, options)
    except TumtoolsError as error:
        return Estimate(bytes_in, problem=str(error).partition("\n")[0])
    losses = [f"{loss.stream}: {loss.what}" for loss in (*sequence.info.not_carried, *plan.losses)]
    if isinstance(prepared, RescaledDepth):
        losses.append("depth: other units; what that loses is measured in the run")
    return Estimate(bytes_in, plan.nbytes, tuple(dict.fromkeys(losses)))


def _size(path: Path) -> int:
    if path.is_dir():
        return sum(file.stat().st_size for file in path.rglob("*") if file.is_file())
    return path.stat().st_size
