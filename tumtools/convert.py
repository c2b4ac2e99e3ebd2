# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Convert: open, transform, write to a staging place, verify, rename; and the report of what was lost."""

from __future__ import annotations

import os
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

from tumtools.errors import InputError, InternalError, LossRefusedError, UsageError
from tumtools.fingerprint import Recorded
from tumtools.formats import registry
from tumtools.formats.options import Needs, Plan, Progress, ReadOptions, WriteOptions, no_progress
from tumtools.images.parallel import batch_of, ordered_map
from tumtools.model.sequence import STREAMS, streams_of, sum_losses
from tumtools.replaceable import refuse_irreplaceable
from tumtools.staging import refuse_existing, staged
from tumtools.transform import (
    RescaledDepth,
    Selection,
    demosaiced,
    rescale_depth,
    select,
    transform_losses,
    without,
)
from tumtools.verify import verify

if TYPE_CHECKING:
    from pathlib import Path

    from tumtools.model.sequence import Loss, Sequence

_WHOLE: Final = "counted in the whole source: "
"""Stands before the reason of a loss where only a part of the source is converted."""


@dataclass(frozen=True, slots=True)
class Report:
    """What a conversion did, or would do.

    Attributes:
        target: The file or folder.
        format: Its format.
        frames: Images that the target holds.
        rows: Rows of the signals that it holds.
        nbytes: Size of the target; estimated for a dry run.
        losses: Everything that was changed or dropped.
        warnings: What was assumed; those of the source are in its header.
        verified: Whether the result was read back and compared.
        dry_run: Whether nothing was written.
        left_out: Streams that are not in the target because the options say so.
        left_out_frames: Images of the other streams that are not, for the same reason.
        left_out_rows: Rows of the other signals that are not.

    """

    target: Path
    format: str
    frames: int
    rows: int
    nbytes: int
    losses: tuple[Loss, ...]
    warnings: tuple[str, ...]
    verified: bool
    dry_run: bool = False
    left_out: tuple[str, ...] = ()
    left_out_frames: int = 0
    left_out_rows: int = 0


@dataclass(frozen=True, slots=True)
class ConvertOptions:
    """How to convert, apart from the options of the formats.

    Attributes:
        selection: What to keep.
        strict: Refuse to lose anything.
        verify: Read the result back and compare it before it gets its name.
        force: Replace the target, if it is an older result (see `replaceable`).
        dry_run: Write nothing; tell what would be written and lost.
        digest: Keep a digest of what is written in the target; None where the target can hold it.

    """

    selection: Selection = field(default_factory=Selection)
    strict: bool = False
    verify: bool = True
    force: bool = False
    dry_run: bool = False
    digest: bool | None = None


def default_target(source: Path, to: str) -> Path:
    """Return a name beside the source for its conversion."""
    target = registry.get(to)
    # Where the user sees it, not what a link leads to.
    path = source.resolve() if source.name == ".." else source.absolute()
    stem = path.name
    for suffix in registry.CONTAINER_SUFFIXES:
        if path.is_file() and stem.endswith(suffix):
            stem = stem.removesuffix(suffix)
    name = f"{stem}{target.suffix}"
    if path.parent / name == path or (not target.suffix and (path.parent / name).exists()):
        name = f"{stem}_{to}{target.suffix}"
    return path.parent / name


