# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Each single fault is found, under its code, and nothing else is called an error."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tests.validate.faults import FAULTS, Fault
from tumtools.convert import ConvertOptions, convert
from tumtools.formats.options import WriteOptions
from tumtools.synthetic import synthesize
from tumtools.validate.engine import validate
from tumtools.validate.finding import Severity
from tumtools.validate.rules import RULES

if TYPE_CHECKING:
    from tumtools.validate.engine import Result


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("faults") / "good"
    convert(synthesize(60, width=96, height=72), folder, "tum", WriteOptions(), ConvertOptions(verify=False))
    return folder


def _codes(result: Result, least: Severity) -> set[str]:
    return {finding.code for finding in result.findings if finding.severity >= least}


def test_the_good_sequence_is_clean_but_for_its_size(good: Path) -> None:
    assert _codes(validate(good), Severity.INFO) == {"TUM202"}


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_a_fault_is_found_and_nothing_else_is_an_error(fault: Fault, good: Path, tmp_path: Path) -> None:
    folder = Path(shutil.copytree(good, tmp_path / "bad"))
    fault.inject(folder)
    result = validate(folder)
    assert fault.code in _codes(result, Severity.INFO)
    assert _codes(result, Severity.ERROR) <= {fault.code, *fault.errors}


def test_there_are_enough_kinds_of_faults_and_every_folder_rule_has_one() -> None:
    assert len(FAULTS) >= 60
    elsewhere = {code for code in RULES if code.startswith(("TUM6", "TUM7"))} | {"TUM205"}
    assert {fault.code for fault in FAULTS} == set(RULES) - elsewhere
