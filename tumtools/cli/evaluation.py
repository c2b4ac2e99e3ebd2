# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What the commands that measure share: the trajectories they read, the files they write."""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from tumtools.cli import output
from tumtools.errors import InputError, TumtoolsError, UsageError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tumtools.model.signals import Trajectory


def hole(interpolate: bool, max_hole: int | None) -> int | None:
    """Return the longest hole to interpolate across, ns, or None for no interpolation."""
    from tumtools.evaluate.interpolate import MAX_HOLE

    if max_hole is not None and not interpolate:
        raise UsageError("--max-hole is for --interpolate")
    return (max_hole or MAX_HOLE) if interpolate else None


def read_trajectory(
    source: str, topic: str | None = None, option: str = "--topic", *, positions_do: bool = False
) -> Trajectory:
    """Read the poses of any source.

    Args:
        source: A path in any format, or a name.
        topic: Of a recording, if it has several with poses.
        option: With which the command takes the topic, without a stream.
        positions_do: Take text files of positions without rotations too.

    Raises:
        InputError: It cannot be read, or holds no poses.
        UsageError: Several topics have poses.

    """
    from tumtools.evaluate.rows import read_positions
    from tumtools.formats.options import ReadOptions
    from tumtools.sources import open_source

    positions = read_positions(source) if positions_do else None
    if positions is not None:
        return positions
    try:
        with open_source(
            source, ReadOptions({"groundtruth": topic} if topic else {}, streams=frozenset({"groundtruth"}))
        ) as sequence:
            trajectory = sequence.groundtruth
    except TumtoolsError as error:
        # Other commands take the topics of several streams.
        error.message = error.message.replace("--topic groundtruth=", f"{option} ")
        error.hint = error.hint and error.hint.replace("--topic groundtruth=", f"{option} ")
        raise
    if trajectory is None:
        raise InputError(
            "there is no trajectory in it",
            path=source,
            hint="name a trajectory file, or a topic that has poses",
        )
    return trajectory


def read_pair(
    groundtruth: tuple[str, str | None], estimate: tuple[str, str | None], *, positions_do: tuple[bool, bool]
) -> tuple[Trajectory, Trajectory]:
    """Read what is compared, and warn if it looks as if it were named in the wrong order.

    Args:
        groundtruth: Source and topic.
        estimate: Source and topic.
        positions_do: For each of them, whether positions without rotations do.

    """
    from tumtools.evaluate.summary import stream_statistics

    true = read_trajectory(*groundtruth, "--groundtruth-topic", positions_do=positions_do[0])
    judged = read_trajectory(*estimate, "--estimate-topic", positions_do=positions_do[1])
    rates = [stream_statistics(each.stamps).median_rate for each in (true, judged)]
    if rates[0] and rates[1] and rates[1] > 2.0 * rates[0]:
        output.warning(
            f"the estimate has {rates[1]:.1f} poses a second, the ground truth {rates[0]:.1f}: "
            "if they are the other way round, name the ground truth first"
        )
    return true, judged


@contextmanager
def measuring(groundtruth: str, estimate: str) -> Iterator[None]:
    """Name the files in errors of what is measured."""
    try:
        yield
    except InputError as error:
        error.path = error.path or f"{estimate} against {groundtruth}"
        raise


def write_text(path: str, text: str, *, force: bool) -> None:
    """Write a result to a file."""
    from tumtools.staging import staged_file

    with staged_file(Path(path), force=force) as target:
        target.write_text(text, encoding="utf-8")


def one_output(**flags: object) -> None:
    """Refuse two ways to print the same thing."""
    chosen = [f"--{name.replace('_', '-')}" for name, value in flags.items() if value]
    if len(chosen) > 1:
        raise UsageError(f"{' and '.join(chosen)} cannot be had together")


def without_effect(context: click.Context, names: tuple[str, ...], where: str) -> None:
    """Refuse options that would have no effect."""
    for name in names:
        if context.get_parameter_source(name) is click.core.ParameterSource.COMMANDLINE:
            raise UsageError(f"--{name.replace('_', '-')} has no effect {where}")


def different_files(*paths: str | None) -> None:
    """Refuse to write two results to the same file."""
    given = [path for path in paths if path]
    for path in given:
        if given.count(path) > 1:
            raise UsageError("two results cannot be written to the same file", path=path)


def print_notes(notes: tuple[str, ...]) -> None:
    """Warn of what the user should know."""
    for note in notes:
        output.warning(note)
