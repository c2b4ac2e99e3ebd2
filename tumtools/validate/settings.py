# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Which rules run, how severe they are, and their limits: from a file and from the command line."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, field, replace
from fnmatch import fnmatch
from pathlib import Path
from typing import TYPE_CHECKING, Final

from tumtools.errors import InputError, MissingInputError, UsageError
from tumtools.validate.finding import SEVERITY_WORDS, Severity
from tumtools.validate.rules import RULES

if TYPE_CHECKING:
    from collections.abc import Mapping

    from tumtools.validate.rule import Rule

ALL: Final = "ALL"
NEVER: Final = "never"
FAIL_ON: Final = ("error", "warning", NEVER)
CONFIG_NAMES: Final = ("tumtools.toml", "pyproject.toml")
_KEYS: Final = frozenset(
    {"select", "extend-select", "ignore", "severity", "limits", "fail-on", "max-findings", "path"}
)
_PATH_KEYS: Final = _KEYS - {"path", "fail-on"} | {"match"}
MAX_FINDINGS: Final = 10
_CODES: Final = {rule.slug: code for code, rule in RULES.items()}
_TABLE: Final = "validate"


@dataclass(frozen=True, slots=True)
class Settings:
    """What is checked, and how strictly.

    Attributes:
        select: Codes or beginnings of codes of the rules that run; None for all that are on by default.
        extend_select: The same, on top of `select`.
        ignore: The same, of the rules that do not run.
        severity: Severity by code, instead of the rule's own.
        limits: Values of limits by code and name.
        fail_on: Least severity that makes the result a failure; None for never.
        max_findings: Findings of one rule in one file that are listed one by one.
        paths: Patterns of sources, each with the keys that differ there.

    """

    select: tuple[str, ...] | None = None
    extend_select: tuple[str, ...] = ()
    ignore: tuple[str, ...] = ()
    severity: Mapping[str, Severity] = field(default_factory=dict)
    limits: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    fail_on: Severity | None = Severity.ERROR
    max_findings: int = MAX_FINDINGS
    paths: tuple[tuple[str, Mapping[str, object]], ...] = ()

    def runs(self, rule: Rule) -> bool:
        """Whether a rule runs."""
        if _matches(rule.code, self.ignore):
            return False
        if _matches(rule.code, self.extend_select):
            return True
        return rule.enabled if self.select is None else _matches(rule.code, self.select)

    def for_source(self, source: str) -> Settings:
        """Return the settings with those of the matching paths put on top."""
        settings = self
        text = Path(source).as_posix().removeprefix("./")
        for pattern, table in self.paths:
            if fnmatch(text, pattern) or fnmatch(Path(source).name, pattern):
                settings = _merge(settings, table)
        return settings


def _matches(code: str, prefixes: tuple[str, ...]) -> bool:
    return any(prefix == ALL or code.startswith(prefix) for prefix in prefixes)


def parse_codes(codes: object, where: str) -> tuple[str, ...]:
    """Check codes, beginnings of codes or names of rules, given as a list or with commas between them.

    Returns:
        Codes and beginnings of codes.

    Raises:
        UsageError: No rule is named or begins like that.

    """
    items = codes.split(",") if isinstance(codes, str) else codes
    if not isinstance(items, (list, tuple)) or not all(isinstance(item, str) for item in items):
        raise UsageError(f"{where}: expected a list of codes, not {codes!r}")
    return tuple(_parse_code(item.strip(), where) for item in items if item.strip())


def _parse_code(item: str, where: str) -> str:
    code = _CODES.get(item.lower(), item.upper())
    if code != ALL and not any(known.startswith(code) for known in RULES):
        raise UsageError(f"{where}: no rule {item!r}", hint="see: tumtools rules")
    return code


def find_config(start: Path) -> Path | None:
    """Return the nearest configuration file in a folder and those above it."""
    for folder in (start.resolve(), *start.resolve().parents):
        for name in CONFIG_NAMES:
            path = folder / name
            if path.is_file() and (name != "pyproject.toml" or _table(path)):
                return path
    return None


