# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The options that `tumtools batch run` and `retry` share."""

from __future__ import annotations

import re
from typing import Final

import click

from tumtools.cli import options

_LEAST_MEMORY: Final = 256 * 10**6
"""Bytes; with less the libraries cannot even be loaded."""
_UNITS: Final = {"": 1, "k": 10**3, "M": 10**6, "G": 10**9}


def _memory(context: click.Context, parameter: click.Parameter, value: str | None) -> int | None:
    del context, parameter
    if value is None:
        return None
    match = re.fullmatch(r"(\d+)([kMG]?)B?", value)
    if match is None:
        raise click.BadParameter(f"{value}: expected a size such as 500M or 2G")
    limit = int(match[1]) * _UNITS[match[2]]
    if limit < _LEAST_MEMORY:
        raise click.BadParameter(f"{value}: a worker needs 256M at least")
    return limit


def _shard(context: click.Context, parameter: click.Parameter, value: str | None) -> tuple[int, int] | None:
    del context, parameter
    if value is None:
        return None
    match = re.fullmatch(r"(\d+)/(\d+)", value)
    if match is None or not 1 <= int(match[1]) <= int(match[2]):
        raise click.BadParameter(f"{value}: expected I/N with 1 <= I <= N, such as 3/10")
    return int(match[1]), int(match[2])


def run_options(function: options.Command) -> options.Command:
    """Take the options of `run` and `retry`."""
    for option in reversed(
        (
            click.argument("plan"),
            click.option("--engine", default="local", show_default=True, help="local, dask, or another."),
            click.option(
                "--workers",
                type=click.IntRange(1, 1024),
                default=options.default_jobs,
                help="Tasks side by side.  [default: all processors]",
            ),
            click.option("--address", metavar="URL", help="Of a dask scheduler that runs, tcp://host:8786."),
            click.option("--shard", callback=_shard, metavar="I/N", help="Do only the I-th of N parts."),
            click.option("--claim", is_flag=True, help="Share the plan with others that run it now."),
            click.option(
                "--lease",
                type=click.FloatRange(1),
                default=120.0,
                show_default=True,
                metavar="S",
                help="Seconds after which the claim of a lost machine expires.",
            ),
            click.option("--timeout", type=click.FloatRange(0.1), metavar="S", help="Longest for a task."),
            click.option("--memory-limit", callback=_memory, metavar="SIZE", help="Of a worker, such as 2G."),
            click.option("--scratch", metavar="DIR", help="Folder for files of stores on their way."),
            click.option("--full", is_flag=True, help="Hash what is done; do again what is not what it was."),
            options.json_option,
        )
    ):  # fmt: skip
        function = option(function)
    return function
