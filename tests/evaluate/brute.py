# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The definitions, written down without any thought of speed."""

from __future__ import annotations

from decimal import Decimal
from functools import cache

import numpy as np


def greedy(first: list[int], second: list[int], limit: int, offset: int = 0) -> list[tuple[int, int]]:
    """All differences, sorted, taken in turn: pairs of stamps in order of the first.

    Equal differences stand in the order that the floats of the scripts have.
    """

    def rounded(a: int, b: int) -> float:
        text_a, text_b, shift = (f"{Decimal(x).scaleb(-9):f}" for x in (a, b, offset))
        return abs(float(text_a) - (float(text_b) + float(shift)))

    candidates = sorted(
        (abs(a - b - offset), rounded(a, b), a, b)
        for a in set(first)
        for b in set(second)
        if abs(a - b - offset) < limit
    )
    free_first, free_second, pairs = set(first), set(second), []
    for _, _, a, b in candidates:
        if a in free_first and b in free_second:
            free_first.remove(a)
            free_second.remove(b)
            pairs.append((a, b))
    return sorted(pairs)


def optimal_score(first: list[int], second: list[int], limit: int) -> tuple[int, int]:
    """(pairs, sum of differences) of the best choice, by trying every one, crossing ones included."""
    a = sorted(set(first))
    b = sorted(set(second))

    @cache
    def best(row: int, free: frozenset[int]) -> tuple[int, int]:
        if row == len(a):
            return 0, 0
        count, cost = best(row + 1, free)
        score = (count, -cost)
        for j in free:
            if abs(a[row] - j) < limit:
                count, cost = best(row + 1, free - {j})
                score = max(score, (count + 1, -(cost + abs(a[row] - j))))
        return score[0], -score[1]

    return best(0, frozenset(b))


def matrices(quaternions: np.ndarray) -> np.ndarray:
    """Rotation matrices from quaternions x y z w by the textbook formula, one at a time."""
    out = []
    for x, y, z, w in quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True):
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        out.append(np.eye(3) + 2 * w * cross + 2 * cross @ cross)
    return np.array(out)


def translational(p: np.ndarray, rp: np.ndarray, q: np.ndarray, rq: np.ndarray) -> np.ndarray:
    """RMSE(D) of equation 2, translation (m), D = 1 .. n-1; p, rp estimated, q, rq true."""
    out = []
    for d in range(1, len(p)):
        rel_p = np.einsum("nij,ni->nj", rp[:-d], p[d:] - p[:-d])
        rel_q = np.einsum("nij,ni->nj", rq[:-d], q[d:] - q[:-d])
        out.append(np.sqrt(np.mean(np.sum((rel_p - rel_q) ** 2, axis=1))))
    return np.array(out)


def rotational(rp: np.ndarray, rq: np.ndarray) -> np.ndarray:
    """RMSE(D) of equation 2, rotation (rad), D = 1 .. n-1."""
    out = []
    for d in range(1, len(rp)):
        rot_p = np.einsum("nji,njk->nik", rp[:-d], rp[d:])
        rot_q = np.einsum("nji,njk->nik", rq[:-d], rq[d:])
        error = np.einsum("nji,njk->nik", rot_q, rot_p)
        skew = error - np.swapaxes(error, 1, 2)
        sine = np.sqrt(skew[:, 2, 1] ** 2 + skew[:, 0, 2] ** 2 + skew[:, 1, 0] ** 2)
        angle = np.arctan2(sine, np.trace(error, axis1=1, axis2=2) - 1)
        out.append(np.sqrt(np.mean(angle**2)))
    return np.array(out)
