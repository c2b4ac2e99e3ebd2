# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Other people's programs, run on our files. A missing one is a skip, but a failure in CI."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

NODE_READERS = Path(__file__).parent / "node"


def missing(what: str) -> None:
    """Skip the test, or fail it when the environment says that all programs must be there."""
    if os.environ.get("TUMTOOLS_REQUIRE_INTEROP") == "1":
        pytest.fail(f"{what} is required (TUMTOOLS_REQUIRE_INTEROP=1) and missing")
    pytest.skip(f"{what} is not installed")


def program(name: str, variable: str | None = None) -> str:
    """Return the path of a program, in the folder that a variable names or on the PATH."""
    found = shutil.which(name, path=os.environ.get(variable) if variable else None)
    if found is None:
        missing(name)
    return str(found)


def run(*arguments: str | Path) -> str:
    """Run a program and return what it prints; the test fails with its messages when it fails."""
    done = subprocess.run(arguments, capture_output=True, text=True, timeout=300, check=False)
    if done.returncode:
        pytest.fail(f"{arguments[0]} ended with {done.returncode}:\n{done.stdout}\n{done.stderr}")
    return done.stdout


def read_with_node(reader: str, *files: Path) -> list[dict[str, Any]]:
    """Decode every message of the files with one of the readers in `node/`.

    Returns:
        One dictionary a message: `topic`, `type`, `time` (nanoseconds, as text) and the decoded `message`.

    """
    node = program("node")
    modules = os.environ.get("TUMTOOLS_NODE_MODULES", str(NODE_READERS / "node_modules"))
    if not Path(modules, "@foxglove").is_dir():
        missing(f"the packages of tests/interop/node (npm ci there, or TUMTOOLS_NODE_MODULES; {modules})")
    return [json.loads(line) for line in run(node, NODE_READERS / f"{reader}.cjs", *files).splitlines()]


def system_python(*modules: str) -> str:
    """Return the system's Python, which has Debian's ROS packages, when it has these modules."""
    python = os.environ.get("TUMTOOLS_ROS_PYTHON", "/usr/bin/python3")
    imports = "; ".join(f"import {module}" for module in modules)
    if (
        not Path(python).exists()
        or subprocess.run([python, "-c", imports], capture_output=True, check=False).returncode
    ):
        missing(
            f"{python} with {', '.join(modules)} (Debian python3-rosbag python3-sensor-msgs python3-tf2-msgs)"
        )
    return python
