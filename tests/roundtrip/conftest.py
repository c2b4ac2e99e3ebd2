# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Sources for the matrix."""

from __future__ import annotations

import pytest

pytest.register_assert_rewrite("tests.roundtrip.harness")

from tests.roundtrip.base import Sources, make_base  # noqa: E402 - after its asserts are rewritten


@pytest.fixture(scope="session")
def sources(tmp_path_factory: pytest.TempPathFactory) -> Sources:
    """Return the small sequence in every format."""
    folder = tmp_path_factory.mktemp("roundtrip")
    return Sources(make_base(folder), folder)
