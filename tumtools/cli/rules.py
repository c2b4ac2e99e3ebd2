# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""`tumtools rules`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from tumtools.cli import options, output
from tumtools.cli.complete import RuleType

if TYPE_CHECKING:
    from tumtools.validate.rule import Rule


@click.command(name="rules")
@click.argument("code", required=False, type=RuleType())
@options.json_option
def command(code: str | None, as_json: bool) -> None:
    """List the rules of `validate`, or explain the rule CODE (a code or a name)."""
    from tumtools.errors import UsageError
    from tumtools.validate.document import describe
    from tumtools.validate.rules import RULES

    chosen = list(RULES.values())
    if code is not None:
        chosen = [rule for rule in chosen if code.upper() == rule.code or code.lower() == rule.slug]
        if not chosen:
            raise UsageError(f"no rule {code!r}", hint="see: tumtools rules")
    if as_json:
        output.print_json({"rules": [_document(rule) for rule in chosen]})
    elif code is not None:
        click.echo(describe(chosen[0]), nl=False)
    else:
        rows = [(rule.code, rule.slug, rule.severity.word, rule.title) for rule in chosen]
        output.print_table(rows, ("code", "name", "severity", "what it finds"))


def _document(rule: Rule) -> dict[str, object]:
    limits = {
        name: {"default": limit.default, "unit": limit.unit, "meaning": limit.meaning}
        for name, limit in rule.limits.items()
    }
    return {
        "code": rule.code,
        "slug": rule.slug,
        "severity": rule.severity.word,
        "title": rule.title,
        "why": rule.why,
        "how": rule.how,
        "mend": rule.mend,
        "limits": limits,
        "needs_pixels": rule.needs.name == "PIXELS",
        "enabled": rule.enabled,
        "fixable": rule.fixable,
    }
