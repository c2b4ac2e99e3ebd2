# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools validate`."""

from __future__ import annotations

from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

import click

from tumtools.cli import options, output

if TYPE_CHECKING:
    from tumtools.validate.engine import Report, Result
    from tumtools.validate.settings import Settings

FORMATS = ("text", "json", "sarif", "junit", "github", "markdown")
EXIT_FINDINGS = 1


@click.command(name="validate")
@click.argument("sources", metavar="SOURCE...", nargs=-1, required=True)
@click.option(
    "--full/--quick", "full", default=True, help="Decode every image, or read text and headers only."
)
@click.option("--format", "report_format", type=click.Choice(FORMATS), default="text", show_default=True)
@click.option("--output", "output_file", metavar="FILE", help="Write the report there instead of to stdout.")
@click.option(
    "--select", metavar="CODES", help="Run only these rules: codes, or beginnings of codes, or ALL."
)
@click.option("--ignore", metavar="CODES", help="Do not run these rules.")
@click.option(
    "--fail-on", type=click.Choice(("error", "warning", "never")), help="Exit 1 from this severity on."
)
@click.option(
    "--config", metavar="FILE", help="Configuration.  [default: the nearest tumtools.toml or pyproject.toml]"
)
@click.option("--baseline", metavar="FILE", help="Accept the findings that this file lists.")
@click.option("--write-baseline", metavar="FILE", help="Write a baseline that accepts all that is found.")
@click.option("--fix", "fix_folder", metavar="DIR", help="Write a mended copy of the one SOURCE to DIR.")
@options.read_options
@options.jobs_option
def command(
    sources: tuple[str, ...],
    full: bool,
    report_format: str,
    output_file: str | None,
    select: str | None,
    ignore: str | None,
    fail_on: str | None,
    config: str | None,
    baseline: str | None,
    write_baseline: str | None,
    fix_folder: str | None,
    topics: tuple[str, ...],
    salvage: bool,
    jobs: int,
) -> int:
    """Check each SOURCE: files, stamps, images, depth, ground truth, accelerometer, container.

    A folder that is no sequence stands for all sequences, recordings and archives in it.

    Exits with 0 when there is nothing at or above --fail-on, else with 1. `tumtools rules` explains.
    """
    from tumtools.validate import baseline as baselines
    from tumtools.validate.discover import discover
    from tumtools.validate.engine import Report, validate
    from tumtools.validate.reports import render

    settings = _settings(config, select, ignore, fail_on)
    known = baselines.read(Path(baseline)) if baseline else frozenset()
    read_options = options.make_read_options(topics, salvage)
    results: list[Result] = []
    for source in chain.from_iterable(map(discover, sources)):
        with output.progress_bar(source, _frames(source)) as bar:
            result = validate(source, settings, full=full, options=read_options, jobs=jobs, progress=bar)
        results.append(baselines.accept(result, known))
    report = Report(tuple(results), settings.fail_on)
    if report_format == "text" and not output_file:
        _print(report)
    else:
        _write(output_file, render(report, report_format))
    if write_baseline:
        _write(write_baseline, baselines.render(results))
    if fix_folder:
        _fix(sources, fix_folder, settings, jobs)
    return EXIT_FINDINGS if report.failed else 0


def _settings(config: str | None, select: str | None, ignore: str | None, fail_on: str | None) -> Settings:
    """Read the configuration and put the command line on top."""
    from tumtools.validate.settings import Settings, find_config, parse_codes, parse_fail_on, read_config

    path = Path(config) if config else find_config(Path.cwd())
    settings = read_config(path) if path else Settings()
    if select:
        settings = replace(settings, select=parse_codes(select, "--select"), extend_select=())
    if ignore:
        settings = replace(settings, ignore=settings.ignore + parse_codes(ignore, "--ignore"))
    if fail_on:
        settings = replace(settings, fail_on=parse_fail_on(fail_on, "--fail-on"))
    return settings


def _frames(source: str) -> int:
    """Count the images for the progress bar; 0 where the source cannot be opened."""
    import sys

    from tumtools.errors import TumtoolsError
    from tumtools.sources import open_source

    if not sys.stderr.isatty():
        return 0
    try:
        with open_source(source) as sequence:
            return sum(info.count for info in sequence.info.images.values())
    except TumtoolsError:
        return 0


def _print(report: Report) -> None:
    from tumtools.validate.reports.text import render_styled

    def style(text: str, colour: str) -> str:
        return click.style(text, bold=True) if colour == "bold" else click.style(text, fg=colour)

    click.echo(render_styled(report, style), nl=False)


def _write(path: str | None, text: str) -> None:
    """Write a file as a whole, or to stdout."""
    if path is None:
        click.echo(text, nl=False)
        return
    from tumtools.staging import staged

    with staged(Path(path), force=True) as place:
        place.write_text(text, encoding="utf-8")


def _fix(sources: tuple[str, ...], folder: str, settings: Settings, jobs: int) -> None:
    from tumtools.errors import UsageError
    from tumtools.validate.fix import fix

    if len(sources) > 1:
        raise UsageError("--fix takes one SOURCE")
    for change in fix(sources[0], Path(folder), settings, jobs=jobs):
        output.message(f"fixed {change}")
