# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What has been read of a mapped file does not stay in memory."""

from __future__ import annotations

import mmap
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from tests.memory import SECOND, START, Memory
from tumtools.convert import ConvertOptions, convert
from tumtools.formats.options import WriteOptions
from tumtools.formats.ros.pages import Pages
from tumtools.images.codec import image_of_pixels

if TYPE_CHECKING:
    from tumtools.model.image import Image

MB = 2**20


class Mapping:
    """Counts how often its pages are given back."""

    def __init__(self) -> None:
        self.released = 0

    def madvise(self, advice: int) -> None:
        assert advice == mmap.MADV_DONTNEED
        self.released += 1


@pytest.mark.parametrize(("step", "nbytes", "reads"), [(MB, 1, 385), (MB, MB - 1, 25), (0, 1, 10_000)])
def test_pages_are_given_back_when_24_mb_have_been_read(step: int, nbytes: int, reads: int) -> None:
    mapping = Mapping()
    pages = Pages(mapping)  # type: ignore[arg-type]  # all that it needs of one
    for number in range(reads - 1):
        pages.read(number * step, nbytes)
    assert mapping.released == 0
    pages.read(reads * step, nbytes)
    assert mapping.released == (1 if step else 0)


class Noisy(Memory):
    """Colour images that do not compress, 900 kB each."""

    def _load(self, stream: str, row: int) -> Image:
        random = np.random.default_rng([len(stream), row])
        return image_of_pixels(random.integers(0, 256, (480, 640, 3), np.uint8), "rgb8")


PROGRAM = """
import sys
from pathlib import Path
from tumtools.sources import open_source
with open_source(Path(sys.argv[1])) as sequence:
    assert sum(frame.load().nbytes for frame in sequence.images()) > 180_000_000
status = dict(line.split(":", 1) for line in open("/proc/self/status"))
print(int(status["VmHWM"].split()[0]) // 1024)
"""


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="needs /proc")
@pytest.mark.parametrize("to", ["mcap", "rosbag1"])
def test_reading_a_long_recording_takes_no_more_memory_than_a_short_one(to: str, tmp_path: Path) -> None:
    sequence = Noisy({"rgb": [START + number * SECOND // 30 for number in range(200)]})
    target = tmp_path / ("x.bag" if to == "rosbag1" else "x.mcap")
    options = WriteOptions(color_encoding="rgb8", compression="none")
    convert(sequence, target, to, options, ConvertOptions(verify=False, digest=False))
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, str(target)], check=True, capture_output=True, text=True
    )
    assert int(done.stdout) < 150, "MB, of a file of 180"
