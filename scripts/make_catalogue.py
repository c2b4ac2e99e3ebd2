# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Make `tumtools/catalogue/sequences.json` from a collection of facts about the benchmark.

usage: python scripts/make_catalogue.py FACTS.json [OUT.json]

FACTS.json has one table per sequence and for each value the kind of its source. Nothing is added here but
other names of the same sequence (ALIASES) and the errata that no number tells (ERRATA).
"""

from __future__ import annotations

import json
import re
import sys
from datetime import UTC
from email.utils import parsedate_to_datetime
from pathlib import Path
from typing import Any

JsonTable = dict[str, Any]  # whatever JSON holds; the result is checked by the package's own parser

STANDINGS = {"many": "confirmed", "c2": "single"}

ALIASES = {
    "fr3/long_office_household": ("fr3/long_office", "fr3/office", "fr3/loh"),
    "fr3/nostructure_texture_far": ("fr3/nstr_tex_far",),
    "fr3/nostructure_texture_near_withloop": ("fr3/nstr_tex_near", "fr3/nostructure_texture_near"),
    "fr3/nostructure_notexture_far": ("fr3/nstr_ntex_far",),
    "fr3/nostructure_notexture_near_withloop": ("fr3/nstr_ntex_near", "fr3/nostructure_notexture_near"),
    "fr3/structure_texture_far": ("fr3/str_tex_far",),
    "fr3/structure_texture_near": ("fr3/str_tex_near",),
    "fr3/structure_notexture_far": ("fr3/str_ntex_far",),
    "fr3/structure_notexture_near": ("fr3/str_ntex_near",),
    "fr3/sitting_static": ("fr3/sit_static", "fr3/s_static"),
    "fr3/sitting_xyz": ("fr3/sit_xyz", "fr3/s_xyz"),
    "fr3/sitting_rpy": ("fr3/sit_rpy", "fr3/s_rpy"),
    "fr3/sitting_halfsphere": ("fr3/sit_halfsphere", "fr3/sit_half", "fr3/s_half"),
    "fr3/walking_static": ("fr3/walk_static", "fr3/w_static"),
    "fr3/walking_xyz": ("fr3/walk_xyz", "fr3/w_xyz"),
    "fr3/walking_rpy": ("fr3/walk_rpy", "fr3/w_rpy"),
    "fr3/walking_halfsphere": ("fr3/walk_halfsphere", "fr3/walk_half", "fr3/w_half"),
    "fr2/desk_with_person": ("fr2/desk_person",),
    "fr2/flowerbouquet_brownbackground": ("fr2/flower_brown",),
    "fr2/flowerbouquet": ("fr2/flower",),
    "fr3/calibration_rgb_depth": ("fr3/rgb_calibration",),
    "fr3/calibration_ir": ("fr3/ir_calibration",),
    "fr3/checkerboard_large": ("fr3/large_checkerboard_calibration",),
}
"""Abbreviations of the literature, and the regular spelling of the irregular calibration names."""

ERRATA = {
    "fr1/xyz": ("three images have no ground truth within 20 ms (a gap of 0.11 s)",),
    "fr2/desk_with_person": ("the page lists it under Dynamic Objects, the paper under Handheld SLAM",),
}


def iso_date(text: str) -> str:
    """Turn an HTTP date, with or without the day of the week, into ISO 8601."""
    return parsedate_to_datetime(text).astimezone(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")


def remote_files(facts: JsonTable, hosts: JsonTable) -> JsonTable:
    """Join the URLs of each file with what is known of its bytes."""
    files: JsonTable = {}
    for key, url in facts["urls"].items():
        if key == "tgz_old":
            continue
        file: JsonTable = {"urls": [url]}
        if key == "tgz":
            file["urls"].append(url.replace(hosts["canonical"], hosts["redirect_target"]))
            file["urls"].append(facts["urls"]["tgz_old"])
        known = facts.get(key, {})
        kinds = {facts["sources"][f"{key}.{what}"] for what in ("bytes", "sha256") if what in known}
        if kinds:
            (kind,) = kinds  # one standing for both, or the layout does not fit
            file["standing"] = STANDINGS[kind]
        for what, value in known.items():
            file[what] = iso_date(value) if what == "last_modified" else value
        files[key] = file
    return files


def sources(facts: JsonTable) -> JsonTable:
    """Say where facts come from; a section whose facts share a source says it once."""
    flat: JsonTable = {}
    for key, kind in facts["sources"].items():
        path = key
        if match := re.fullmatch(r"urls\.(\w+)", key):
            name = {"tgz_old": "tgz.urls_old", "tgz_redirect": "tgz.urls_redirect"}.get(match[1])
            path = f"files.{name or match[1] + '.urls'}"
        elif key.split(".")[0] in facts["urls"]:
            path = f"files.{key}"
        if path != "page_anchor":
            flat[path] = kind
    section = [kind for path, kind in flat.items() if path.startswith("groundtruth.")]
    if section:
        common = max(set(section), key=section.count)
        flat = {
            path: kind
            for path, kind in flat.items()
            if not (path.startswith("groundtruth.") and kind == common)
        }
        flat["groundtruth"] = common
    return flat


def entry(facts: JsonTable, hosts: JsonTable) -> JsonTable:
    """Bring the facts of one sequence into the layout of the catalogue."""
    empty = [stream.split()[0] for stream in facts["streams"] if "(empty" in stream]
    result: JsonTable = {
        "name": facts["name"],
        "short": facts["short"],
        "aliases": list(ALIASES.get(facts["short"], ())),
        "camera": facts["camera"].replace("freiburg", "fr"),
        "category": facts["category"],
        "kind": facts["kind"],
        "page_index": facts["page_index"],
        "public_groundtruth": facts.get("public_groundtruth"),
        "streams": [stream.split()[0] for stream in facts["streams"]],
        "empty_streams": empty,
        "files": remote_files(facts, hosts),
    }
    for key in ("frames", "page_size_gib", "inner_files", "groundtruth", "paper_table1"):
        result[key] = facts.get(key, {})
    result["licence"] = "CC BY 4.0"
    result["errata"] = list(ERRATA.get(facts["short"], ()))
    result["sources"] = sources(facts)
    return {key: value for key, value in result.items() if value not in (None, [], {})}


def main(arguments: list[str]) -> None:
    """Read the facts and write the catalogue."""
    if len(arguments) not in (1, 2):
        sys.exit(__doc__)
    facts = json.loads(Path(arguments[0]).read_text(encoding="utf-8"))
    default = Path(__file__).parent.parent / "tumtools" / "catalogue" / "sequences.json"
    target = Path(arguments[1]) if len(arguments) > 1 else default
    hosts = {key: facts["hosts"][key] for key in ("canonical", "redirect_target", "old")}
    sequences = [entry(sequence, facts["hosts"]) for sequence in facts["sequences"]]
    head = {"schema_version": 1, "hosts": hosts, "source_kinds": facts["source_kinds"]}
    lines = [f' "{key}": {json.dumps(value)},' for key, value in head.items()]
    blocks = []
    for sequence in sequences:  # a line for each key: small, and a change of a fact is a change of a line
        rows = [f"   {json.dumps(key)}: {json.dumps(value)}" for key, value in sequence.items()]
        blocks.append("  {\n" + ",\n".join(rows) + "\n  }")
    text = "{\n" + "\n".join(lines) + '\n "sequences": [\n' + ",\n".join(blocks) + "\n ]\n}\n"
    json.loads(text)
    target.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
