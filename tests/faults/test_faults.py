# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Killed, interrupted, or without space: no half a result under the final name, and the next run succeeds."""

from __future__ import annotations

import os
import random
import resource
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from tumtools.digest import digest
from tumtools.images import png
from tumtools.sources import open_source

TARGETS = [("x.mcap", "mcap"), ("x.tgz", "tum"), ("x", "tum")]
FRAMES = 25


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a sequence of about 12 MB of noise, which takes a while to convert."""
    folder = tmp_path_factory.mktemp("source") / "noise"
    random_pixels = np.random.default_rng(0)
    for stream, shape, dtype in (("rgb", (240, 320, 3), np.uint8), ("depth", (480, 320), np.uint16)):
        (folder / stream).mkdir(parents=True)
        rows = []
        for number in range(FRAMES):
            name = f"{stream}/{number}.500000.png"
            (folder / name).write_bytes(png.encode(random_pixels.integers(0, 2**8, shape, dtype)))
            rows.append(f"{number}.500000 {name}\n")
        (folder / f"{stream}.txt").write_text("".join(rows))
    return folder


def _start(source: Path, target: Path, to: str, **more: object) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "tumtools", "convert", str(source), str(target), "--to", to]
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True, **more)  # type: ignore[call-overload]


def _finish(process: subprocess.Popen[str]) -> tuple[int, str]:
    _, err = process.communicate(timeout=120)
    return process.returncode, err


def _value(path: Path) -> str:
    with open_source(path) as sequence:
        return digest(sequence).value


@pytest.mark.slow
@pytest.mark.parametrize(("name", "to"), TARGETS)
def test_killed_at_random_moments(source: Path, tmp_path: Path, name: str, to: str) -> None:
    target = tmp_path / name
    begin = time.monotonic()
    assert _finish(_start(source, tmp_path / f"whole_{name}", to))[0] == 0
    duration = time.monotonic() - begin
    moments = random.Random(name)
    killed = 0
    for _ in range(7):
        process = _start(source, target, to)
        time.sleep(moments.uniform(0.2, 1.0) * duration)
        process.kill()
        code, _ = _finish(process)
        killed += code == -signal.SIGKILL
        if os.path.lexists(target):
            # It was renamed before the end came: then it is whole.
            assert _value(target) == _value(source)
            target.rename(tmp_path / f"done{killed}_{name}")
    assert killed
    assert _finish(_start(source, target, to))[0] == 0
    assert _value(target) == _value(source)
    assert [path.name for path in tmp_path.iterdir() if path.name.startswith(".")] == []


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize(("name", "to"), TARGETS)
def test_interrupted(source: Path, tmp_path: Path, name: str, to: str, number: signal.Signals) -> None:
    process = _start(source, tmp_path / name, to)
    while process.poll() is None and not any(tmp_path.iterdir()):
        time.sleep(0.005)
    process.send_signal(number)
    code, err = _finish(process)
    assert code == 130
    assert err.endswith("interrupted; nothing half-written was left behind\n")
    assert "Traceback" not in err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("name", "to"), TARGETS)
def test_a_limit_on_the_size_of_files(source: Path, tmp_path: Path, name: str, to: str) -> None:
    size = 1_000_000 if name != "x" else 50_000
    limit = partial(resource.setrlimit, resource.RLIMIT_FSIZE, (size, size))
    code, err = _finish(_start(source, tmp_path / name, to, preexec_fn=limit))
    assert code == 4
    assert err == f"error: {tmp_path / name}: cannot write: File too large\n"
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def small_disk(tmp_path: Path) -> Path:
    """Mount a file system of two megabytes."""
    folder = tmp_path / "small"
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=2m", "tmpfs", str(folder)]
    if not any(Path(place, "mount").exists() for place in ("/bin", "/usr/bin")):
        pytest.skip("there is no program `mount`")
    done = subprocess.run(mount, capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip(f"mounting a small disk is not permitted here: {done.stderr.strip()}")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


@pytest.mark.parametrize(("name", "to"), TARGETS)
def test_a_full_disk(source: Path, small_disk: Path, name: str, to: str) -> None:
    code, err = _finish(_start(source, small_disk / name, to))
    assert code == 4
    assert err.startswith(f"error: {small_disk / name}: cannot write: No space left on device\n  hint: free ")
    assert "Traceback" not in err
    assert "Exception ignored" not in err
    assert list(small_disk.iterdir()) == []
