# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`-v` and `-q`, before the command and behind it."""

from __future__ import annotations

import click

from tumtools.cli import output


def _louder(context: click.Context, parameter: click.Parameter, value: int) -> None:
    del context, parameter
    if value:
        output.verbosity = max(output.verbosity, 0) + value


def _silent(context: click.Context, parameter: click.Parameter, value: bool) -> None:
    del context, parameter
    if value:
        output.verbosity = -1


def verbosity_options(*, hidden: bool = False) -> list[click.Parameter]:
    """Return both options; they set `output.verbosity` and give the command nothing."""
    return [
        click.Option(
            ["-v", "--verbose"],
            count=True,
            expose_value=False,
            hidden=hidden,
            callback=_louder,
            help="Say how long it took; twice shows where an error arose.",
        ),
        click.Option(
            ["-q", "--quiet"],
            is_flag=True,
            expose_value=False,
            hidden=hidden,
            callback=_silent,
            help="Say nothing but results, losses and errors.",
        ),
    ]


def offer(command: click.Command) -> click.Command:
    """Let a command, and those below it, take both options, too; their help leaves that to the program's."""
    if all("--verbose" not in parameter.opts for parameter in command.params):
        command.params.extend(verbosity_options(hidden=True))
    if isinstance(command, click.Group):
        for one in command.commands.values():
            offer(one)
    return command
