# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools fetch`."""

from __future__ import annotations

import click

from tumtools.catalogue.entry import SUFFIXES
from tumtools.cli import options, output


@click.command(name="fetch")
@click.argument("names", nargs=-1, required=True, metavar="NAME...")
@click.option(
    "--format",
    "kind",
    type=click.Choice(list(SUFFIXES)),
    help="Which file of the sequence.  [default: the archive]",
)
@click.option("--dest", type=click.Path(file_okay=False), metavar="DIR", help="Folder instead of the cache.")
@click.option("--no-extract", is_flag=True, help="Keep the archive as it is.")
@click.option("--keep-archive", is_flag=True, help="Unpack, and keep the archive too.")
@click.option("--mirror", metavar="URL", help="Folder on a server to look in first.")
@options.catalogue_option
@click.option("--lock", type=click.Path(dir_okay=False), metavar="FILE", help="Lock file to use.")
@click.option("--offline", is_flag=True, help="Use only what is there.")
@click.option(
    "--timeout",
    type=click.FloatRange(0.1),
    default=30.0,
    metavar="S",
    show_default=True,
    help="Seconds without a byte after which a connection counts as broken.",
)
@click.option(
    "--retries",
    type=click.IntRange(0),
    default=5,
    metavar="N",
    show_default=True,
    help="Attempts in a row that may bring nothing.",
)
@click.option(
    "--jobs", type=click.IntRange(1, 16), default=1, show_default=True, help="Downloads side by side."
)
@options.json_option
def command(
    names: tuple[str, ...],
    kind: str | None,
    dest: str | None,
    no_extract: bool,
    keep_archive: bool,
    mirror: str | None,
    catalogue_file: str | None,
    lock: str | None,
    offline: bool,
    timeout: float,
    retries: int,
    jobs: int,
    as_json: bool,
) -> int:
    """Download sequences, verify them, and unpack them into the cache.

    What was interrupted goes on where it stopped. A file whose checksum nobody publishes is trusted the first
    time and noted in tumtools.lock.
    """
    from tumtools.catalogue import load_catalogue
    from tumtools.cli.outcomes import show_outcomes
    from tumtools.cli.progress import fetch_progress
    from tumtools.fetch import FetchOptions, Patience, fetch_all
    from tumtools.fetch.cache import Cache

    catalogue, there = load_catalogue(catalogue_file), Cache().catalogue()
    # A sequence of the user's own catalogue is known by name once it was fetched.
    entries = [catalogue.find(name) or there.find(name) or catalogue.get(name) for name in names]
    fetch_options = FetchOptions(
        kind=kind,
        dest=options.path_or_none(dest),
        unpack=not no_extract,
        keep_archive=keep_archive,
        mirror=mirror,
        offline=offline,
        lock=options.path_or_none(lock),
        jobs=jobs,
        patience=Patience(connect_timeout=min(timeout, 10.0), read_timeout=timeout, retries=retries),
    )
    try:
        with fetch_progress() as report:
            outcomes = fetch_all(entries, fetch_options, report)
    except KeyboardInterrupt:
        output.message("what has come is kept: the same command goes on from there")
        raise
    show_outcomes(outcomes, as_json=as_json)
    return max((outcome.error.exit_code for outcome in outcomes if outcome.error), default=0)
