# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools plot`."""

from __future__ import annotations

from contextlib import ExitStack
from typing import TYPE_CHECKING

import click

from tumtools.cli import evaluation, evaluation_options, options
from tumtools.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Callable

    from tumtools.evaluate.align import Mode
    from tumtools.model.signals import Trajectory

_output = evaluation_options.several(
    click.argument("sources", metavar="SOURCE...", nargs=-1, required=True),
    click.option(
        "-o", "--output", "target", required=True, metavar="FILE", help="The picture: .svg, .png or .pdf."
    ),
    click.option("--title", help="Text above the picture."),
    click.option("--force", is_flag=True, help="Replace FILE if it exists."),
)


@click.group(name="plot")
def command() -> None:
    """Draw trajectories, and timelines of streams. Pictures of errors: `tumtools evaluate --plot`."""


@command.command()
@_output
@click.option("--topic", metavar="TOPIC", help="Topic with the poses, of sources that are recordings.")
@click.option(
    "--plane",
    type=click.Choice(["xy", "xz", "yz"]),
    default="xy",
    show_default=True,
    help="xy is from above.",
)
@click.option(
    "--align",
    "alignment",
    type=click.Choice(["se3", "sim3", "none"]),
    default="none",
    show_default=True,
    help="Align the others to the first one.",
)
def trajectory(
    sources: tuple[str, ...],
    target: str,
    title: str | None,
    force: bool,
    topic: str | None,
    plane: str,
    alignment: Mode,
) -> None:
    """Draw the paths of one or more SOURCEs, the first one in black."""
    from tumtools.plot.style import save
    from tumtools.plot.trajectory import plot_trajectories

    paths = {
        _label(source, sources): evaluation.read_trajectory(source, topic, "--topic") for source in sources
    }
    if len(paths) < len(sources):
        raise UsageError("a source is named twice")
    if alignment != "none":
        paths = _aligned(paths, alignment)
    save(plot_trajectories(paths, plane, title), target, force=force)


@command.command()
@_output
@options.read_options
def timeline(
    sources: tuple[str, ...],
    target: str,
    title: str | None,
    force: bool,
    topics: tuple[str, ...],
    salvage: bool,
) -> None:
    """Draw when each stream of the SOURCEs has items, with gaps and coverage."""
    from tumtools.plot.style import save
    from tumtools.plot.timeline import plot_timeline
    from tumtools.sources import open_source

    with ExitStack() as stack:
        reading = options.make_read_options(topics, salvage)
        sequences = {
            _label(source, sources): stack.enter_context(open_source(source, reading)) for source in sources
        }
        if len(sequences) < len(sources):
            raise UsageError("a source is named twice")
        save(plot_timeline(sequences, title), target, force=force)


def _label(source: str, sources: tuple[str, ...]) -> str:
    """Return the last part of a path, unless two sources share it."""
    shorten: Callable[[str], str] = lambda text: text.rstrip("/").rpartition("/")[2].removesuffix(".txt")  # noqa: E731
    name = shorten(source)
    return name if [shorten(other) for other in sources].count(name) == 1 else source


def _aligned(paths: dict[str, Trajectory], alignment: Mode) -> dict[str, Trajectory]:
    """Align all trajectories to the first."""
    from tumtools.evaluate.ate import evaluate_ate

    (first, true), *others = paths.items()
    return {first: true} | {
        name: evaluate_ate(true, path, alignment=alignment).aligned for name, path in others
    }
