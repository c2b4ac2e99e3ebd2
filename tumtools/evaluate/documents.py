# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Results as plain dictionaries, for JSON; keys end with their unit."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tumtools.model.time import NANOSECONDS_PER_SECOND

if TYPE_CHECKING:
    from tumtools.evaluate.allpairs import AllPairsResult
    from tumtools.evaluate.ate import AteResult
    from tumtools.evaluate.rpe import RpeResult


def ate(result: AteResult) -> dict[str, object]:
    """Return an absolute trajectory error."""
    return _common(result) | {
        "largest_time_difference_s": result.largest_difference / NANOSECONDS_PER_SECOND,
        "translation_m": result.statistics.as_dict(),
        "alignment": {
            "rotation": result.alignment.rotation.tolist(),
            "translation_m": result.alignment.translation.tolist(),
            "scale": result.alignment.scale,
            "undetermined": result.alignment.freedom or None,
        },
    }


def rpe(result: RpeResult) -> dict[str, object]:
    """Return a relative pose error."""
    return _common(result) | {
        "delta": result.delta,
        "unit": None if result.delta is None else result.unit,
        "estimate_poses_matched": result.estimate_matched,
        "pairs_without_groundtruth": result.candidates - result.pairs,
        "translation_m": result.translation.as_dict(),
        "rotation_deg": result.rotation.as_dict(),
    }


def all_pairs(result: AllPairsResult) -> dict[str, object]:
    """Return a relative pose error over all distances."""
    rotational = result.rotational_rmse
    return _common(result) | {
        "matched_poses": result.poses,
        "frame_step_s": result.step / NANOSECONDS_PER_SECOND,
        "largest_time_difference_s": result.largest_difference / NANOSECONDS_PER_SECOND,
        "translation_m": result.translation,
        "rotation_deg": result.rotation,
        "translational_rmse_m": result.translational_rmse.tolist(),
        "rotational_rmse_deg": None if rotational is None else rotational.tolist(),
    }


def _common(result: AteResult | RpeResult | AllPairsResult) -> dict[str, object]:
    return {
        "pairs": result.pairs,
        "groundtruth_poses": result.groundtruth_count,
        "estimate_poses": result.estimate_count,
        "notes": list(result.notes),
    }
