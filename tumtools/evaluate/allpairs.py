# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Relative pose error over all pairs of poses, exactly: equation 3 of the paper in O(n log n).

Sturm et al. (2012), section VI.A: for estimated poses P_i = (R_Pi, p_i) and true poses
Q_i = (R_Qi, q_i), i = 0 .. n-1, equally spaced in time,

    E_i(D)  = (Q_i^-1 Q_i+D)^-1 (P_i^-1 P_i+D)                            (1)
    RMSE(D) = sqrt(mean over i of |trans E_i(D)|^2)                        (2)
    RMSE    = mean over D of RMSE(D)                                       (3)

The paper calls (3) quadratic and samples. For the translation it need not be: with j = i + D, and
because a rotation does not change a norm,

    |trans E_i(D)| = |(q_j - q_i) - M_i (p_j - p_i)|,    M_i = R_Qi R_Pi^T.

RPE does not change when all P are moved by one rigid motion. So P is first put onto Q, which leaves
small d_i = q_i - p_i and small N_i = M_i - 1, and

    trans E = (d_j - d_i) - N_i (p_j - p_i) = d_j - N_i p_j - u_i,    u_i = d_i - N_i p_i.

With the unit quaternion (v, w) of M, N = 2 w [v]x - G / 2 where G = N^T N = 4 (|v|^2 1 - v v^T). So

    |trans E|^2 = |d_j|^2 + |u_i|^2 - 2 u_i.d_j + 2 (N_i^T u_i).p_j
                  - 4 w_i v_i.(p_j x d_j) + sum_km (G_i)_km (q_j)_k (p_j)_m

Each term is a product of something of i and something of j, so that its sum over i for every D is a
cross-correlation: 15 products of FFTs, added before one inverse FFT, and two prefix sums. That all
terms are as small as the errors is what keeps the digits: the plain expansion in p and q loses them
when the path is long and the errors are small.

Where rounding could still matter (an error at this D much smaller than at others), RMSE(D) is summed
up directly; that is O(n) for each such D, and there are few.

The rotational part is not a sum of such products. Its angle is 2 arccos |<s_i, s_j>| with the unit
quaternions s_i of M_i, so it is a matrix product in blocks: O(n^2) time, O(n) memory.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.evaluate.associate import MAX_DIFFERENCE, Method
from tumtools.evaluate.geometry import conjugate, matrices, multiply, normalised
from tumtools.evaluate.matching import match
from tumtools.evaluate.trajectories import clean, matched_note, scaled

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy.typing as npt

    from tumtools.evaluate.geometry import Array
    from tumtools.model.signals import Trajectory

_RELATIVE: Final = 1e-8
"""Relative error of a sum of squares that is let pass; a tenth of this and less is usual."""
_ABSOLUTE: Final = 1e-10
"""Error of an RMSE in metres that is let pass whatever its relative size."""
_BLOCK: Final = 64
"""Rows of the rotational part that are worked on at once."""


@dataclass(frozen=True, slots=True, eq=False)
class _Differences:
    """What is between an estimate and the ground truth once it is put onto it; columns are poses.

    Attributes:
        d: q - p, shape [3, n].
        p: Centred positions of the estimate, shape [3, n].
        v: Vector part of the quaternion of M, shape [3, n].
        w: Its real part, shape [n].

    """

    d: Array
    p: Array
    v: Array
    w: Array

    @classmethod
    def of(cls, groundtruth: Trajectory, estimate: Trajectory) -> _Differences:
        """Put the estimate onto the ground truth, by the mean of M and the mean of the positions."""
        relative = _relative(groundtruth, estimate)
        # The mean rotation: largest eigenvector of the sum of s s^T (Markley et al., "Averaging
        # quaternions", 2007), which does not mind that s and -s are the same rotation.
        common = np.linalg.eigh(relative.T @ relative)[1][:, -1]
        q = groundtruth.positions - groundtruth.positions.mean(axis=0)
        p = (estimate.positions - estimate.positions.mean(axis=0)) @ matrices(common[None])[0].T
        left = np.ascontiguousarray(multiply(relative, conjugate(common)[None]).T)
        return cls(np.ascontiguousarray((q - p).T), np.ascontiguousarray(p.T), left[:3], left[3])

    def turned(self, rows: slice, vectors: Array, sign: float = 1.0) -> Array:
        """Return N x of some poses, or N^T x with sign -1; vectors [3, k]."""
        twice = 2.0 * _cross(self.v[:, rows], vectors)
        return sign * self.w[rows] * twice + _cross(self.v[:, rows], twice)

    def terms(self, own: Array) -> Iterator[tuple[Array, Array]]:
        """Yield the factors in i and in j of all mixed terms; `own` is u."""
        back = self.turned(slice(None), own, -1.0)
        sine = self.w * self.v
        swept = _cross(self.p, self.d)
        for k in range(3):
            yield -2.0 * own[k], self.d[k]
            yield 2.0 * back[k], self.p[k]
            yield -4.0 * sine[k], swept[k]
        q, p, v = self.d + self.p, self.p, self.v
        for k, m in ((0, 1), (1, 2), (2, 0)):
            other = 3 - k - m
            yield 4.0 * (v[k] * v[k] + v[m] * v[m]), q[other] * p[other]
            yield -4.0 * v[k] * v[m], q[k] * p[m] + q[m] * p[k]

    def direct(self, distance: int) -> float:
        """Sum up |trans E_i(D)|^2 over i for one D."""
        near, far = slice(None, -distance), slice(distance, None)
        error = self.d[:, far] - self.d[:, near]
        error -= self.turned(near, self.p[:, far] - self.p[:, near])
        return float(np.sum(error * error))


