# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Batches from Python: what the commands `tumtools batch` do, as functions."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from tumtools.batch.engines import create_engine
from tumtools.batch.engines.engine import EngineSettings
from tumtools.batch.manifest import read_manifest
from tumtools.batch.plan import Plan, make_plan
from tumtools.batch.plan_file import read_plan
from tumtools.batch.run import RunOptions, chosen, run
from tumtools.batch.scratch import check_scratch
from tumtools.batch.status import status

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tumtools.batch.status import Standing
    from tumtools.batch.task import Outcome


def plan_batch(manifest: str | os.PathLike[str]) -> Plan:
    """Make the plan of a manifest; `write_plan` writes it to a file.

    Args:
        manifest: A TOML file (docs/reference/batch.md).

    Raises:
        InputError: It is missing or wrong, a source does not exist, or outputs would be in each other's
            way; with the line.

    """
    return make_plan(read_manifest(Path(manifest)))


def run_batch(
    plan: Plan | str | os.PathLike[str],
    engine: str = "local",
    settings: EngineSettings | None = None,
    options: RunOptions | None = None,
) -> Iterator[Outcome]:
    """Do the tasks of a plan that are not done, and yield what came of each.

    When the iterator is closed early the workers are ended, and what they were doing is begun again by the
    next run. The engine `local` starts processes by spawn: a script that calls this needs
    `if __name__ == "__main__":`.

    Args:
        plan: A plan, or its file.
        engine: `local`, `dask`, `inline`, or another that is installed (entry points `tumtools.engines`).
        settings: Workers, address, time-out, memory; a worker for each processor unless told.
        options: Which tasks, and how.

    Raises:
        InputError: The plan is missing or was edited.
        OutputError: The destination cannot be written to.
        UsageError: There is no such engine, or what it needs is not installed.

    """
    whole, options = _plan(plan), options or RunOptions()
    settings = settings or EngineSettings(workers=os.cpu_count() or 1)
    if options.scratch is not None and settings.address is None:  # else it is on other machines
        check_scratch(options.scratch)
    yield from run(whole, chosen(whole, options), create_engine(engine, settings), options)


def retry_batch(
    plan: Plan | str | os.PathLike[str],
    engine: str = "local",
    settings: EngineSettings | None = None,
    options: RunOptions | None = None,
) -> Iterator[Outcome]:
    """Do those tasks again that failed; arguments and errors are those of `run_batch`."""
    return run_batch(plan, engine, settings, replace(options or RunOptions(), retry=True))


def batch_status(
    plan: Plan | str | os.PathLike[str], *, full: bool = False, scratch: Path | None = None
) -> Iterator[Standing]:
    """Yield where each task of a plan stands, in its order.

    Args:
        plan: A plan, or its file.
        full: Hash all outputs, instead of looking at sizes and times.
        scratch: Folder for what is downloaded to be hashed; None for the system's.

    Raises:
        InputError: The plan is missing or was edited, or the ledger cannot be read.

    """
    return status(_plan(plan), full=full, scratch=scratch)


def _plan(plan: Plan | str | os.PathLike[str]) -> Plan:
    return plan if isinstance(plan, Plan) else read_plan(Path(plan))
