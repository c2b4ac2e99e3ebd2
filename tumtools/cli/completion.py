# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools completion`."""

from __future__ import annotations

import click
from click.shell_completion import get_completion_class

SHELLS = ("bash", "zsh", "fish")


@click.command(name="completion")
@click.argument("shell", type=click.Choice(SHELLS))
def command(shell: str) -> None:
    """Print the script with which a shell completes commands, options, files and names of sequences.

    bash 4.4 or newer: tumtools completion bash >> ~/.bash_completion

    zsh: tumtools completion zsh > FOLDER/_tumtools, with a FOLDER of $fpath

    fish: tumtools completion fish > ~/.config/fish/completions/tumtools.fish
    """
    from tumtools.cli.main import cli

    kind = get_completion_class(shell)
    if kind is not None:
        click.echo(kind(cli, {}, "tumtools", "_TUMTOOLS_COMPLETE").source())
