# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The options that `tumtools batch run` and `retry` share."""

from __future__ import annotations

import re
import sys
from decimal import Decimal
from pathlib import Path
from typing import Final

import click

from tumtools.cli import options

_LEAST_MEMORY: Final = 256 * 10**6
"""Bytes; with less the libraries cannot even be loaded."""
_UNITS: Final = {"": 1, "K": 10**3, "M": 10**6, "G": 10**9, "T": 10**12}
_BINARY_UNITS: Final = {"K": 2**10, "M": 2**20, "G": 2**30, "T": 2**40}
_MOST_SECONDS: Final = 10**8


def _memory(context: click.Context, parameter: click.Parameter, value: str | None) -> int | None:
    del context, parameter
    if value is None:
        return None
    match = re.fullmatch(r"(\d{1,20}(?:\.\d{1,20})?) ?(?:([KMGT]?)|([KMGT])I)B?", value.upper())
    if match is None:
        raise click.BadParameter(f"{value}: expected a size such as 500M, 1.5G or 2GiB")
    limit = int(Decimal(match[1]) * (_BINARY_UNITS[match[3]] if match[3] else _UNITS[match[2] or ""]))
    if limit < _LEAST_MEMORY:
        raise click.BadParameter(f"{value}: a worker needs 256M at least")
    if limit > sys.maxsize:
        raise click.BadParameter(f"{value}: no machine has so much")
    return limit


def _seconds(context: click.Context, parameter: click.Parameter, value: float | None) -> float | None:
    del context, parameter
    if value is not None and not value <= _MOST_SECONDS:  # nor is what is no number
        raise click.BadParameter(f"{value}: expected seconds, {_MOST_SECONDS} at most")
    return value


def _shard(context: click.Context, parameter: click.Parameter, value: str | None) -> tuple[int, int] | None:
    del context, parameter
    if value is None:
        return None
    match = re.fullmatch(r"(\d+)/(\d+)", value)
    if match is None or not 1 <= int(match[1]) <= int(match[2]):
        raise click.BadParameter(f"{value}: expected I/N with 1 <= I <= N, such as 3/10")
    return int(match[1]), int(match[2])


def scratch_option(function: options.Command) -> options.Command:
    """Take --scratch."""
    return click.option(
        "--scratch",
        callback=lambda _context, _parameter, value: Path(value).absolute() if value else None,
        metavar="DIR",
        help="Folder for files of stores on their way.",
    )(function)


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
                callback=_seconds,
                default=120.0,
                show_default=True,
                metavar="S",
                help="Seconds after which the claim of a lost machine expires.",
            ),
            click.option(
                "--timeout",
                type=click.FloatRange(0.1),
                callback=_seconds,
                metavar="S",
                help="Longest for a task.",
            ),
            click.option("--memory-limit", callback=_memory, metavar="SIZE", help="Of a worker, such as 2G."),
            scratch_option,
            click.option("--full", is_flag=True, help="Hash what is done; do again what is not what it was."),
            options.json_option,
        )
    ):  # fmt: skip
        function = option(function)
    return function
