# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools cache`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from tumtools.cli import options, output

if TYPE_CHECKING:
    from tumtools.fetch.cache import Cache, Record


@click.group(name="cache")
def command() -> None:
    """Look after what has been fetched. TUMTOOLS_CACHE names another folder."""


@command.command(name="dir")
def directory() -> None:
    """Print the folder of the cache."""
    output.echo(str(_cache().root))


@command.command(name="list")
@options.json_option
def list_(as_json: bool) -> None:
    """List what is in the cache."""
    cache = _cache()
    rows = [(record, cache.present(record), cache.usage(record.entry.name)) for record in cache.records()]
    if as_json:
        documents = [
            {
                "name": record.entry.name,
                "short": record.entry.label,
                "path": str(path) if path else None,
                "bytes": size,
                "files": {
                    kind: {"bytes": stored.bytes, "sha256": stored.sha256, "url": stored.url}
                    | {"trust": stored.trust, "fetched": stored.fetched}
                    for kind, stored in record.files.items()
                },
                "digest": dict(record.digest),
            }
            for record, path, size in rows
        ]
        output.print_json({"root": str(cache.root), "sequences": documents})
        return
    table = [
        (record.entry.label, output.size(size), _fetched(record), str(path or "gone"))
        for record, path, size in rows
    ]
    output.print_table(table, ("name", "size", "fetched", "path"))
    output.message(f"{len(rows)} sequences, {output.size(sum(size for *_, size in rows))} in {cache.root}")


@command.command()
@click.argument("names", nargs=-1, metavar="[NAME]...")
@options.json_option
def verify(names: tuple[str, ...], as_json: bool) -> int:
    """Compare what is in the cache with the checksums and the content digest noted when it was fetched."""
    from tumtools.errors import IntegrityError

    cache = _cache()
    records = _records(cache, names)
    worst = 0
    documents: list[dict[str, object]] = []
    for record in records:
        problem = None
        try:
            cache.verify(record)
        except IntegrityError as error:
            output.error(str(error))
            worst, problem = error.exit_code, error.message
        else:
            if not as_json:
                output.echo(f"{record.entry.label}: as it was fetched")
        document = {"name": record.entry.name, "short": record.entry.label, "error": problem}
        documents.append(document | {"digest": dict(record.digest)})
    if as_json:
        output.print_json({"root": str(cache.root), "sequences": documents})
    return worst


@command.command()
@click.argument("names", nargs=-1, metavar="[NAME]...")
@click.option("--all", "everything", is_flag=True, help="Remove all sequences.")
@click.option("--dry-run", is_flag=True, help="Only tell what would be removed.")
def prune(names: tuple[str, ...], everything: bool, dry_run: bool) -> None:
    """Remove sequences.

    Without NAME: unfinished downloads, and archives that are unpacked as well.
    """
    from tumtools.fetch.atomic import BusyError
    from tumtools.fetch.cache import size_of

    cache = _cache()
    freed = 0
    whole = [record.entry.name for record in _records(cache, names)] if names or everything else []
    leftovers = {} if names else cache.leftovers()
    for name in [*whole, *(name for name in leftovers if name not in whole)]:
        size = cache.usage(name) if name in whole else sum(size_of(path) for path in leftovers[name])
        try:
            if not dry_run:
                size = cache.remove(name) if name in whole else cache.tidy(name)
        except BusyError:
            output.warning(f"{name}: another process works on it; left alone")
            continue
        freed += size
        what = name if name in whole else f"leftovers of {name}"
        output.echo(f"{'would remove' if dry_run else 'removed'} {what}  ({output.size(size)})")
    output.message(f"{output.size(freed)} {'could be' if dry_run else ''} set free".replace("  ", " "))


def _cache() -> Cache:
    from tumtools.fetch.cache import Cache

    return Cache()


def _records(cache: Cache, names: tuple[str, ...]) -> list[Record]:
    if not names:
        return list(cache.records())
    from tumtools.catalogue import Catalogue

    records = {record.entry.name: record for record in cache.records()}
    catalogue = Catalogue(tuple(record.entry for record in records.values()))
    return [records[catalogue.get(name).name] for name in names]


def _fetched(record: Record) -> str:
    dates = sorted(stored.fetched for stored in record.files.values() if stored.fetched)
    return dates[-1][:10] if dates else "-"
