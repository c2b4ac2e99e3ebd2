# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Run the rules over a source and put the findings in order."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from tumtools.formats.options import Progress, ReadOptions, no_progress
from tumtools.validate.errata import explain
from tumtools.validate.finding import Finding, Severity
from tumtools.validate.load import load
from tumtools.validate.rule import Needs
from tumtools.validate.rules import RULES
from tumtools.validate.settings import Settings

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from tumtools.validate.subject import Subject

CANNOT_BE_OPENED: Final = frozenset({"TUM001", "TUM701", "TUM706"})
"""Rules that say why a source cannot be opened; they always run then."""


@dataclass(frozen=True, slots=True)
class Result:
    """What was found in a source.

    Attributes:
        source: As the user named it.
        path: Where it is on disk.
        is_folder: Whether `Place.file` names a file of its own below `path`.
        name: Name of the sequence; that of the source if it could not be opened.
        format: Its format; empty if unknown.
        findings: In order of file, line and code.
        rules: Codes of the rules that ran.
        images: Images looked at.
        level: `full` or `quick`.
        accepted: Findings that the baseline knew.

    """

    source: str
    path: str
    is_folder: bool
    name: str
    format: str
    findings: tuple[Finding, ...]
    rules: tuple[str, ...] = ()
    images: int = 0
    level: str = "full"
    accepted: int = 0

    def count(self, severity: Severity) -> int:
        """Count findings of a severity."""
        return sum(finding.severity == severity for finding in self.findings)

    def fails(self, fail_on: Severity | None) -> bool:
        """Whether there is a finding of at least this severity; never for None."""
        return fail_on is not None and any(finding.severity >= fail_on for finding in self.findings)

    def file_of(self, finding: Finding) -> str:
        """Return the path of the file on disk that a finding is about."""
        if self.is_folder and finding.place.file:
            return f"{self.path.rstrip('/')}/{finding.place.file}"
        return self.path


@dataclass(frozen=True, slots=True)
class Report:
    """What was found in all sources.

    Attributes:
        results: One a source, in the order asked for.
        fail_on: Least severity that makes it a failure; None for never.

    """

    results: tuple[Result, ...]
    fail_on: Severity | None = Severity.ERROR

    @property
    def failed(self) -> bool:
        """Whether any source failed."""
        return any(result.fails(self.fail_on) for result in self.results)


def validate(
    source: str | Path,
    settings: Settings | None = None,
    *,
    full: bool = True,
    options: ReadOptions | None = None,
    jobs: int = 2,
    progress: Progress = no_progress,
) -> Result:
    """Check a source.

    What is wrong with it is in the result; errors are raised only for wrong arguments.

    Args:
        source: A path in any format, or a catalogue name.
        settings: Which rules, how severe, which limits.
        full: Decode every image; else only text, listings and headers are looked at.
        options: How to read it.
        jobs: Threads that decode.
        progress: Told of each image.

    """
    settings = (settings or Settings()).for_source(str(source))
    subject = load(source, options, full=full, jobs=jobs, progress=progress)
    return check(subject, settings, full=full)


def check(subject: Subject, settings: Settings, *, full: bool = True) -> Result:
    """Run the rules over what was gathered."""
    found: list[Finding] = []
    known = {code for explained in explain(subject) for code in explained.codes}
    rules = [
        rule
        for rule in RULES.values()
        if (settings.runs(rule) and (full or rule.needs is Needs.TEXT))
        # Who chooses rules does not mean that a source that is not there should pass.
        or (subject.info is None and rule.code in CANNOT_BE_OPENED)
    ]
    for rule in rules:
        limits = dict(settings.limits.get(rule.code, {}))
        findings = rule.run(subject, limits, settings.severity.get(rule.code))
        wanted = [f for f in findings if rule.code not in known or f.place.stream != "groundtruth"]
        found.extend(_shorten(wanted, settings.max_findings))
    return Result(
        source=subject.source,
        path=subject.path,
        is_folder=subject.is_folder,
        name=subject.info.name if subject.info else subject.source,
        format=subject.format,
        findings=tuple(sorted(found, key=_order)),
        rules=tuple(rule.code for rule in rules),
        images=sum(len(frames) for frames in subject.frames.values()),
        level="full" if full else "quick",
    )


def _shorten(findings: Iterable[Finding], limit: int) -> list[Finding]:
    """Keep the first findings of each file or stream, and say how many more there are."""
    kept: list[Finding] = []
    counts: Counter[tuple[str, str | None]] = Counter()
    last: dict[tuple[str, str | None], int] = {}
    for finding in findings:
        folder = finding.place.file.rpartition("/")[0] or finding.place.file
        key = (folder, finding.place.stream)
        counts[key] += 1
        if counts[key] <= limit:
            last[key] = len(kept)
            kept.append(finding)
    for key, index in last.items():
        more = counts[key] - limit
        if more > 0:
            kept[index] = replace(kept[index], message=f"{kept[index].message}; and {more} more like this")
    return kept


def _order(finding: Finding) -> tuple[str, int, int, str, str]:
    place = finding.place
    return place.file, place.line or 0, place.row or 0, finding.code, finding.message
