# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Findings that are known and accepted, kept in a file, so that only new ones fail."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from tumtools.errors import InputError, MissingInputError
from tumtools.printable import json_text

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tumtools.validate.engine import Result

SCHEMA_VERSION: Final = 1


def render(results: Sequence[Result]) -> str:
    """Render a baseline that accepts all findings."""
    entries = [
        {
            "source": Path(result.source).name,
            "fingerprint": finding.fingerprint,
            "code": finding.code,
            "place": str(finding.place),
            "message": finding.message,
        }
        for result in results
        for finding in result.findings
    ]
    document = {"schema_version": SCHEMA_VERSION, "accepted": entries}
    return json_text(document) + "\n"


def read(path: Path) -> frozenset[tuple[str, str]]:
    """Read a baseline: pairs of the source's base name and a fingerprint.

    Raises:
        InputError: It is missing or no baseline.

    """
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        if document["schema_version"] != SCHEMA_VERSION:
            raise InputError(
                f"a baseline of version {document['schema_version']!r}, not {SCHEMA_VERSION}", path=path
            )
        return frozenset((str(entry["source"]), str(entry["fingerprint"])) for entry in document["accepted"])
    except FileNotFoundError:
        hint = "make it with --write-baseline"
        raise MissingInputError("there is no such baseline", path=path, hint=hint) from None
    except (OSError, UnicodeDecodeError, json.JSONDecodeError, KeyError, TypeError) as error:
        raise InputError(f"this is no baseline: {error}", path=path) from error


def accept(result: Result, known: frozenset[tuple[str, str]]) -> Result:
    """Return the result without the findings that the baseline knows."""
    name = Path(result.source).name
    kept = tuple(finding for finding in result.findings if (name, finding.fingerprint) not in known)
    return replace(result, findings=kept, accepted=len(result.findings) - len(kept))
