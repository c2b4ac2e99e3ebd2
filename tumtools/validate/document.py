# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The page of a rule, as Markdown; docs, `tumtools rules CODE` and SARIF's help are made of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tumtools.validate.rule import Rule


def describe(rule: Rule, heading: str = "#") -> str:
    """Return the page of a rule.

    Args:
        rule: The rule.
        heading: Marks of its heading; those of its sections have one more.

    """
    level = "`--full`" if rule.needs.name == "PIXELS" else "`--quick` and `--full`"
    facts = [f"Severity: {rule.severity.word}", f"level: {level}"]
    if not rule.enabled:
        facts.append("off unless selected")
    if rule.fixable:
        facts.append("mended by `--fix`")
    lines = [
        f"{heading} {rule.code} {rule.slug}",
        "",
        rule.title,
        "",
        f"{'; '.join(facts)}.",
        "",
        f"{heading}# Why it matters",
        "",
        rule.why,
        "",
        f"{heading}# How it is measured",
        "",
        rule.how,
        "",
        f"{heading}# How to mend it",
        "",
        rule.mend,
    ]
    if rule.limits:
        lines += ["", f"{heading}# Limits", "", "| name | default | unit | meaning |", "|---|--:|---|---|"]
        lines += [
            f"| {name} | {limit.default:g} | {limit.unit} | {limit.meaning} |"
            for name, limit in rule.limits.items()
        ]
    return "\n".join(lines) + "\n"
