# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Show an entry of the catalogue: for `info NAME` and `list --json`."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, cast

import click

from tumtools.cli import output

if TYPE_CHECKING:
    from tumtools.catalogue import Entry, RemoteFile

_STANDINGS = {
    "confirmed": "sha256 confirmed by several sources",
    "single": "sha256 from one source",
    None: "sha256 unknown",
}


def entry_to_show(source: str) -> Entry | None:
    """Return the catalogue's entry if that is all there is to show of a source: not a path, not fetched."""
    if os.path.lexists(source):
        return None
    from tumtools.catalogue import load_catalogue
    from tumtools.fetch.cache import Cache

    entry = load_catalogue().find(source)
    if entry is None:
        return None
    record = Cache().record(entry.name)
    return None if record is not None and Cache().present(record) is not None else entry


def entry_document(entry: Entry) -> dict[str, object]:
    """Return an entry for JSON: stamps as strings of integer nanoseconds, errata included."""
    from tumtools.catalogue import errata
    from tumtools.catalogue.entry import as_table
    from tumtools.model.time import parse_stamp

    document = cast("dict[str, object]", as_table(entry))
    groundtruth = document.get("groundtruth")
    if isinstance(groundtruth, dict):
        for key in ("first_stamp", "last_stamp"):
            if key in groundtruth:
                groundtruth[key] = str(parse_stamp(groundtruth[key]))
        if "duplicate_stamps" in groundtruth:
            groundtruth["duplicate_stamps"] = [
                str(parse_stamp(text)) for text in groundtruth["duplicate_stamps"]
            ]
    document["errata"] = list(errata(entry))
    return document


def show_entry(entry: Entry, *, as_json: bool) -> None:
    """Print what the catalogue knows of a sequence that is not here."""
    if as_json:
        output.print_json({"fetched": False, "catalogue": entry_document(entry)})
        return
    from tumtools.catalogue import errata

    click.echo(output.style(entry.label, bold=True) + f"  ({entry.name}; not fetched)")
    rows = [
        ("category", entry.category),
        ("camera", entry.camera),
        ("kind", entry.kind),
        ("streams", ", ".join(entry.streams)),
        ("images", ", ".join(f"{count} {stream}" for stream, count in entry.frames.items())),
        ("licence of the data", entry.licence),
    ]
    facts = entry.groundtruth
    if facts is not None:
        rows += [
            ("duration", _number(facts.duration_s, "s")),
            ("ground truth", f"{facts.rows} poses over {facts.duration_with_groundtruth_s:g} s"),
            ("path length", _number(facts.path_length_sum_m, "m")),
            ("mean velocity", _velocity(facts.avg_trans_vel_m_s, facts.avg_rot_vel_deg_s)),
        ]
    for title, text in rows:
        if text:
            output.echo(f"{title}: {text}")
    for kind, file in entry.files.items():
        derived = "  (derived from the name)" if entry.source_of(f"files.{kind}.urls") == "pattern" else ""
        output.echo(f"{kind}: {file.urls[0]}{_file_facts(file)}{derived}")
    for text in errata(entry):
        output.echo(f"note: {text}")
    output.echo(f"`tumtools fetch {entry.label}` gets it")


def _file_facts(file: RemoteFile) -> str:
    if file.bytes is None and file.sha256 is None:
        return ""
    size = f"{output.size(file.bytes)}, " if file.bytes is not None else ""
    return f"  ({size}{_STANDINGS[file.standing if file.sha256 else None]})"


def _number(value: float | None, unit: str) -> str | None:
    return None if value is None else f"{value:g} {unit}"


def _velocity(translation: float | None, rotation: float | None) -> str | None:
    if translation is None or rotation is None:
        return None
    return f"{translation:g} m/s, {rotation:g} deg/s"
