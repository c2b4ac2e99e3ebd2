# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Every command that README and docs show is run, page by page, in a folder that has what they name."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.evaluate.conftest import drifted, walk
from tumtools.evaluate.tables import aligned_trajectory

ROOT = Path(__file__).parents[2]
PAGES = sorted([ROOT / "README.md", *(ROOT / "docs").glob("*/*.md")])
FIXTURE = ROOT / "fixtures" / "full"
NEEDS_NETWORK = ("fetch",)
"""Commands that are only checked to exist with these options."""


def commands(page: Path) -> list[str]:
    """Return the lines of the page's console blocks that run tumtools."""
    blocks = re.findall(r"^```console\n(.*?)^```", page.read_text(), re.MULTILINE | re.DOTALL)
    lines = [line.strip().removeprefix("$ ") for block in blocks for line in block.splitlines()]
    return [line for line in lines if line.startswith("tumtools ")]


def write_files(page: Path, folder: Path) -> None:
    """Write the TOML files that a page shows: blocks whose first line is a comment with the file's name."""
    for name, text in re.findall(
        r"^```toml\n# (\w+\.toml)\n(.*?)^```", page.read_text(), re.MULTILINE | re.DOTALL
    ):
        (folder / name).write_text(text)


def folder_with_sequences(folder: Path) -> dict[str, str]:
    """Make the sequences and trajectories that pages name; return the environment with their cache."""
    names = ("rgbd_dataset_freiburg1_rpy", "rgbd_dataset_freiburg1_desk")
    for name in names:
        shutil.copytree(FIXTURE, folder / name)
    shutil.make_archive(str(folder / names[0]), "gztar", folder, names[0])
    (folder / f"{names[0]}.tar.gz").rename(folder / f"{names[0]}.tgz")
    (folder / "groundtruth.txt").write_text(aligned_trajectory(walk(600)))
    (folder / "estimate.txt").write_text(aligned_trajectory(drifted(walk(600))))
    return os.environ | {"TUMTOOLS_CACHE": str(folder / "cache"), "NO_COLOR": "1"}


@pytest.mark.parametrize("page", [page for page in PAGES if commands(page)], ids=lambda page: page.stem)
def test_commands_of_a_page_run(page: Path, tmp_path: Path) -> None:
    environment = folder_with_sequences(tmp_path)
    write_files(page, tmp_path)
    for line in commands(page):
        words = shlex.split(line, comments=True)[1:]
        if words[0] in NEEDS_NETWORK:
            words.append("--help")
        words = [re.sub(r"^fr1/(\w+)$", r"rgbd_dataset_freiburg1_\1", word) for word in words]
        done = subprocess.run(
            [sys.executable, "-m", "tumtools", *words],
            cwd=tmp_path,
            env=environment | {"PYTHONPATH": str(ROOT)},
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )
        assert done.returncode == 0, f"{line}\n{done.stdout}\n{done.stderr}"
