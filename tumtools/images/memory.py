# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Let the allocator keep the memory of one image for the next one."""

from __future__ import annotations

from functools import cache
from typing import Final

import numpy as np

_LARGEST: Final = 16 * 2**20
"""Blocks up to this size are kept; pixels of an image in 4K are larger, of a camera of the field not."""


@cache
def keep_freed_memory() -> None:
    """Make blocks as large as an image come from memory that the process has already.

    glibc takes each large block from the kernel and gives it back when it is freed, so that every buffer of
    every image pays for new, zeroed pages: a fourth to a half of the time of a conversion. What is large is
    told from the blocks freed so far, up to 32 MB (mallopt(3), M_MMAP_THRESHOLD), and as much as twice that
    is kept at the end of a heap. So a block that is taken and freed once, and never touched, settles it. To
    other allocators this is one more block; limits that the user sets (MALLOC_MMAP_THRESHOLD_) stay.
    """
    np.empty(_LARGEST, np.uint8)