def convert(
    sequence: Sequence,
    target: Path,
    to: str,
    write_options: WriteOptions | None = None,
    options: ConvertOptions | None = None,
    *,
    progress: Progress = no_progress,
    verify_progress: Progress = no_progress,
) -> Report:
    """Write a sequence in another format.

    Args:
        sequence: Opened with `tumtools.sources.open_source`; stays open.
        target: The file or folder to make.
        to: Name of the format.
        write_options: Options of the format.
        options: Options of the conversion.
        progress: Told of each image written.
        verify_progress: Told of each image verified.

    Raises:
        UsageError: The options do not fit the format, or the target exists.
        LossRefusedError: `strict`, and something would be lost; nothing is left behind.
        InputError: The source is damaged or has no stream; nothing is left behind.
        OutputError: The target cannot be written; nothing is left behind.
        InternalError: The result differs from the source without a loss being reported, or is unreadable.

    """
    write_options, options = write_options or WriteOptions(), options or ConvertOptions()
    entry = registry.get(to)
    registry.check_options(entry, write_options)
    registry.check_target(entry, target)
    needs = entry.writer.needs(write_options)
    keep_digest = needs.keeps_digest if options.digest is None else options.digest
    if keep_digest and not needs.keeps_digest:
        shown = to if write_options.dialect is None else f"{to} --dialect {write_options.dialect}"
        raise UsageError(f"--digest has no meaning for {shown}, which cannot hold one", hint="leave it out")
    _refuse_no_streams(sequence)
    prepared = prepare(sequence, options.selection, needs)
    _refuse_nothing(prepared, options.selection)
    plan = entry.writer.plan(prepared, target, write_options)
    not_carried = _of_streams(sequence, options.selection, needs.drops)
    report = Report(
        target=target,
        format=to,
        frames=sum(_frames(prepared).values()) if plan.frames is None else plan.frames,
        rows=sum(_rows(prepared).values()) if plan.rows is None else plan.rows,
        nbytes=plan.nbytes,
        losses=_merge(not_carried, plan.losses),
        warnings=plan.warnings,
        verified=False,
        left_out=tuple(name for name in streams_of(sequence) if name not in streams_of(prepared)),
        left_out_frames=_less(_frames(sequence), _frames(prepared)),
        left_out_rows=_less(_rows(sequence), _rows(prepared)),
    )
    refuse_existing(target, force=options.force)
    if options.force:
        refuse_irreplaceable(target, entry)
    if options.dry_run:
        report = _dry_run(prepared, plan, report, write_options.jobs, progress)
        if options.strict:
            _refuse(report.losses, target)
        return report
    if options.strict:
        _refuse(report.losses, target)
    with staged(target, force=options.force) as path:
        recorded = None
        if options.verify or keep_digest:
            recorded = Recorded(prepared, needs, keep_digest=keep_digest, keep_fingerprints=options.verify)
        written = entry.writer.write(recorded or prepared, path, write_options, progress)
        losses = _merge(not_carried, written, transform_losses(prepared))
        if options.strict:
            _refuse(losses, target)
        if recorded is not None and options.verify:
            try:
                with entry.reader.open(path, ReadOptions()) as result:
                    verify(
                        recorded,
                        result,
                        written,
                        write_options,
                        keeps_name=entry.keeps_name,
                        jobs=write_options.jobs,
                        progress=verify_progress,
                    )
            except InputError as error:
                raise InternalError(
                    f"verification failed: what was written cannot be read: {error}"
                ) from error
        size = _size(path)
    return replace(report, losses=losses, nbytes=size, verified=options.verify)


def prepare(sequence: Sequence, selection: Selection, needs: Needs) -> Sequence:
    """Return what a writer with these needs is given."""
    prepared = select(sequence, selection)
    if needs.drops:
        prepared = without(prepared, needs.drops)
    prepared = demosaiced(prepared)
    return rescale_depth(prepared, needs.depth_units_per_metre, needs.float_depth_units_per_metre)


def _dry_run(prepared: Sequence, plan: Plan, report: Report, jobs: int, progress: Progress) -> Report:
    """Find out what would be lost; only depth that is rescaled and written needs to be looked at."""
    next(prepared.images(), None)  # finds out whether any are missing
    if isinstance(prepared, RescaledDepth):
        rows = plan.images.get("depth")
        frames = (frame for frame in prepared.images(["depth"]) if rows is None or frame.row in rows)
        for nbytes in ordered_map(lambda frame: frame.load().nbytes, frames, jobs, batch=batch_of(prepared)):
            progress(1, nbytes)
    return replace(report, losses=_merge(report.losses, transform_losses(prepared)), dry_run=True)


