# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools digest`."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import TYPE_CHECKING

import click

from tumtools.cli import options, output

if TYPE_CHECKING:
    from tumtools.model.digest import KeptDigest
    from tumtools.model.sequence import Sequence


@click.command(name="digest")
@options.source_argument
@click.option("--deep", is_flag=True, help="Print the digest of each image, too; as lines of JSON.")
@click.option("--check", "compare", is_flag=True, help="Compare SOURCE with the digest that it carries.")
@options.read_options
@options.jobs_option
@options.json_option
def command(
    source: str,
    deep: bool,
    compare: bool,
    topics: tuple[str, ...],
    salvage: bool,
    jobs: int,
    as_json: bool,
) -> int:
    """Print a digest of the content of SOURCE, the same for every format that holds the same content.

    With --check, tell whether SOURCE still holds what was written when tumtools made it: exit code 0 if it
    does, 1 if not, 4 if it carries no digest or is damaged.
    """
    from tumtools.errors import UsageError
    from tumtools.sources import open_source

    if deep and compare:
        raise UsageError("--deep and --check exclude each other")
    with open_source(source, options.make_read_options(topics, salvage)) as sequence:
        if compare:
            return _check(source, sequence, jobs, as_json=as_json)
        _print_digest(source, sequence, jobs, deep=deep, as_json=as_json)
        return 0


def _print_digest(source: str, sequence: Sequence, jobs: int, *, deep: bool, as_json: bool) -> None:
    from tumtools.digest import digest
    from tumtools.model.digest import VERSION

    frames = sum(info.count for info in sequence.info.images.values())
    with output.progress_bar("digest", frames) as bar:
        result = digest(sequence, jobs=jobs, deep=deep, progress=bar)
    frames_found = [
        {"stream": stream, "stamp": str(stamp), "sha256": value} for stream, stamp, value in result.frames
    ]
    streams = {name: {"count": one.count, "sha256": one.value} for name, one in result.streams.items()}
    document = {"source": source, "digest_version": VERSION, "sha256": result.value, "streams": streams}
    if as_json:
        output.print_json(document | ({"frames": frames_found} if deep else {}))
        return
    if deep:
        for line in (*frames_found, document):
            click.echo(json.dumps(line))
        return
    output.print_table([(name, str(one.count), one.value) for name, one in sorted(result.streams.items())])
    output.echo(f"{result.value}  {source}")


def _check(source: str, sequence: Sequence, jobs: int, *, as_json: bool) -> int:
    from tumtools.kept_digest import check

    frames = sum(info.count for info in sequence.info.images.values())
    with output.progress_bar("digest", frames) as bar:
        checks = check(sequence, jobs=jobs, progress=bar)
    same = all(one.same for one in checks)
    if as_json:
        output.print_json({"source": source, "same": same, "streams": [asdict(one) for one in checks]})
    else:
        rows = [
            (one.stream, _shown(one.kept), _shown(one.found), "same" if one.same else "different")
            for one in checks
        ]
        output.print_table(rows, ("stream", "written", "found", "result"))
        output.echo(f"{source}: {'holds what was written' if same else 'is not what was written'}")
    return 0 if same else 1


def _shown(kept: KeptDigest | None) -> str:
    return "-" if kept is None else f"{kept.count} {kept.of} {kept.value[:12]}"
