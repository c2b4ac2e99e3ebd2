# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Random choices that are the same on every machine, for every version of Python and NumPy.

The benchmark's scripts use Python's `random`, whose numbers differ between Python 2 and 3. Here the
k-th random number is a fixed function of seed and k: SplitMix64 (Steele, Lea, Flood, "Fast
splittable pseudorandom number generators", 2014), which is a few integer operations anywhere.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt


def splitmix64(seed: int, count: int) -> npt.NDArray[np.uint64]:
    """Return the first `count` outputs of SplitMix64 for a seed (0 .. 2**64 - 1), shape [count]."""
    state = np.uint64(seed) + np.arange(1, count + 1, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    state = (state ^ (state >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    state = (state ^ (state >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return state ^ (state >> np.uint64(31))


def random_pairs(n: int, count: int, seed: int = 0) -> npt.NDArray[np.intp]:
    """Draw pairs (i, j), 0 <= i, j < n, uniformly and with replacement, shape [2, count].

    Output 2k modulo n is the k-th i, output 2k + 1 modulo n the k-th j.
    """
    numbers = (splitmix64(seed, 2 * count) % np.uint64(n)).astype(np.intp)
    return numbers.reshape(-1, 2).T


def sample(n: int, count: int, seed: int = 0) -> npt.NDArray[np.intp]:
    """Choose `count` of n without replacement, ascending: those with the smallest outputs."""
    if count >= n:
        return np.arange(n)
    return np.sort(np.argsort(splitmix64(seed, n), kind="stable")[:count])
