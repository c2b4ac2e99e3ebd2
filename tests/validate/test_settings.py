# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Configuration: what it changes, where it is found, and how it says what it does not understand."""

from __future__ import annotations

from pathlib import Path

import pytest

from tumtools.errors import InputError, UsageError
from tumtools.validate import baseline
from tumtools.validate.engine import validate
from tumtools.validate.finding import Severity
from tumtools.validate.rules import RULES
from tumtools.validate.settings import Settings, find_config, parse_codes, read_config

FULL = Path(__file__).parents[2] / "fixtures" / "full"
CONFIG = """
[validate]
ignore = ["TUM202"]
extend-select = ["TUM205"]
fail-on = "warning"
max-findings = 3
[validate.severity]
TUM107 = "error"
[validate.limits.TUM103]
periods = 9
[[validate.path]]
match = "old/*"
ignore = ["TUM1"]
"""


def _config(tmp_path: Path, text: str, name: str = "tumtools.toml") -> Path:
    path = tmp_path / name
    path.write_text(text)
    return path


def test_everything_can_be_configured(tmp_path: Path) -> None:
    settings = read_config(_config(tmp_path, CONFIG))
    assert settings.fail_on is Severity.WARNING
    assert settings.severity == {"TUM107": Severity.ERROR}
    assert settings.limits == {"TUM103": {"periods": 9.0}}
    assert settings.max_findings == 3
    assert not settings.runs(RULES["TUM202"])
    assert settings.runs(RULES["TUM205"])
    assert settings.runs(RULES["TUM103"])
    assert not settings.for_source("old/a").runs(RULES["TUM103"])
    assert settings.for_source("new/a").runs(RULES["TUM103"])


def test_pyproject_has_the_same_keys_below_tool(tmp_path: Path) -> None:
    text = CONFIG.replace("[validate", "[tool.tumtools.validate").replace(
        "[[validate", "[[tool.tumtools.validate"
    )
    assert read_config(_config(tmp_path, text, "pyproject.toml")) == read_config(_config(tmp_path, CONFIG))


def test_the_nearest_file_is_found_from_below(tmp_path: Path) -> None:
    (tmp_path / "a" / "b").mkdir(parents=True)
    _config(tmp_path / "a", "[project]\nname = 'x'\n", "pyproject.toml")
    path = _config(tmp_path, CONFIG)
    assert find_config(tmp_path / "a" / "b") == path


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("[validate]\nselct = []", "selct"),
        ("[validate]\nselect = ['TUM9']", "TUM9"),
        ("[validate]\nselect = 3", "3"),
        ("[validate]\nfail-on = 'info'", "info"),
        ("[validate]\nmax-findings = 0", "max-findings"),
        ("[validate.severity]\nTUM101 = 'bad'", "TUM101"),
        ("[validate.limits.TUM101]\nx = 1", "TUM101.x"),
        ("[validate.limits.TUM103]\nperiods = 'many'", "periods"),
        ("[validate.limits.TUM999]\nx = 1", "TUM999"),
        ("[validat]\nselect = []", "validat"),
        ("validate = 3", "validate must be a table"),
        ("[[validate.path]]\nignore = []", "match"),
        ("[[validate.path]]\nmatch = 'a'\nfail-on = 'never'", "fail-on"),
    ],
)
def test_what_is_not_understood_is_named(tmp_path: Path, text: str, named: str) -> None:
    with pytest.raises(UsageError, match=named):
        read_config(_config(tmp_path, text))


@pytest.mark.parametrize("text", ["[validate", "\udcff"])
def test_a_file_that_is_no_toml_is_named(tmp_path: Path, text: str) -> None:
    path = tmp_path / "tumtools.toml"
    path.write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(InputError, match=r"tumtools\.toml"):
        read_config(path)


def test_rules_go_by_their_names_too(tmp_path: Path) -> None:
    assert parse_codes("missing-file,TUM2", "here") == ("TUM001", "TUM2")
    settings = read_config(
        _config(
            tmp_path, '[validate.severity]\nmissing-file = "info"\n[validate.limits.stamp-gap]\nperiods = 7'
        )
    )
    assert settings.severity == {"TUM001": Severity.INFO}
    assert settings.limits == {"TUM103": {"periods": 7.0}}
    with pytest.raises(UsageError, match="missing-fil'"):
        parse_codes("missing-fil", "here")


def test_codes_are_given_whole_or_by_their_beginning() -> None:
    assert parse_codes("tum1, TUM205", "here") == ("TUM1", "TUM205")
    assert Settings(select=("TUM1",)).runs(RULES["TUM101"])
    assert not Settings(select=("TUM1",)).runs(RULES["TUM201"])
    assert Settings(select=("ALL",)).runs(RULES["TUM205"])


def test_severity_and_limits_reach_the_findings() -> None:
    (quiet,) = {f.severity for f in validate(FULL, Settings(severity={"TUM202": Severity.INFO})).findings}
    assert quiet is Severity.INFO
    gravity = Settings(select=("TUM501",), limits={"TUM501": {"lowest": 9.9}})
    assert [f.code for f in validate(FULL, gravity).findings] == ["TUM501"]


def test_a_baseline_accepts_what_it_lists_and_nothing_else(tmp_path: Path) -> None:
    result = validate(FULL)
    path = tmp_path / "baseline.json"
    path.write_text(baseline.render([result]))
    accepted = baseline.accept(result, baseline.read(path))
    assert (len(accepted.findings), accepted.accepted) == (0, len(result.findings))
    first = baseline.render([result]).replace(result.findings[0].fingerprint, "0" * 32)
    path.write_text(first)
    assert baseline.accept(result, baseline.read(path)).findings == result.findings[:1]


@pytest.mark.parametrize(
    "text",
    ["", "[]", "{}", '{"schema_version": 2, "accepted": []}', '{"schema_version": 1, "accepted": [3]}'],
)
def test_what_is_no_baseline_is_named(tmp_path: Path, text: str) -> None:
    path = tmp_path / "baseline.json"
    path.write_text(text)
    with pytest.raises(InputError, match=r"baseline\.json"):
        baseline.read(path)