def translational_rmse(groundtruth: Trajectory, estimate: Trajectory) -> Array:
    """Return the RMSE of the translational error for every distance in frames.

    Args:
        groundtruth: Q, n >= 2 poses, finite, quaternions not zero.
        estimate: P, the n poses that belong to them.

    Returns:
        RMSE(D) in metres for D = 1 .. n-1, shape [n - 1].

    """
    between = _Differences.of(groundtruth, estimate)
    n = between.d.shape[1]
    own = between.d - between.turned(slice(None), between.p)
    size = _fft_size(2 * n - 1)
    spectrum = np.zeros(size // 2 + 1, np.complex128)
    scale = 0.0
    for one, other in between.terms(own):
        spectrum += np.conj(np.fft.rfft(one, size)) * np.fft.rfft(other, size)
        scale += float(np.linalg.norm(one) * np.linalg.norm(other))
    sums = np.fft.irfft(spectrum, size)[:n]
    # The terms of one pose alone: |u_i|^2 over all i that have a partner, |d_j|^2 over the partners.
    sums += np.cumsum(np.sum(own * own, axis=0))[::-1]
    sums += np.cumsum(np.sum(between.d * between.d, axis=0)[::-1])[::-1]
    sums = sums[1:]
    counts = np.arange(n - 1, 0, -1)
    error = np.finfo(np.float64).eps * np.log2(size) * scale
    doubtful = (sums * _RELATIVE < error) & (error > _ABSOLUTE**2 * counts)
    for distance in np.flatnonzero(doubtful) + 1:
        sums[distance - 1] = between.direct(int(distance))
    result: Array = np.sqrt(np.maximum(sums, 0.0) / counts)
    return result


def _relative(groundtruth: Trajectory, estimate: Trajectory) -> Array:
    """Return the unit quaternions of M_i = R_Qi R_Pi^T, shape [n, 4]."""
    return multiply(normalised(groundtruth.quaternions), conjugate(normalised(estimate.quaternions)))


def _cross(a: Array, b: Array) -> Array:
    """Return the cross products of columns, shape [3, n]."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def _fft_size(at_least: int) -> int:
    """Return the smallest even number of the form 2^a 3^b 5^c that is not below `at_least`."""
    best = 1 << max(at_least - 1, 1).bit_length()
    five = 1
    while five < best:
        three = five
        while three < best:
            size = three * 2
            while size < at_least:
                size *= 2
            best = min(best, size)
            three *= 3
        five *= 5
    return best


def rotational_rmse(groundtruth: Trajectory, estimate: Trajectory) -> Array:
    """Return the RMSE of the rotational error for every distance in frames.

    O(n^2) time and O(n) memory; 1e-7 rad is the least angle it can tell from zero.

    Args:
        groundtruth: Q, n >= 2 poses, quaternions not zero.
        estimate: P, the n poses that belong to them.

    Returns:
        RMSE(D) in radians for D = 1 .. n-1, shape [n - 1].

    """
    turns = _relative(groundtruth, estimate)
    n = len(turns)
    sums = np.zeros(n)
    for start in range(0, n, _BLOCK):
        rows = turns[start : start + _BLOCK]
        # Columns beyond the end are filled with zero, so that every row has all distances.
        height, width = len(rows), n - start
        squares = np.zeros((height, width + height))
        cosines = np.minimum(np.abs(rows @ turns[start:].T), 1.0)
        np.square(2.0 * np.arccos(cosines), out=squares[:, :width])
        # Row r shifted left by r: column D is then distance D.
        stride = squares.strides[0]
        diagonals = np.lib.stride_tricks.as_strided(
            squares, (height, width), (stride + squares.itemsize, squares.itemsize), writeable=False
        )
        sums[:width] += diagonals.sum(axis=0)
    result: Array = np.sqrt(sums[1:] / np.arange(n - 1, 0, -1))
    return result


@dataclass(frozen=True, slots=True, eq=False)
class AllPairsResult:
    """Relative pose error over all pairs.

    Attributes:
        translation: Equation 3, metres: the mean of `translational_rmse`. The paper's sum runs to
            D = n, for which there is no pair; this is the mean over the distances that exist.
        rotation: The same of the rotational errors, degrees; None if they were not asked for.
        translational_rmse: RMSE(D), metres, for D = 1 .. n-1 frames, shape [n - 1].
        rotational_rmse: RMSE(D), degrees, shape [n - 1], or None.
        step: Median time between matched poses, ns: what one frame is.
        groundtruth_count: Poses of the ground truth.
        estimate_count: Poses of the estimate.
        largest_difference: Largest distance in time of matched poses, ns; 0 when interpolated.
        notes: What the user should know.

    """

    translation: float
    rotation: float | None
    translational_rmse: npt.NDArray[np.float64]
    rotational_rmse: npt.NDArray[np.float64] | None
    step: int
    groundtruth_count: int
    estimate_count: int
    largest_difference: int
    notes: tuple[str, ...]

    @property
    def poses(self) -> int:
        """How many poses were matched."""
        return len(self.translational_rmse) + 1

    @property
    def pairs(self) -> int:
        """How many pairs were compared."""
        return self.poses * (self.poses - 1) // 2


def evaluate_rpe_all_pairs(
    groundtruth: Trajectory,
    estimate: Trajectory,
    *,
    rotation: bool = True,
    max_difference: int = MAX_DIFFERENCE,
    offset: int = 0,
    scale: float = 1.0,
    method: Method = "tum",
    max_hole: int | None = None,
) -> AllPairsResult:
    """Measure the relative pose error over all distances (the paper's equation 3).

    Args:
        groundtruth: True poses.
        estimate: Poses to judge.
        rotation: Compute the rotational part too, which takes O(n^2) time.
        max_difference: Limit of the difference in time of matched poses, ns.
        offset: Added to the estimate's stamps, ns.
        scale: Multiplies the estimate's positions.
        method: How to associate.
        max_hole: Interpolate the ground truth at the estimate's stamps instead of associating, but
            not across holes longer than this, ns.

    Raises:
        InputError: Fewer than two poses match.
        UsageError: An argument makes no sense.

    """
    true = clean(groundtruth, "ground truth", rotations=True)
    judged = clean(estimate, "estimate", rotations=True)
    poses = scaled(judged.trajectory, scale)
    found = match(
        true.trajectory,
        poses,
        max_difference=max_difference,
        offset=offset,
        method=method,
        max_hole=max_hole,
    )
    matched = len(found.rows)
    possible = len(poses) if max_hole is not None else min(len(poses), len(true.trajectory))
    steps = np.diff(found.estimate.stamps)
    step = int(np.median(steps))
    notes = [*true.notes, *judged.notes, *matched_note(matched, possible)]
    uneven = int(np.count_nonzero(np.abs(steps - step) * 2 > step))
    if uneven:
        notes.append(
            f"{uneven} of {len(steps)} steps between matched poses differ by more than half from the "
            f"median of {step / 1e9:.4f} s: a distance in frames is not the same time everywhere"
        )
    translational = translational_rmse(found.groundtruth, found.estimate)
    rotational = np.degrees(rotational_rmse(found.groundtruth, found.estimate)) if rotation else None
    return AllPairsResult(
        translation=float(np.mean(translational)),
        rotation=None if rotational is None else float(np.mean(rotational)),
        translational_rmse=translational,
        rotational_rmse=rotational,
        step=step,
        groundtruth_count=len(true.trajectory),
        estimate_count=len(poses),
        largest_difference=found.largest_difference,
        notes=tuple(notes),
    )
