# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools fetch`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from tumtools.catalogue.entry import SUFFIXES
from tumtools.cli import options, output

if TYPE_CHECKING:
    from tumtools.fetch import Outcome


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
    from tumtools.cli.progress import fetch_progress
    from tumtools.fetch import FetchOptions, Patience, fetch_all

    catalogue = load_catalogue(catalogue_file)
    entries = [catalogue.get(name) for name in names]
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
    with fetch_progress() as report:
        outcomes = fetch_all(entries, fetch_options, report)
    _print(outcomes, as_json)
    return max((outcome.error.exit_code for outcome in outcomes if outcome.error), default=0)


def _print(outcomes: list[Outcome], as_json: bool) -> None:
    if as_json:
        output.print_json({"sequences": [_document(outcome) for outcome in outcomes]})
    for outcome in outcomes:
        fetched, error = outcome.fetched, outcome.error
        if error is not None:
            output.error(str(error))
        elif fetched is not None:
            for note in fetched.notes:
                output.warning(f"{fetched.label}: {note}")
            if not as_json:
                click.echo(f"{fetched.label}  {_shown(fetched.path)}  ({_how(outcome)})")
    if len(outcomes) > 1:
        output.message(_summary(outcomes))


def _summary(outcomes: list[Outcome]) -> str:
    done = [outcome.fetched for outcome in outcomes if outcome.fetched]
    new = [fetched for fetched in done if fetched.downloaded]
    failed = len(outcomes) - len(done)
    return (
        f"{len(new)} fetched ({output.size(sum(fetched.downloaded for fetched in new))}), "
        f"{len(done) - len(new)} were there, {failed} failed"
    )


def _how(outcome: Outcome) -> str:
    fetched = outcome.fetched
    if fetched is None:
        return "failed"
    trust = {
        "confirmed": "sha256 as several sources have it",
        "single": "sha256 as the catalogue has it",
        "catalogue": "sha256 as your catalogue has it",
        "lock": "sha256 as the lock file has it",
        "first use": "sha256 not known before",
    }[fetched.trust]
    if not fetched.downloaded:
        return f"was there; {trust}"
    rate = output.size(fetched.downloaded / max(fetched.seconds, 1e-9))
    return f"{output.size(fetched.downloaded)} in {fetched.seconds:.1f} s, {rate}/s; {trust}"


def _shown(path: Path) -> str:
    return str(path.relative_to(Path.cwd())) if path.is_relative_to(Path.cwd()) else str(path)


def _document(outcome: Outcome) -> dict[str, object]:
    fetched, error = outcome.fetched, outcome.error
    document: dict[str, object] = {"name": outcome.entry.name, "short": outcome.entry.label}
    if fetched is not None:
        return document | {
            "status": "fetched" if fetched.downloaded else "present",
            "path": str(fetched.path),
            "url": fetched.url,
            "bytes": fetched.bytes,
            "sha256": fetched.sha256,
            "trust": fetched.trust,
            "downloaded": fetched.downloaded,
            "seconds": round(fetched.seconds, 3),
            "notes": list(fetched.notes),
        }
    if error is None:
        return document | {"status": "failed"}
    return document | {
        "status": "failed",
        "error": error.message,
        "hint": error.hint,
        "exit_code": error.exit_code,
    }
