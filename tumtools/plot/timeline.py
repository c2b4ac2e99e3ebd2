# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A timeline of the streams of sequences: where they have items, and where they have gaps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from tumtools.errors import InputError
from tumtools.evaluate.summary import stream_statistics
from tumtools.model.sequence import IMAGE_STREAMS
from tumtools.model.time import format_stamp
from tumtools.plot.style import BLACK, BLUE, GREEN, ORANGE, SKY, VERMILION, gaps, new_figure, style

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy.typing as npt
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from tumtools.model.sequence import Sequence

_COLORS: Final = {
    "rgb": BLUE,
    "depth": ORANGE,
    "ir": VERMILION,
    "accelerometer": SKY,
    "groundtruth": GREEN,
}
_HEIGHT: Final = 0.62


@dataclass(frozen=True, slots=True)
class Spans:
    """Stretches of a stream without a gap, and the gaps between them, seconds from the start.

    Attributes:
        stretches: Start and end, shape [k, 2].
        gaps: Start and end, shape [k - 1, 2].
        covered: Share of the whole time in stretches, 0 .. 1.

    """

    stretches: npt.NDArray[np.float64]
    gaps: npt.NDArray[np.float64]
    covered: float


def spans(stamps: npt.NDArray[np.int64], start: int, end: int) -> Spans:
    """Find the stretches of a stream.

    Args:
        stamps: ns, in any order, not empty.
        start: First stamp of the whole timeline, ns.
        end: Last stamp of the whole timeline, ns.

    """
    times = np.unique(stamps)
    cuts = gaps(times)
    begin = np.r_[times[0], times[cuts + 1]]
    finish = np.r_[times[cuts], times[-1]]
    stretches = (np.stack([begin, finish], axis=1) - start) / 1e9
    whole = max((end - start) / 1e9, 1e-9)
    return Spans(
        stretches,
        np.stack([stretches[:-1, 1], stretches[1:, 0]], axis=1),
        float(np.sum(stretches[:, 1] - stretches[:, 0])) / whole,
    )


def plot_timeline(sequences: Mapping[str, Sequence], title: str | None = None) -> Figure:
    """Draw when each stream has items; a panel for each sequence.

    Args:
        sequences: Open sequences, by what to write above their panels.
        title: Above the picture.

    Raises:
        InputError: A sequence has no stamps at all.

    """
    streams = [_streams(sequence) for sequence in sequences.values()]
    rows = sum(map(len, streams))
    with style():
        figure = new_figure(7.6, 0.42 * rows + 0.95 * len(streams) + 0.2)
        panels = figure.subplots(
            len(streams),
            1,
            squeeze=False,
            gridspec_kw={"height_ratios": [len(each) + 0.6 for each in streams]},
        )[:, 0]
        for axes, name, each in zip(panels, sequences, streams, strict=True):
            _panel(axes, each)
            axes.set_title(name)
        if title:
            figure.suptitle(title)
    return figure


def _streams(sequence: Sequence) -> dict[str, npt.NDArray[np.int64]]:
    found = {name: sequence.image_stamps(name) for name in IMAGE_STREAMS}
    for name, signal in (("accelerometer", sequence.accelerometer), ("groundtruth", sequence.groundtruth)):
        if signal is not None:
            found[name] = signal.stamps
    found = {name: stamps for name, stamps in found.items() if len(stamps)}
    if not found:
        raise InputError("there is nothing with a stamp to draw", path=sequence.info.name)
    return found


def _panel(axes: Axes, streams: dict[str, npt.NDArray[np.int64]]) -> None:
    start = min(int(stamps.min()) for stamps in streams.values())
    end = max(int(stamps.max()) for stamps in streams.values())
    labels = []
    for row, (name, stamps) in enumerate(streams.items()):
        found = spans(stamps, start, end)
        lengths = np.diff(found.stretches, axis=1)[:, 0]
        axes.broken_barh(
            list(zip(found.stretches[:, 0], lengths, strict=True)),
            (row - _HEIGHT / 2, _HEIGHT),
            facecolors=_COLORS[name],
            edgecolors=_COLORS[name],
            linewidth=0.4,
        )
        for gap_start, gap_end in found.gaps:
            axes.plot([gap_start, gap_end], [row, row], color=BLACK, linewidth=0.7)
        labels.append(name)
        axes.annotate(
            _remark(stamps, found),
            (1.0, row),
            xycoords=("axes fraction", "data"),
            xytext=(6, 0),
            textcoords="offset points",
            va="center",
            fontsize=7.5,
        )
    axes.set_yticks(range(len(labels)), labels)
    axes.set_ylim(len(labels) - 0.4, -0.6)
    axes.margins(x=0.01)
    axes.grid(visible=False, axis="y")
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel(f"seconds since {format_stamp(start, 9)}")


def _remark(stamps: npt.NDArray[np.int64], found: Spans) -> str:
    """Say how many items, how often, and what is missing."""
    # The mean: the accelerometer's rows come in bursts, the Kinect's stamps jitter.
    rate = stream_statistics(stamps).mean_rate
    longest = f", longest {np.diff(found.gaps, axis=1).max():.2f} s" if len(found.gaps) else ""
    return (
        f"{len(stamps)} at {rate or 0.0:.1f} Hz, covers {100 * found.covered:.1f} %\n"
        f"{len(found.gaps) or 'no'} gap{'s' * (len(found.gaps) != 1)}{longest}"
    )
