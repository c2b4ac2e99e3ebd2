# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools validate`."""

from __future__ import annotations

from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

import click

from tumtools.cli import options, output, validation

if TYPE_CHECKING:
    from tumtools.validate.engine import Result

FORMATS = ("text", "json", "sarif", "junit", "github", "markdown")
EXIT_FINDINGS = 1


@click.command(name="validate")
@click.argument("sources", metavar="SOURCE...", nargs=-1, required=True)
@click.option(
    "--full/--quick", "full", default=True, help="Decode every image, or read text and headers only."
)
@click.option("--format", "report_format", type=click.Choice(FORMATS), default="text", show_default=True)
@click.option("--json", "as_json", is_flag=True, help="The same as --format json.")
@click.option("--output", "output_file", metavar="FILE", help="Write the report there instead of to stdout.")
@click.option(
    "--select",
    metavar="CODES",
    multiple=True,
    help="Run only these rules: names, codes, or beginnings of codes, with commas between them, or ALL.",
)
@click.option("--ignore", metavar="CODES", multiple=True, help="Do not run these rules.")
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
    as_json: bool,
    output_file: str | None,
    select: tuple[str, ...],
    ignore: tuple[str, ...],
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

    A source that cannot be opened is an error, whatever rules are chosen.

    Exits with 0 when there is nothing at or above --fail-on, else with 1. `tumtools rules` explains.
    """
    from tumtools.validate import baseline as baselines
    from tumtools.validate.discover import discover
    from tumtools.validate.engine import Report, validate
    from tumtools.validate.fix import fix

    settings = validation.make_settings(config, select, ignore, fail_on)
    validation.refuse_places(sources, (output_file, write_baseline), fix_folder)
    known = baselines.read(Path(baseline)) if baseline else frozenset()
    read_options = options.make_read_options(topics, salvage)
    results: list[Result] = []
    for source in chain.from_iterable(map(discover, sources)):
        with output.progress_bar(source, validation.count_frames(source)) as bar:
            results.append(
                validate(source, settings, full=full, options=read_options, jobs=jobs, progress=bar)
            )
    report = Report(tuple(baselines.accept(result, known) for result in results), settings.fail_on)
    validation.write_report(report, "json" if as_json else report_format, output_file)
    if write_baseline:
        # Of all that is found: what an older baseline accepts stays accepted.
        validation.write_text(write_baseline, baselines.render(results))
    if fix_folder:
        for change in fix(sources[0], Path(fix_folder), settings, jobs=jobs):
            output.message(f"fixed {change}")
    return EXIT_FINDINGS if report.failed else 0
