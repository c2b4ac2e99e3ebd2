# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What docs/how-to/batch.md shows of a bucket and of a GitHub matrix works as printed."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from typing import TYPE_CHECKING, Any

import pytest
import requests

from tests.batch.batches import ENVIRONMENT, FIXTURES, ROOT
from tests.batch.s3_server import s3_server
from tests.docs.test_commands import write_files
from tumtools.convert import convert
from tumtools.sources import open_source

if TYPE_CHECKING:
    from pathlib import Path

pytestmark = [pytest.mark.interop, pytest.mark.slow]

PAGE = ROOT / "docs" / "how-to" / "batch.md"
SECRETS = {"AWS_ACCESS_KEY_ID": "the-key-id", "AWS_SECRET_ACCESS_KEY": "the-secret-key"}


def workflow() -> dict[str, Any]:
    """Return the workflow that the page shows; moto needs a reader of YAML anyway."""
    import yaml

    (text,) = re.findall(r"^```yaml\n(.*?)^```", PAGE.read_text(), re.MULTILINE | re.DOTALL)
    document: dict[str, Any] = yaml.safe_load(text)
    return document


def filled(text: str, **contexts: dict[str, object]) -> str:
    """Put values in place of `${{ context.name }}`."""
    return re.sub(r"\$\{\{ (\w+)\.(\w+) \}\}", lambda match: str(contexts[match[1]][match[2]]), text)


def do(
    steps: list[dict[str, Any]], folder: Path, artifacts: Path, environment: dict[str, str], part: int
) -> int:
    """Do the steps of a job that are not about installing; return how many commands were run."""
    count = 0
    for step in steps:
        action = step.get("uses", "").partition("@")[0].rpartition("/")[2]
        if action == "checkout":
            write_files(PAGE, folder)
        elif action == "upload-artifact":
            shutil.copy(folder / step["with"]["path"], artifacts / step["with"]["name"])
        elif action == "download-artifact":
            shutil.copy(artifacts / step["with"]["name"], folder / "plan.json")
        elif "run" in step and not step["run"].startswith("pip "):
            program, *words = shlex.split(filled(step["run"], matrix={"part": part}))
            assert program == "tumtools"
            subprocess.run(
                [sys.executable, "-m", "tumtools", *words], cwd=folder, env=environment, check=True
            )
            count += 1
    return count


def test_the_matrix_exports_a_bucket_as_printed(tmp_path: Path) -> None:
    from tumtools.batch.stores.remote import RemoteStore

    document = workflow()
    with s3_server(0.0) as (_, reached):
        for name in ("lab-recordings", "lab-exports"):
            requests.put(f"{reached['AWS_ENDPOINT_URL']}/{name}", timeout=60).raise_for_status()
        for number in range(5):
            with (
                RemoteStore("s3://lab-recordings").output(f"day/{number}.bag") as place,
                open_source(FIXTURES / "early") as sequence,
            ):
                convert(sequence, place, "rosbag1")
        # What leads to the test's server, and nothing else of what it sets.
        base = ENVIRONMENT | {key: reached[key] for key in ("AWS_ENDPOINT_URL", "AWS_ALLOW_HTTP")}
        base = {key: value for key, value in base.items() if key not in SECRETS and key != "AWS_REGION"}
        environment = base | {key: filled(text, secrets=SECRETS) for key, text in document["env"].items()}
        artifacts = tmp_path / "artifacts"
        artifacts.mkdir()
        jobs = document["jobs"]
        assert jobs["export"]["needs"] == "plan"
        for part in (0, *jobs["export"]["strategy"]["matrix"]["part"]):
            folder = tmp_path / f"machine{part}"
            folder.mkdir()
            assert do(jobs["export" if part else "plan"]["steps"], folder, artifacts, environment, part) == 1
        names = list(RemoteStore("s3://lab-exports/2026").names(""))
    assert [name for name in names if name.endswith(".mcap")] == [
        f"{number}/{number}.mcap" for number in range(5)
    ]
    assert os.listdir(tmp_path / "machine1") == ["plan.json"]  # noqa: PTH208 - names only
