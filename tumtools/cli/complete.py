# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What a shell completes behind a command: files and folders, names of sequences, names of rules."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import click
from click.shell_completion import CompletionItem

_FILE, _FOLDER = "file", "dir"
"""What the scripts of click know: the shell itself completes these."""
_METAVARS: Final = {"FILE": _FILE, "DIR": _FOLDER}


class SourceType(click.types.StringParamType):
    """A text that is completed as a path, or as the name of a sequence where no path begins like that."""

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Return names, or leave it to the shell."""
        del ctx, param
        names = [] if not incomplete or _begins_a_path(incomplete) else _names(incomplete)
        return [CompletionItem(name) for name in names] or [CompletionItem(incomplete, type=_FILE)]


class PlaceType(click.types.StringParamType):
    """A text that is completed as a file or folder."""

    def __init__(self, kind: str) -> None:
        self._kind = kind

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Leave it to the shell."""
        del ctx, param
        return [CompletionItem(incomplete, type=self._kind)]


class RuleType(click.types.StringParamType):
    """A text that is completed as the code or the name of a rule."""

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Return codes and names."""
        del ctx, param
        from tumtools.validate.rules import RULES

        items = [CompletionItem(rule.code, help=rule.slug) for rule in RULES.values()]
        items += [CompletionItem(rule.slug, help=rule.code) for rule in RULES.values()]
        return [item for item in items if item.value.lower().startswith(incomplete.lower())]


def complete_places(command: click.Command) -> click.Command:
    """Let a command, and those below it, complete arguments as sources and options as the files they are."""
    for parameter in command.params:
        if parameter.type is not click.STRING:
            continue
        if isinstance(parameter, click.Argument):
            parameter.type = SourceType()
        elif parameter.metavar in _METAVARS:
            parameter.type = PlaceType(_METAVARS[parameter.metavar])
    if isinstance(command, click.Group):
        for one in command.commands.values():
            complete_places(one)
    return command


def _begins_a_path(text: str) -> bool:
    folder, _, name = text.rpartition("/")
    try:
        return any(
            path.name.startswith(name) for path in Path(folder or ("/" if "/" in text else ".")).iterdir()
        )
    except OSError:
        return False


def _names(beginning: str) -> list[str]:
    from tumtools.catalogue.catalogue import packaged_catalogue

    entries = packaged_catalogue().entries
    return [name for entry in entries for name in (entry.label, entry.name) if name.startswith(beginning)]
