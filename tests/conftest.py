# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Fixtures for all tests."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import settings

# The machines of CI are slow now and then, which says nothing about the code. There the cases are the same in
# each run, so that a gate does not fail by chance; on a developer's machine they are new each time.
settings.register_profile("tumtools", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "tumtools")

# Many tests start the program, which would be compiled anew each time where bytecode is not to be written.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)


def pytest_make_parametrize_id(val: object, argname: str) -> str | None:
    """Number cases of long bytes: they may hold the time of their making; workers must agree on names."""
    return argname if isinstance(val, bytes) and len(val) > 16 else None


@pytest.fixture(scope="session")
def real_data() -> Path:
    """Folder of the real data; the test is skipped where it is absent."""
    default = Path(__file__).parents[1] / ".." / "shared" / "data"
    folder = Path(os.environ.get("TUMTOOLS_REAL_DATA", default)).resolve()
    if not folder.is_dir():
        pytest.skip(f"no real data at {folder}; set TUMTOOLS_REAL_DATA")
    return folder


@pytest.fixture(scope="session")
def real_sequence(real_data: Path) -> Path:
    """Return the 90 colour and 90 depth images of fr1/rpy with their text files."""
    return real_data / "rgbd_dataset_freiburg1_rpy"
