# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools batch`: plan, run, status, retry."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import click

from tumtools.cli import batch_options, options, output
from tumtools.errors import TumtoolsError, UsageError
from tumtools.printable import printable

EXIT_FAILED: Final = 1


@click.group(name="batch")
def command() -> None:
    """Convert many sequences as a manifest says: on this machine, on several, never twice.

    plan makes tasks of a manifest, run does those that are not done, status tells where they stand.
    """


@command.command(name="plan")
@click.argument("manifest")
@click.option("-o", "--output", "plan_file", required=True, metavar="PLAN", help="The plan to write, JSON.")
@options.json_option
def plan_command(manifest: str, plan_file: str, as_json: bool) -> None:
    """Make a plan of MANIFEST: tasks, sizes, and what would be lost. The same manifest, the same plan."""
    from tumtools.batch.manifest import read_manifest
    from tumtools.batch.plan import make_plan
    from tumtools.batch.plan_file import write_plan
    from tumtools.cli.batch_plan_report import print_plan

    if plan_file == "-":
        raise UsageError("-o: a plan is written to a file", hint="-o plan.json")
    plan = make_plan(read_manifest(Path(manifest)))
    write_plan(plan, Path(plan_file))
    print_plan(plan, as_json=as_json)


@command.command(name="run")
@batch_options.run_options
def run_command(**values: object) -> int:
    """Do the tasks of PLAN that are not done. Exits with 1 when some failed; run again goes on."""
    return _run(retry=False, **values)  # type: ignore[arg-type]  # click has checked the types


@command.command(name="retry")
@batch_options.run_options
def retry_command(**values: object) -> int:
    """Do those tasks of PLAN again that failed."""
    return _run(retry=True, **values)  # type: ignore[arg-type]  # click has checked the types


def _run(
    *,
    retry: bool,
    plan: str,
    engine: str,
    shard: tuple[int, int] | None,
    claim: bool,
    lease: float,
    scratch: Path | None,
    full: bool,
    as_json: bool,
    **settings: object,
) -> int:
    from contextlib import closing

    from tumtools.batch.engines import create_engine
    from tumtools.batch.engines.engine import EngineSettings
    from tumtools.batch.plan_file import read_plan
    from tumtools.batch.run import RunOptions, chosen, run
    from tumtools.batch.scratch import check_scratch
    from tumtools.cli.batch_progress import batch_progress
    from tumtools.cli.batch_report import Report

    whole = read_plan(Path(plan))
    if scratch is not None and settings["address"] is None:  # else it is on other machines
        check_scratch(scratch)
    run_options = RunOptions(retry, claim, shard, lease, scratch, full, _say)
    tasks = chosen(whole, run_options)
    report = Report(whole)
    started = create_engine(engine, EngineSettings(**settings, say=_say))  # type: ignore[arg-type]  # click has checked the types
    try:
        with batch_progress(tasks) as progress, closing(run(whole, tasks, started, run_options)) as outcomes:
            for outcome in outcomes:
                report.add(outcome)
                progress(outcome)
    except (KeyboardInterrupt, TumtoolsError) as error:
        if report.begun or isinstance(error, KeyboardInterrupt):
            report.show(as_json=as_json, of=len(tasks))
        raise
    report.show(as_json=as_json)
    return EXIT_FAILED if report.failed else 0


def _say(text: str) -> None:
    output.message(printable(text))


@command.command(name="status")
@click.argument("plan")
@click.option("--full", is_flag=True, help="Hash every output, instead of looking at sizes and times.")
@click.option("--check", is_flag=True, help="Exit with 1 unless every task is done or skipped.")
@batch_options.scratch_option
@options.json_option
def status_command(plan: str, full: bool, check: bool, scratch: Path | None, as_json: bool) -> int:
    """Tell where the tasks of PLAN stand, and why.

    Exits with 1 when some failed, with --full also when an output is not what it was.
    """
    from tumtools.batch.ledger import DONE, FAILED, SKIPPED
    from tumtools.batch.plan_file import read_plan
    from tumtools.batch.status import status
    from tumtools.cli.batch_status_report import print_status

    standings = list(status(read_plan(Path(plan)), full=full, scratch=scratch))
    print_status(standings, as_json=as_json)
    states = {standing.state for standing in standings}
    bad = states - {DONE, SKIPPED} if check else states & ({FAILED, "changed"} if full else {FAILED})
    return EXIT_FAILED if bad else 0
