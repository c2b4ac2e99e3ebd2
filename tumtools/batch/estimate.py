# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What a task will read, write and lose, as far as it can be told without looking at pixels."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from tumtools.batch.expand import CATALOGUE
from tumtools.batch.places import is_remote
from tumtools.catalogue import load_catalogue
from tumtools.catalogue.entry import RECORDINGS
from tumtools.convert import prepare
from tumtools.errors import MissingInputError, TumtoolsError
from tumtools.formats import registry
from tumtools.formats.options import ReadOptions
from tumtools.sources import locate, open_source
from tumtools.transform import RescaledDepth, parse_selection

if TYPE_CHECKING:
    from collections.abc import Iterator

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


MOST_OPENED: Final = 200
"""Sources that `auto` opens: 10 to 300 ms each, so that a plan of any size is made in a minute or so."""


@dataclass(frozen=True, slots=True)
class Estimates:
    """What is expected of all tasks.

    Attributes:
        each: For each source, an estimate for each target.
        opened: How many sources were opened for it.

    """

    each: Iterator[list[Estimate]]
    opened: int


def estimate(sources: list[Source], targets: tuple[Target, ...], how: str) -> Estimates:
    """Return an estimate for each source and target.

    Args:
        sources: The recordings; those of a store are not opened, and their sizes are those of its listing.
        targets: What they become.
        how: `open` each, look at its `size` only, or `off`; `auto` opens at most `MOST_OPENED`, evenly
            spread, and takes sizes of the others' outputs in proportion.

    """
    local = [number for number, source in enumerate(sources) if not is_remote(source.uri)]
    opened: dict[int, list[Estimate]] = {}
    if how in {"auto", "open"}:
        step = max(1, -(-len(local) // MOST_OPENED)) if how == "auto" else 1
        opened = {number: _opened(sources[number], targets) for number in local[::step]}
    growth = _growth(list(opened.values()), len(targets))

    def rest(source: Source) -> list[Estimate]:
        return [Estimate()] * len(targets) if how == "off" else _of_size(source, growth)

    each = (opened[number] if number in opened else rest(source) for number, source in enumerate(sources))
    return Estimates(each, len(opened))


def _growth(opened: list[list[Estimate]], targets: int) -> list[float]:
    """Return how much larger than its source an output is, for each target; 1 where none was opened."""
    growth = []
    for target in range(targets):
        known = [estimates[target] for estimates in opened if not estimates[target].problem]
        bytes_in = sum(estimate.bytes_in for estimate in known)
        growth.append(sum(estimate.bytes_out for estimate in known) / bytes_in if bytes_in else 1.0)
    return growth


def _of_size(source: Source, growth: list[float]) -> list[Estimate]:
    try:
        bytes_in = (
            source.listed_bytes
            if is_remote(source.uri)
            else _size(locate(source.uri.removeprefix(CATALOGUE)))
        )
    except (TumtoolsError, OSError) as error:
        return [_unknown(source, error)] * len(growth)
    return [Estimate(bytes_in, round(bytes_in * factor)) for factor in growth]


def _opened(source: Source, targets: tuple[Target, ...]) -> list[Estimate]:
    try:
        path = locate(source.uri.removeprefix(CATALOGUE))
        bytes_in = _size(path)
        with open_source(path, ReadOptions(source.topics, source.salvage)) as sequence:
            return [_of_target(sequence, target, bytes_in) for target in targets]
    except (TumtoolsError, OSError) as error:
        return [_unknown(source, error)] * len(targets)


def _unknown(source: Source, error: Exception) -> Estimate:
    """Say why a source cannot be looked at; one that will be fetched is no problem."""
    text = str(error).replace("\n  hint: ", "; ")
    if isinstance(error, MissingInputError) and source.uri.startswith(CATALOGUE):
        if source.fetch:
            return Estimate(bytes_in=_size_to_fetch(source.uri.removeprefix(CATALOGUE)))
        text += ", and so does `fetch = true` in its [[source]]"
    return Estimate(problem=text)


def _size_to_fetch(name: str) -> int:
    entry = load_catalogue().find(name)
    files = entry.files if entry is not None else {}
    kind = next((kind for kind in RECORDINGS if kind in files), None)
    return (files[kind].bytes or 0) if kind else 0


def _of_target(sequence: Sequence, target: Target, bytes_in: int) -> Estimate:
    writer = registry.get(target.to).writer
    options = target.write_options()
    try:
        selection = parse_selection(sequence, target.start, target.end, target.every, target.streams)
        prepared = prepare(sequence, selection, writer.needs(options))
        plan = writer.plan(prepared, Path(sequence.info.name), options)
    except TumtoolsError as error:
        return Estimate(bytes_in, problem=str(error).partition("\n")[0])
    losses = [f"{loss.stream}: {loss.what}" for loss in (*sequence.info.not_carried, *plan.losses)]
    if target.strict and losses:
        return Estimate(bytes_in, plan.nbytes, tuple(losses), f"{target.label} is strict: {losses[0]}")
    if isinstance(prepared, RescaledDepth) and prepared.is_expected:
        losses.append("depth: other units; what that loses is measured in the run")
    return Estimate(bytes_in, plan.nbytes, tuple(dict.fromkeys(losses)))


def _size(path: Path) -> int:
    if path.is_dir():
        return sum(file.stat().st_size for file in path.rglob("*") if file.is_file())
    return path.stat().st_size
