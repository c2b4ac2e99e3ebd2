# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What `tumtools info` says of a sequence, as a document."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING

import numpy as np

from tumtools.catalogue import errata
from tumtools.catalogue.catalogue import packaged_catalogue
from tumtools.cli.report import loss_document

if TYPE_CHECKING:
    import numpy.typing as npt

    from tumtools.model.sequence import Sequence


def describe(source: str, sequence: Sequence) -> dict[str, object]:
    """Return what there is to say of a sequence, for JSON."""
    info = sequence.info
    streams: dict[str, dict[str, object]] = {}
    for name, images in info.images.items():
        streams[name] = _times(sequence.image_stamps(name)) | {
            "encoding": images.encoding,
            "compression": images.compression,
            "width": images.width,
            "height": images.height,
            "depth_units_per_metre": images.depth_units_per_metre,
            "bytes": images.nbytes,
            "source": images.source,
            "frame_id": images.frame_id,
        }
    for name, signal in (("accelerometer", sequence.accelerometer), ("groundtruth", sequence.groundtruth)):
        if signal is not None:
            streams[name] = _times(signal.stamps) | {"source": info.sources.get(name)}
    return {
        "source": source,
        "name": info.name,
        "format": info.format,
        "camera": info.camera,
        "streams": streams,
        "calibrations": sorted(sequence.cameras),
        "licence": info.licence,
        "citation": info.citation,
        "details": {title: [dict(row) for row in rows] for title, rows in sequence.details().items()},
        "digest": None if info.digest is None else {name: asdict(one) for name, one in info.digest.items()},
        "not_carried": [loss_document(loss) for loss in info.not_carried],
        "warnings": list(info.warnings),
        "notes": _notes(info.name),
    }


def _notes(name: str) -> list[str]:
    """Return what the catalogue knows to be special or wrong in a sequence of this name."""
    entry = packaged_catalogue().find(name)
    return [] if entry is None else list(errata(entry))


def _times(stamps: npt.NDArray[np.int64]) -> dict[str, object]:
    if not len(stamps):
        return {"count": 0, "first": None, "last": None, "duration_s": None, "median_rate_hz": None}
    ordered = np.sort(stamps)
    step = float(np.median(np.diff(ordered))) if len(ordered) > 1 else 0.0
    return {
        "count": len(stamps),
        "first": str(int(ordered[0])),
        "last": str(int(ordered[-1])),
        "duration_s": (int(ordered[-1]) - int(ordered[0])) / 1e9,
        "median_rate_hz": 1e9 / step if step else None,
    }
