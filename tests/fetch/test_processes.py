# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Whole processes: killed at any moment, interrupted, two at once."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import time
from typing import TYPE_CHECKING

import pytest

from tests.fetch.conftest import Place, make_tar, sequence_files
from tumtools.fetch.download import BLOCK

if TYPE_CHECKING:
    from pathlib import Path

LARGE = make_tar(sequence_files(3_000_000))


def catalogue(place: Place) -> Path:
    path = place.folder / "mine.json"
    path.write_text(
        json.dumps(
            {
                "sequences": [
                    {
                        "name": "rgbd_dataset_mini",
                        "short": "mini/one",
                        "files": {"tgz": {"urls": [place.server.url("/f/mini.tgz")]}},
                    }
                ]
            }
        )
    )
    return path


def start(place: Place, *arguments: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "tumtools", "fetch", "mini/one", "--catalogue", str(catalogue(place))]
    return subprocess.Popen(
        [*command, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )


def wait_until_sent(place: Place, count: int, process: subprocess.Popen[str]) -> None:
    while place.server.sent < count and process.poll() is None:
        time.sleep(0.001)


def test_killed_at_twenty_moments_it_goes_on_where_it_was(place: Place) -> None:
    place.serve(LARGE, block=1 << 14, pause=0.001)
    generator = random.Random(5)
    moments = sorted(generator.sample(range(len(LARGE)), 17))
    offsets: list[int] = []
    sent_before: list[int] = []
    for moment in [*moments, len(LARGE), len(LARGE), len(LARGE)]:
        process = start(place)
        already = place.server.sent
        base = offsets[-1] if offsets else 0
        wait_until_sent(place, already + max(1, moment - base), process)
        if moment == len(LARGE):  # while it unpacks and puts things in place
            time.sleep(generator.uniform(0, 0.05))
        process.send_signal(signal.SIGKILL)
        process.communicate()
        part = place.cache / "rgbd_dataset_mini.tgz.part"
        offsets.append(part.stat().st_size if part.exists() else len(LARGE))
        sent_before.append(sum(r.sent for r in place.server.requests))
    process = start(place)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    assert "mini/one  cache/rgbd_dataset_mini" in out
    files = {path.name: path.read_bytes() for path in (place.cache / "rgbd_dataset_mini").rglob("*.*")}
    assert (
        files["1305031102.175304.png"]
        == sequence_files(3_000_000)["rgbd_dataset_mini/rgb/1305031102.175304.png"]
    )
    # Each run asked for exactly what was missing, and a kill cost less than one block.
    kills = len(place.server.requests) - 1
    assert kills >= 15
    previous_end = 0
    for request in place.server.requests:
        begin = request.start or 0
        assert begin in {0, *offsets}
        assert previous_end - begin <= BLOCK
        previous_end = begin + request.sent
    assert place.server.sent - len(LARGE) <= kills * BLOCK
    assert sorted(path.name for path in place.cache.iterdir()) == [".tumtools", "rgbd_dataset_mini"]
    assert not list((place.cache / ".tumtools").glob("*.staging"))


def test_two_processes_share_one_download(place: Place) -> None:
    place.serve(LARGE, block=1 << 15, pause=0.005)
    first = start(place)
    wait_until_sent(place, 1, first)
    second = start(place)
    results = [process.communicate(timeout=60) for process in (first, second)]
    assert [first.returncode, second.returncode] == [0, 0], results
    assert "another process is fetching it; waiting" in results[1][1]
    assert "was there" in results[1][0]
    assert place.server.sent == len(LARGE)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_interrupted_it_ends_with_130_at_once_and_can_go_on(place: Place, number: signal.Signals) -> None:
    served = place.serve(LARGE, stall=True)
    process = start(place)
    wait_until_sent(place, len(LARGE) // 2, process)
    begin = time.monotonic()
    process.send_signal(number)
    _, err = process.communicate(timeout=20)
    assert process.returncode == 130, err
    assert time.monotonic() - begin < 5  # not the time-out of the stalled connection
    assert "Traceback" not in err
    part = (place.cache / "rgbd_dataset_mini.tgz.part").stat().st_size
    served.stall = False
    process = start(place)
    process.communicate(timeout=60)
    assert process.returncode == 0
    assert place.server.requests[-1].start == part
