# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What the commands that measure share: their options, the trajectories they read, the files they write."""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import click

from tumtools.cli import output
from tumtools.errors import InputError, TumtoolsError, UsageError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from tumtools.model.signals import Trajectory

Command = TypeVar("Command", bound="Callable[..., object]")


def seconds(text: str) -> int:
    """Read seconds from the command line as integer nanoseconds; never through a float."""
    from tumtools.model.time import parse_stamp

    try:
        return parse_stamp(text)
    except ValueError as error:
        raise click.BadParameter(str(error)) from error


def several(*decorators: Callable[[Command], Command]) -> Callable[[Command], Command]:
    """Put decorators together, the first one outermost."""

    def decorate(command: Command) -> Command:
        for decorator in reversed(decorators):
            command = decorator(command)
        return command

    return decorate


matching_options = several(
    click.option(
        "--max-difference",
        type=seconds,
        default="0.02",
        show_default=True,
        metavar="S",
        help="Poses match if their stamps differ by less.",
    ),
    click.option(
        "--method",
        type=click.Choice(["tum", "nearest", "optimal"]),
        default="tum",
        show_default=True,
        help="How to associate: as the benchmark's scripts; nearest, as evo; most pairs.",
    ),
)

time_options = several(
    click.option(
        "--offset",
        type=seconds,
        default="0",
        show_default=True,
        metavar="S",
        help="Added to the stamps of ESTIMATE.",
    ),
    click.option(
        "--scale", type=float, default=1.0, show_default=True, help="Multiplies the positions of ESTIMATE."
    ),
    click.option(
        "--interpolate", is_flag=True, help="Interpolate the ground truth at the stamps of ESTIMATE."
    ),
    click.option(
        "--max-hole",
        type=seconds,
        metavar="S",
        help="Do not interpolate between poses farther apart.  [default: 0.1]",
    ),
)

pair_arguments = several(
    click.argument("groundtruth"),
    click.argument("estimate"),
    click.option("--groundtruth-topic", metavar="TOPIC", help="Topic of GROUNDTRUTH, if it is a recording."),
    click.option("--estimate-topic", metavar="TOPIC", help="Topic of ESTIMATE, if it is a recording."),
)

file_options = several(
    click.option("--plot", "picture", metavar="FILE", help="Draw a picture: .svg, .png or .pdf."),
    click.option(
        "--tum-output", is_flag=True, help="Print what the benchmark's script prints with --verbose."
    ),
    click.option("--force", is_flag=True, help="Replace files that exist."),
)


def hole(interpolate: bool, max_hole: int | None) -> int | None:
    """Return the longest hole to interpolate across, ns, or None for no interpolation."""
    from tumtools.evaluate.interpolate import MAX_HOLE

    if max_hole is not None and not interpolate:
        raise UsageError("--max-hole is for --interpolate")
    return (max_hole or MAX_HOLE) if interpolate else None


def read_trajectory(
    source: str, topic: str | None = None, option: str | None = None, *, positions_do: bool = False
) -> Trajectory:
    """Read the poses of any source.

    Args:
        source: A path in any format, or a name.
        topic: Of a recording, if it has several with poses.
        option: With which the command takes the topic, if not with --topic.
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
        with open_source(source, ReadOptions(topics={"groundtruth": topic} if topic else {})) as sequence:
            trajectory = sequence.groundtruth
    except TumtoolsError as error:
        if option and error.hint and "--topic" in error.hint:
            error.hint = f"choose one with {option}"
        raise
    if trajectory is None:
        raise InputError(
            "there is no trajectory in it",
            path=source,
            hint="name a trajectory file, or a topic that has poses",
        )
    return trajectory


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
    from tumtools.staging import staged

    with staged(Path(path), force=force) as target:
        target.write_text(text, encoding="utf-8")


def one_output(**flags: object) -> None:
    """Refuse two ways to print the same thing."""
    chosen = [f"--{name.replace('_', '-')}" for name, value in flags.items() if value]
    if len(chosen) > 1:
        raise UsageError(f"{' and '.join(chosen)} cannot be had together")


def print_notes(notes: tuple[str, ...]) -> None:
    """Warn of what the user should know."""
    for note in notes:
        output.warning(note)
