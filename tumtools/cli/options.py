# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Options that several commands share."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import click

from tumtools.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Callable

    from tumtools.formats.options import ReadOptions
    from tumtools.model.sequence import Sequence
    from tumtools.transform import Selection


Command = TypeVar("Command", bound="Callable[..., object]")


def default_jobs() -> int:
    """Return the number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def source_argument(command: Command) -> Command:
    """Take one SOURCE."""
    return click.argument("source")(command)


def json_option(command: Command) -> Command:
    """Take --json."""
    return click.option("--json", "as_json", is_flag=True, help="Print one JSON document.")(command)


def catalogue_option(command: Command) -> Command:
    """Take --catalogue."""
    return click.option(
        "--catalogue",
        "catalogue_file",
        type=click.Path(dir_okay=False),
        metavar="FILE",
        help="A catalogue of your own, JSON or TOML, with further sequences.",
    )(command)


def jobs_option(command: Command) -> Command:
    """Take --jobs."""
    return click.option(
        "--jobs",
        type=click.IntRange(1, 256),
        default=default_jobs,
        help="Threads.  [default: all processors]",
    )(command)


def read_options(command: Command) -> Command:
    """Take the options of reading."""
    command = click.option(
        "--topic",
        "topics",
        multiple=True,
        metavar="STREAM=TOPIC",
        help="Which topic of a recording is rgb, depth, ir, accelerometer or groundtruth; of a rawlog, which "
        "sensor label, which may be empty.",
    )(command)
    return click.option(
        "--salvage", is_flag=True, help="Read a damaged recording up to the damage, and warn."
    )(command)


def parse_pairs(pairs: tuple[str, ...], option: str, *, empty_do: bool = False) -> dict[str, str]:
    """Read STREAM=VALUE options.

    Args:
        pairs: As they were given.
        option: For messages.
        empty_do: Take empty values.

    Raises:
        UsageError: No `=`, no value, or no such stream.

    """
    from tumtools.model.sequence import STREAMS

    result = {}
    for pair in pairs:
        stream, equals, value = pair.partition("=")
        if not equals or not (value or empty_do) or stream not in STREAMS:
            raise UsageError(f"{option} {pair}: expected STREAM=VALUE with a stream of {', '.join(STREAMS)}")
        result[stream] = value
    return result


def make_read_options(
    topics: tuple[str, ...], salvage: bool, *, lenient: bool = False, streams: str | None = None
) -> ReadOptions:
    """Build the options of reading; `streams` are the names of those that are wanted."""
    from tumtools.formats.options import ReadOptions

    wanted = None if streams is None else frozenset(_split(streams))
    # A sensor of a rawlog has an empty label unless somebody names it.
    return ReadOptions(parse_pairs(topics, "--topic", empty_do=True), salvage, lenient, wanted)


def _split(names: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in names.split(","))


def path_or_none(value: str | None) -> Path | None:
    """Return a path for an option that may be absent."""
    return None if value is None else Path(value)


def make_selection(
    sequence: Sequence, start: str | None, end: str | None, every: int, streams: str | None
) -> Selection:
    """Build the choice of streams and times.

    Args:
        sequence: Times are counted from its first stamp.
        start: Seconds, from the first stamp or since 1970.
        end: The same.
        every: Keep each n-th image.
        streams: Names, separated by commas.

    Raises:
        UsageError: A time is no number, or there is no such stream.

    """
    from tumtools.transform import parse_selection

    return parse_selection(sequence, start, end, every, None if streams is None else _split(streams))
