# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Write the pages that are made from the code (`python docs/generate.py`); a test checks them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import click

from tumtools.cli.main import COMMANDS, cli
from tumtools.formats.registry import FORMATS
from tumtools.validate.document import describe
from tumtools.validate.rules import RULES

if TYPE_CHECKING:
    from collections.abc import Iterator

DOCS = Path(__file__).resolve().parent
NOTE = "<!-- Made by docs/generate.py; do not edit. -->\n\n"


def pages() -> dict[Path, str]:
    """Return the text of each generated page, by its path."""
    reference = DOCS / "reference"
    return {
        reference / "cli.md": command_line(),
        reference / "formats.md": formats(),
        reference / "rules.md": rules(),
    }


def command_line() -> str:
    """Return the reference of all commands, as `--help` prints it."""
    parts = ["# Command line\n", _help(cli, "tumtools")]
    context = _context(cli, "tumtools")
    for name in COMMANDS:
        command = cli.get_command(context, name)
        if command is not None:
            for path, one in _with_subcommands(command, f"tumtools {name}"):
                parts.append(f"## `{path}`\n")
                parts.append(_help(one, path))
    return NOTE + "\n".join(parts)


def _with_subcommands(command: click.Command, path: str) -> Iterator[tuple[str, click.Command]]:
    yield path, command
    if isinstance(command, click.Group):
        for name, one in command.commands.items():
            yield from _with_subcommands(one, f"{path} {name}")


def _context(command: click.Command, path: str) -> click.Context:
    """Return a context as the program makes it, but for a fixed width and under the full name."""
    settings = cli.context_settings | {"max_content_width": 100, "terminal_width": 100}
    return click.Context(command, info_name=path, **settings)


def _help(command: click.Command, path: str) -> str:
    context = _context(command, path)
    text = re.sub(r"[ \t]+$", "", command.get_help(context), flags=re.MULTILINE)
    return f"```text\n{text}\n```\n"


def formats() -> str:
    """Return the table of formats and their options."""
    lines = ["# Formats\n", "| name | what | reads | writes |", "|---|---|---|---|"]
    lines += [f"| `{one.name}` | {one.title} | {one.reads} | {one.writes} |" for one in FORMATS.values()]
    for one in FORMATS.values():
        choices = {name: values for name, values in one.options.items() if values}
        if choices:
            lines += [
                f"\n## Options of `{one.name}`\n",
                "| option | values, the default first |",
                "|---|---|",
            ]
            lines += [
                f"| `--{name.replace('_', '-')}` | {', '.join(f'`{value}`' for value in values)} |"
                for name, values in choices.items()
            ]
    return NOTE + "\n".join(lines) + "\n"


def rules() -> str:
    """Return the page of the rules of `validate`: a table, then each rule as it documents itself."""
    lines = ["# Rules of `validate`\n", "| code | name | severity | what it finds |", "|---|---|---|---|"]
    for rule in RULES.values():
        link = f"[{rule.code}](#{rule.code.lower()}-{rule.slug})"
        lines.append(f"| {link} | {rule.slug} | {rule.severity.word} | {rule.title} |")
    return NOTE + "\n".join(lines) + "\n\n" + "\n".join(describe(rule, "##") for rule in RULES.values())


def main() -> None:
    """Write all pages."""
    for path, text in pages().items():
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)


if __name__ == "__main__":
    main()
