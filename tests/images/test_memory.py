# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Buffers of images come from memory that the process has already."""

from __future__ import annotations

import platform
import subprocess
import sys

import pytest

ROUNDS = 50
FAULTS = """
import resource
from tumtools.images.parallel import ordered_map

def work(number):
    kept = [bytes([number]) * 2_000_000 for _ in range(3)]
    return sum(map(len, kept))

def faults():
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt

list(ordered_map(work, range(4), {jobs}))
before = faults()
list(ordered_map(work, range({rounds}), {jobs}))
print(faults() - before)
"""


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="other allocators have rules of their own")
@pytest.mark.parametrize("jobs", [1, 2])
def test_images_after_the_first_need_no_new_pages(jobs: int) -> None:
    program = FAULTS.format(jobs=jobs, rounds=ROUNDS)
    pages = int(subprocess.check_output([sys.executable, "-c", program], text=True, timeout=60))
    new_each_time = ROUNDS * 3 * 2_000_000 / 4096
    assert pages < new_each_time / 4
