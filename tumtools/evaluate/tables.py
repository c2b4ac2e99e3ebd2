# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Results as text, in the form of the benchmark's scripts and in ours."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.model.time import decimals_needed, format_stamp

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    import numpy.typing as npt

    from tumtools.evaluate.allpairs import AllPairsResult
    from tumtools.evaluate.ate import AteResult
    from tumtools.evaluate.rpe import RpeResult
    from tumtools.evaluate.statistics import Statistics
    from tumtools.model.signals import Trajectory

_SCRIPTS_STATISTICS: Final = ("rmse", "mean", "median", "std", "min", "max")
_STAMP_DECIMALS: Final = 6


def ate_as_scripts(result: AteResult) -> list[str]:
    """Return the lines of `evaluate_ate.py --verbose`."""
    return [
        f"compared_pose_pairs {result.pairs:d} pairs",
        *_lines("absolute_translational_error", result.statistics, "m"),
    ]


def rpe_as_scripts(result: RpeResult) -> list[str]:
    """Return the lines of `evaluate_rpe.py --verbose`, with its rotational median in radians under `deg`."""
    rotation = _lines("rotational_error", result.rotation, "deg")
    median = float(np.median(result.rotational_errors))
    rotation[_SCRIPTS_STATISTICS.index("median")] = f"rotational_error.median {median:f} deg"
    return [
        f"compared_pose_pairs {result.pairs:d} pairs",
        *_lines("translational_error", result.translation, "m"),
        *rotation,
    ]


def _lines(name: str, statistics: Statistics, unit: str) -> list[str]:
    return [f"{name}.{key} {getattr(statistics, key):f} {unit}" for key in _SCRIPTS_STATISTICS]


def stamps_as_text(stamps: npt.NDArray[np.int64]) -> Iterator[str]:
    """Print stamps with six decimals as the scripts do, or with as many as they need."""
    decimals = decimals_needed(stamps, _STAMP_DECIMALS)
    return (format_stamp(stamp, decimals) for stamp in stamps.tolist())


def aligned_positions(result: AteResult) -> str:
    """Return what `evaluate_ate.py --save` writes: `stamp x y z` of the whole aligned estimate."""
    poses = result.aligned
    return _join([stamps_as_text(poses.stamps), *_columns(poses.positions)])


def aligned_trajectory(trajectory: Trajectory) -> str:
    """Return a trajectory file of the benchmark: `stamp tx ty tz qx qy qz qw`."""
    head = "# aligned estimate\n# timestamp tx ty tz qx qy qz qw\n"
    return head + _join([stamps_as_text(trajectory.stamps), *_columns(trajectory.values, 9)]) + "\n"


def ate_pairs(result: AteResult) -> str:
    """Return what `evaluate_ate.py --save_associations` writes: `stamp1 x1 y1 z1 stamp2 x2 y2 z2`."""
    true, judged = result.groundtruth, result.estimate
    return _join(
        [
            stamps_as_text(true.stamps),
            *_columns(true.positions),
            stamps_as_text(judged.stamps),
            *_columns(judged.positions),
        ]
    )


def rpe_pairs(result: RpeResult) -> str:
    """Return what `evaluate_rpe.py --save` writes: two stamps each, then metres and radians."""
    stamps = [*result.estimate_stamps.T, *result.groundtruth_stamps.T]
    errors = np.stack([result.translational_errors, result.rotational_errors], axis=1)
    return _join([*map(stamps_as_text, stamps), *_columns(errors)])


def distances(result: AllPairsResult) -> str:
    """Return RMSE(D) of all pairs: `frames metres [degrees]`."""
    errors = [result.translational_rmse]
    head = "# frames rmse_m"
    if result.rotational_rmse is not None:
        errors.append(result.rotational_rmse)
        head += " rmse_deg"
    frames = map(str, range(1, result.poses))
    return f"{head}\n{_join([frames, *_columns(np.stack(errors, axis=1), 9)])}\n"


def _columns(values: npt.NDArray[np.float64], decimals: int = 6) -> list[Iterator[str]]:
    return [(f"{value:.{decimals}f}" for value in column) for column in values.T.tolist()]


def _join(columns: Iterable[Iterable[str]]) -> str:
    """Return rows joined by line ends, the last row without one, as the scripts write them."""
    return "\n".join(map(" ".join, zip(*columns, strict=True)))
