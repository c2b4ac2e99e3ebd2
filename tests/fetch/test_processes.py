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
import threading
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
    part = place.cache / "rgbd_dataset_mini.tgz.part"
    folder = place.cache / "rgbd_dataset_mini"
    process: subprocess.Popen[str]

    def on_disk() -> int:
        if folder.exists():
            return len(LARGE)
        return part.stat().st_size if part.exists() else 0

    def pace(position: int) -> None:
        """Stay at most a block ahead of what is on the disk, and of the moment of the next kill."""
        while position > min(on_disk(), moment) + BLOCK and process.poll() is None:
            time.sleep(0.0005)

    place.serve(LARGE, block=1 << 14, pace=pace)
    generator = random.Random(5)
    moments = sorted(generator.sample(range(len(LARGE) - 2 * BLOCK), 17))
    moments += [len(LARGE)] * 3
    offsets = [0]
    for moment in moments:
        requests = len(place.server.requests)
        process = start(place)
        while process.poll() is None and (len(place.server.requests) == requests or on_disk() < moment):
            if offsets[-1] == len(LARGE) and not folder.exists():
                break  # nothing to ask for any more
            time.sleep(0.0005)
        if moment == len(LARGE):  # while it unpacks and puts things in place
            time.sleep(generator.uniform(0, 0.4 if offsets[-1] == moment else 0.05))
        process.send_signal(signal.SIGKILL)
        process.communicate()
        offsets.append(on_disk())
    process = start(place)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    assert "mini/one  cache/rgbd_dataset_mini" in out
    image = folder / "rgb" / "1305031102.175304.png"
    assert image.read_bytes() == sequence_files(3_000_000)[f"rgbd_dataset_mini/rgb/{image.name}"]
    # Each run asked for exactly what was not on the disk, and a kill cost less than a block.
    starts = [start or 0 for start in place.server.starts]
    assert len(starts) >= 17
    assert starts == [offset for offset in offsets if offset < len(LARGE)][: len(starts)]
    assert place.server.sent - len(LARGE) <= len(starts) * BLOCK
    assert sorted(path.name for path in place.cache.iterdir()) == [".tumtools", "rgbd_dataset_mini"]
    assert not list((place.cache / ".tumtools").glob("*.staging"))


def test_two_processes_share_one_download(place: Place) -> None:
    gate = threading.Event()
    place.serve(LARGE, pace=lambda position: gate.wait(30) if position > len(LARGE) // 2 else None)
    first = start(place)
    wait_until_sent(place, 1, first)
    second = start(place)
    assert second.stderr is not None
    waiting = second.stderr.readline()
    gate.set()
    results = [process.communicate(timeout=60) for process in (first, second)]
    assert [first.returncode, second.returncode] == [0, 0], results
    assert "another process is fetching it; waiting" in waiting
    assert "was there" in results[1][0]
    assert place.server.sent == len(LARGE)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_interrupted_it_ends_with_130_at_once_and_can_go_on(place: Place, number: signal.Signals) -> None:
    served = place.serve(LARGE, stall=True)
    process = start(place)
    wait_until_sent(place, len(LARGE) // 2, process)
    begin = time.monotonic()
    process.send_signal(number)
    _, err = process.communicate(timeout=25)
    assert process.returncode == 130, err
    assert time.monotonic() - begin < 15  # not the time-out of the stalled connection
    assert "Traceback" not in err
    part = (place.cache / "rgbd_dataset_mini.tgz.part").stat().st_size
    served.stall = False
    process = start(place)
    process.communicate(timeout=60)
    assert process.returncode == 0
    assert place.server.requests[-1].start == part
