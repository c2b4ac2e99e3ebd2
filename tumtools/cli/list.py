# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools list`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from tumtools.catalogue.entry import KINDS
from tumtools.cli import options, output

if TYPE_CHECKING:
    from tumtools.catalogue import Entry


@click.command(name="list")
@click.option("--camera", metavar="fr1", help="Only sequences of this camera.")
@click.option("--category", metavar="TEXT", help="Only categories with this text in their name.")
@click.option("--kind", type=click.Choice(KINDS), help="Only sequences of this kind.")
@options.catalogue_option
@options.json_option
def command(
    camera: str | None, category: str | None, kind: str | None, catalogue_file: str | None, as_json: bool
) -> None:
    """List the sequences of the benchmark, and of your own catalogue; `*` marks those that are fetched."""
    from tumtools.catalogue import load_catalogue
    from tumtools.fetch.cache import Cache

    catalogue = load_catalogue(catalogue_file)
    entries = catalogue.filter(camera, category, kind)
    fetched = {entry.name for entry in Cache().catalogue()}
    if as_json:
        from tumtools.cli.entry import entry_document

        documents = [{"fetched": entry.name in fetched, **entry_document(entry)} for entry in entries]
        output.print_json({"sequences": documents})
        return
    if entries:
        rows = [_row(entry, entry.name in fetched) for entry in entries]
        output.print_table(rows, ("", "name", "kind", "category", "size", "duration", "images"))
    else:
        cameras = sorted({entry.camera for entry in catalogue if entry.camera})
        categories = sorted({_heading(entry) for entry in catalogue if entry.category})
        output.message(f"there are the cameras {', '.join(cameras)}; the categories {', '.join(categories)}")
    output.message(f"{len(entries)} sequences")


def _heading(entry: Entry) -> str:
    return (entry.category or "-").partition(" (")[0]


def _row(entry: Entry, fetched: bool) -> tuple[str, ...]:
    file = entry.files.get("tgz") or next(iter(entry.files.values()), None)
    duration = entry.groundtruth.duration_s if entry.groundtruth else None
    return (
        "*" if fetched else " ",
        entry.label,
        entry.kind,
        _heading(entry),
        output.size(file.bytes) if file and file.bytes is not None else "-",
        f"{duration:.1f} s" if duration is not None else "-",
        str(entry.frames["rgb"]) if "rgb" in entry.frames else "-",
    )
