# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The public API does what its docstring shows."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np

from tumtools import api

FIXTURE = Path(__file__).parents[1] / "fixtures" / "full"


def test_open_convert_and_compare(tmp_path: Path) -> None:
    with api.open(FIXTURE) as sequence:
        report = api.convert(sequence, tmp_path / "x.mcap", "mcap")
        assert report.losses == ()
        with api.open(tmp_path / "x.mcap") as result:
            assert api.diff(sequence, result).same
            assert api.digest(sequence).value == api.digest(result).value


def test_frames_give_pixels() -> None:
    with api.open(FIXTURE) as sequence:
        frame = next(sequence.images(["depth"]))
        pixels = api.pixels_of(frame.load())
    assert pixels.dtype == np.uint16
    assert pixels.shape == (48, 64)


def test_everything_named_is_there() -> None:
    assert all(hasattr(api, name) for name in api.__all__)


def test_importing_the_package_imports_nothing_heavy() -> None:
    heavy = "numpy", "PIL", "requests", "rosbags", "matplotlib", "tqdm"
    code = f"import sys, tumtools.cli.main; print([name for name in {heavy!r} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
