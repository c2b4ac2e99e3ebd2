# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The room is built once for all."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

from tumtools.synthetic.bake import bake


def test_threads_that_want_the_same_room_build_it_once() -> None:
    with ThreadPoolExecutor(4) as pool:
        rooms = list(pool.map(bake, [1] * 4, [0.05] * 4))
    assert len({id(room) for room in rooms}) == 1