def read_config(path: Path) -> Settings:
    """Read a configuration file.

    Args:
        path: A `tumtools.toml` with a table `validate`, or a `pyproject.toml` with `tool.tumtools.validate`.

    Raises:
        InputError: It cannot be read.
        UsageError: A key or value is not understood.

    """
    table = _table(path)
    where = str(path)
    _check_keys(table, _KEYS, where)
    sections = table.get("path", [])
    if not isinstance(sections, list):
        raise UsageError(f"{where}: path must be a list of tables, [[validate.path]]")
    paths = []
    for section in sections:
        if not isinstance(section, dict) or not isinstance(section.get("match"), str):
            raise UsageError(f'{where}: each path needs match = "PATTERN"')
        _check_keys(section, _PATH_KEYS, where)
        _merge(Settings(), section, where)
        paths.append((section["match"], section))
    return replace(_merge(Settings(), table, where), paths=tuple(paths))


def _table(path: Path) -> Mapping[str, object]:
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise MissingInputError("there is no such configuration file", path=path) from None
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InputError(f"the configuration cannot be read: {error}", path=path) from error
    if path.name == "pyproject.toml":
        for key in ("tool", "tumtools"):
            document = _section(document, key, path)
    unknown = sorted(set(document) - {_TABLE})
    if unknown:
        raise UsageError(
            f"unknown key {unknown[0]!r}", path=path, hint=f"settings of validate stand in the table {_TABLE}"
        )
    return _section(document, _TABLE, path)


def _section(table: Mapping[str, object], key: str, path: Path) -> dict[str, object]:
    value = table.get(key, {})
    if not isinstance(value, dict):
        raise UsageError(f"{key} must be a table", path=path)
    return value


def _check_keys(table: Mapping[str, object], known: frozenset[str], where: str) -> None:
    unknown = sorted(set(table) - known)
    if unknown:
        raise UsageError(f"{where}: unknown key {unknown[0]!r}", hint=f"keys: {', '.join(sorted(known))}")


def _merge(settings: Settings, table: Mapping[str, object], where: str = "path section") -> Settings:
    """Put a table on top of settings."""
    changed = settings
    if "select" in table:
        changed = replace(changed, select=parse_codes(table["select"], where))
    if "extend-select" in table:
        added = parse_codes(table["extend-select"], where)
        changed = replace(changed, extend_select=changed.extend_select + added)
    if "ignore" in table:
        changed = replace(changed, ignore=changed.ignore + parse_codes(table["ignore"], where))
    if "severity" in table:
        changed = replace(changed, severity={**changed.severity, **_severities(table["severity"], where)})
    if "limits" in table:
        changed = replace(changed, limits={**changed.limits, **_limits(table["limits"], where)})
    if "fail-on" in table:
        changed = replace(changed, fail_on=parse_fail_on(table["fail-on"], where))
    if "max-findings" in table:
        value = table["max-findings"]
        if not isinstance(value, int) or value < 1:
            raise UsageError(f"{where}: max-findings must be a whole number from 1 on, not {value!r}")
        changed = replace(changed, max_findings=value)
    return changed


def parse_fail_on(word: object, where: str) -> Severity | None:
    """Return the severity of a word of `FAIL_ON`.

    Raises:
        UsageError: It is none.

    """
    if word not in FAIL_ON:
        raise UsageError(f"{where}: fail-on must be one of {', '.join(FAIL_ON)}, not {word!r}")
    return None if word == NEVER else Severity.of_word(str(word))


def _severities(table: object, where: str) -> dict[str, Severity]:
    if not isinstance(table, dict):
        raise UsageError(f'{where}: severity must be a table, code = "warning"')
    result = {}
    for name, word in table.items():
        code = _CODES.get(name, name)
        if code not in RULES or word not in SEVERITY_WORDS:
            raise UsageError(
                f"{where}: severity.{name} = {word!r}: expected a rule and one of {', '.join(SEVERITY_WORDS)}"
            )
        result[code] = Severity.of_word(word)
    return result


def _limits(table: object, where: str) -> dict[str, dict[str, float]]:
    if not isinstance(table, dict):
        raise UsageError(f"{where}: limits must be tables, [validate.limits.TUM103]")
    result: dict[str, dict[str, float]] = {}
    for rule, values in table.items():
        code = _CODES.get(rule, rule)
        if code not in RULES:
            raise UsageError(f"{where}: limits.{rule}: no rule {rule!r}", hint="see: tumtools rules")
        if not isinstance(values, dict):
            raise UsageError(f"{where}: limits.{rule} must be a table")
        for name, value in values.items():
            is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
            if name not in RULES[code].limits or not is_number:
                raise UsageError(
                    f"{where}: limits.{rule}.{name} = {value!r} is not understood",
                    hint=f"see: tumtools rules {code}",
                )
            result.setdefault(code, {})[name] = float(value)
    return result
