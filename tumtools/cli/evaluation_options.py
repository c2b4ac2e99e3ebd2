# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Options that the commands that measure share."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

import click

if TYPE_CHECKING:
    from collections.abc import Callable

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
