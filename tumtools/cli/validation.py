# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What `tumtools validate` does besides validating: settings, the places of its outputs, the report."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

from tumtools.errors import TumtoolsError, UsageError

if TYPE_CHECKING:
    from tumtools.validate.engine import Report
    from tumtools.validate.settings import Settings

STDOUT: Final = "-"
"""As the name of a file: the report goes to stdout."""


def make_settings(
    config: str | None, select: tuple[str, ...], ignore: tuple[str, ...], fail_on: str | None
) -> Settings:
    """Read the configuration and put the command line on top.

    Raises:
        InputError: The configuration cannot be read.
        UsageError: A rule or a value is not known.

    """
    from tumtools.validate.settings import Settings, find_config, parse_codes, parse_fail_on, read_config

    path = Path(config) if config else find_config(Path.cwd())
    settings = read_config(path) if path else Settings()
    if codes := parse_codes(",".join(select), "--select"):
        settings = replace(settings, select=codes, extend_select=())
    settings = replace(settings, ignore=settings.ignore + parse_codes(",".join(ignore), "--ignore"))
    if fail_on:
        settings = replace(settings, fail_on=parse_fail_on(fail_on, "--fail-on"))
    return settings


def refuse_places(sources: tuple[str, ...], files: tuple[str | None, ...], fix_folder: str | None) -> None:
    """Refuse, before the work begins, places that nothing can be written to.

    Args:
        sources: What is checked.
        files: Of reports and baselines.
        fix_folder: Of the mended copy.

    Raises:
        UsageError: A report's place is a folder, that of the mended copy is there, or it has two sources.

    """
    from tumtools.staging import refuse_folder

    for name in files:
        if name:
            refuse_folder(Path(name))
    if not fix_folder:
        return
    if len(sources) > 1:
        raise UsageError("--fix takes one SOURCE")
    if Path(fix_folder).exists():
        raise UsageError("the folder for the mended copy exists", path=fix_folder, hint="name a new one")


def count_frames(source: str) -> int:
    """Count the images for the progress bar; 0 where there is none, or the source cannot be opened."""
    from tumtools.sources import open_source

    if not sys.stderr.isatty():
        return 0
    try:
        with open_source(source) as sequence:
            return sum(info.count for info in sequence.info.images.values())
    except TumtoolsError:
        return 0


def write_report(report: Report, report_format: str, file: str | None) -> None:
    """Write a report to a file or to stdout, there with colours if it is text."""
    from tumtools.validate.reports import render
    from tumtools.validate.reports.text import render_styled

    if file is None and report_format == "text":
        click.echo(render_styled(report, _style), nl=False)
    else:
        write_text(file, render(report, report_format))


def _style(text: str, colour: str) -> str:
    return click.style(text, bold=True) if colour == "bold" else click.style(text, fg=colour)


def write_text(file: str | None, text: str) -> None:
    """Write a file as a whole, or to a pipe or device as it is, or to stdout."""
    if file is None or file == STDOUT:
        click.echo(text, nl=False)
        return
    from tumtools.staging import refuse_folder, staged_file

    path = Path(file)
    refuse_folder(path)
    if path.exists() and not path.is_file():
        with path.open("w", encoding="utf-8", errors="backslashreplace") as pipe:
            pipe.write(text)
        return
    with staged_file(path, force=True) as place:
        place.write_text(text, encoding="utf-8", errors="backslashreplace")