def _of_streams(sequence: Sequence, selection: Selection, drops: frozenset[str]) -> tuple[Loss, ...]:
    """Return what the reader could not carry, but for streams that are not asked for: these are no loss.

    The reader counts all that it meets; which of it lies within the times chosen is not known, and said.
    """
    info = sequence.info
    places = {**info.sources, **{stream: image.source for stream, image in info.images.items()}}
    unwanted = {name for name in STREAMS if not selection.has(name) or name in drops}
    unwanted |= {place for stream, place in places.items() if stream in unwanted and place}
    unwanted -= {place for stream, place in places.items() if stream not in unwanted and place}
    losses = tuple(loss for loss in info.not_carried if loss.stream not in unwanted)
    if selection.keeps_all_rows:
        return losses
    return tuple(replace(loss, why=f"{_WHOLE}{loss.why}") for loss in losses)


def _refuse_no_streams(sequence: Sequence) -> None:
    """Refuse a recording of something else, or one with nothing readable before its damage."""
    if not sequence.info.images and sequence.groundtruth is None and sequence.accelerometer is None:
        raise InputError(
            "there is nothing to convert: no images, ground truth or accelerations were found in it",
            path=sequence.info.name,
            hint="`tumtools info` shows what there is; --topic STREAM=TOPIC chooses a topic of a recording",
        )


def _refuse_nothing(prepared: Sequence, selection: Selection) -> None:
    signals = (prepared.groundtruth, prepared.accelerometer)
    rows = [info.count for info in prepared.info.images.values()] + [len(s) for s in signals if s is not None]
    if not selection.keeps_all and not any(rows):
        raise UsageError(
            "nothing of the sequence lies within the streams and times chosen",
            path=prepared.info.name,
            hint="`tumtools info` shows what there is",
        )


def refuse_source(source: Path, target: Path) -> None:
    """Refuse a target that is the source, or a folder around it: `force` would remove what is read.

    Raises:
        UsageError: It is.

    """
    place, goal = source.resolve(), target.resolve()
    if goal == place or goal in place.parents:
        what = "is the source" if goal == place else f"holds the source {source}"
        raise UsageError(f"the target {what}", path=target, hint="name another one")


def _frames(sequence: Sequence) -> dict[str, int]:
    return {stream: info.count for stream, info in sequence.info.images.items()}


def _rows(sequence: Sequence) -> dict[str, int]:
    signals = {"groundtruth": sequence.groundtruth, "accelerometer": sequence.accelerometer}
    return {name: len(signal) for name, signal in signals.items() if signal is not None}


def _less(before: dict[str, int], after: dict[str, int]) -> int:
    """Return how many fewer there are of the streams that are still there."""
    return sum(before[stream] - count for stream, count in after.items())


def _merge(*groups: tuple[Loss, ...]) -> tuple[Loss, ...]:
    """Join losses in a stable order; what two groups tell is told once, what one tells twice is added."""
    return tuple(dict.fromkeys(loss for group in groups for loss in sum_losses(group)))


def _refuse(losses: tuple[Loss, ...], target: Path) -> None:
    if losses:
        first = losses[0]
        more = f", and {len(losses) - 1} more" if len(losses) > 1 else ""
        raise LossRefusedError(
            f"--strict: {first.stream}: {first.what} ({first.why}){more}; nothing was written",
            path=target,
            hint="leave --strict out to convert all the same, or look at the list with --dry-run",
        )


def _size(path: Path) -> int:
    if path.is_file():
        return path.stat().st_size
    # No Path for each of the many files, which takes longer than to ask for its size.
    folders = os.walk(path)
    return sum(os.stat(f"{folder}/{name}").st_size for folder, _, names in folders for name in names)  # noqa: PTH116 - as said
