# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Show what came of `fetch`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from tumtools.cli import output
from tumtools.validate.finding import Severity

if TYPE_CHECKING:
    from tumtools.fetch import Fetched, Outcome
    from tumtools.validate.engine import Result


def show_outcomes(outcomes: list[Outcome], *, as_json: bool) -> None:
    """Print what came of each sequence; what has just been unpacked is validated quickly."""
    checks = {outcome.entry.name: _validate(outcome.fetched) for outcome in outcomes}
    if as_json:
        documents = [_document(outcome, checks[outcome.entry.name]) for outcome in outcomes]
        output.print_json({"sequences": documents})
    for outcome in outcomes:
        fetched, error, check = outcome.fetched, outcome.error, checks[outcome.entry.name]
        if error is not None:
            output.error(str(error))
        elif fetched is not None:
            for note in fetched.notes:
                output.warning(f"{fetched.label}: {note}")
            if not as_json:
                output.echo(f"{fetched.label}  {_shown(fetched.path)}  ({_how(fetched)})")
            if check is not None and check.fails(Severity.WARNING):
                output.warning(
                    f"{fetched.label}: quick validation found {check.count(Severity.ERROR)} errors and "
                    f"{check.count(Severity.WARNING)} warnings; `tumtools validate {_shown(fetched.path)}` "
                    "shows them"
                )
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


def _validate(fetched: Fetched | None) -> Result | None:
    if fetched is None or not fetched.downloaded or not fetched.path.is_dir():
        return None
    from tumtools.validate.engine import validate

    return validate(fetched.path, full=False)


def _how(fetched: Fetched) -> str:
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


def _document(outcome: Outcome, check: Result | None) -> dict[str, object]:
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
            "validation": _counts(check),
        }
    if error is None:
        return document | {"status": "failed"}
    return document | {
        "status": "failed",
        "error": error.message,
        "hint": error.hint,
        "exit_code": error.exit_code,
    }


def _counts(check: Result | None) -> dict[str, int] | None:
    return None if check is None else {one.word: check.count(one) for one in Severity}
