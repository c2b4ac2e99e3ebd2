# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The look of all pictures, and how they are saved: the same input gives the same bytes.

Colours differ in lightness, and lines in style or width, so that a picture printed in grey can be
read; the colours are those of Okabe and Ito, "Color universal design" (2008).
"""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from tumtools.errors import UsageError
from tumtools.staging import staged_file

try:
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
except ImportError as error:
    raise UsageError(
        "pictures need matplotlib, which is not installed", hint="pip install 'tumtools[plot]'"
    ) from error

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy.typing as npt
    from matplotlib.axes import Axes

BLACK: Final = "#000000"
GREY: Final = "#8c8c8c"
BLUE: Final = "#0072b2"
ORANGE: Final = "#e69f00"
VERMILION: Final = "#d55e00"
SKY: Final = "#56b4e9"
GREEN: Final = "#009e73"
CYCLE: Final = (
    (BLUE, "-"),
    (VERMILION, (0, (5, 1.5))),
    (GREEN, (0, (1, 1))),
    (ORANGE, (0, (5, 1, 1, 1))),
    (SKY, (0, (2, 1))),
)
"""Colour and line style of the first, second, … estimate."""
ERROR_MAP: Final = ("#f6b26b", "#e8603c", "#b5122b", "#4d0018")
"""Small errors light, large ones dark, in colour and in grey alike."""

FORMATS: Final = {
    ".svg": {"Date": None, "Creator": None},
    ".png": {"Software": None},
    ".pdf": {"CreationDate": None, "ModDate": None, "Producer": None, "Creator": None},
}
"""Suffix -> metadata that would change with the day or the version, left out."""

_SETTINGS: Final[dict[Any, object]] = {  # Any: the keys that matplotlib knows are a type with 300 members
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "axes.titlesize": 10.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "grid.color": "#e0e0e0",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "lines.linewidth": 1.3,
    "lines.solid_capstyle": "round",
    "svg.hashsalt": "tumtools",
    "svg.fonttype": "path",
    "pdf.fonttype": 42,
    "pdf.compression": 6,
    "path.simplify": True,
    "savefig.dpi": 160.0,
}


@contextmanager
def style() -> Iterator[None]:
    """Use the look of our pictures, whatever the user's own settings are."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_SETTINGS)
        yield


def new_figure(width: float = 6.4, height: float = 4.4) -> Figure:
    """Return an empty figure, size in inches; to be called and drawn on inside `style`."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def save(figure: Figure, path: str | Path, *, force: bool = False) -> None:
    """Write a figure; the suffix of the path decides the format.

    Raises:
        UsageError: An unknown suffix, or the file exists.
        OutputError: It cannot be written.

    """
    target = Path(path)
    suffix = target.suffix.lower()
    if suffix not in FORMATS:
        msg = f"a picture ends with {', '.join(FORMATS)}, not {suffix or 'no suffix'!r}"
        raise UsageError(msg, path=target)
    with style(), staged_file(target, force=force) as stage:
        figure.savefig(stage, format=suffix[1:], metadata=FORMATS[suffix])


def broken_at_gaps(stamps: npt.NDArray[np.int64], values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Put NaN between rows with a gap in time, so that lines drawn through the result are broken there.

    Args:
        stamps: Ascending, ns, shape [n].
        values: Shape [n, k].

    """
    return np.insert(values, gaps(stamps) + 1, np.nan, axis=0)


def gaps(stamps: npt.NDArray[np.int64]) -> npt.NDArray[np.intp]:
    """Return the rows after which there is a gap.

    A gap is longer than two and a half median steps and than a tenth of a second; what is shorter
    cannot be seen in a picture.

    Args:
        stamps: Ascending, ns, shape [n].

    """
    steps = np.diff(stamps)
    if not len(steps):
        return np.empty(0, np.intp)
    return np.flatnonzero(steps > max(2.5 * float(np.median(steps)), 1e8))


def note(axes: Axes, text: str) -> None:
    """Write above the right end of a panel, where it covers nothing."""
    axes.set_title(text, loc="right", fontsize=8.5, fontweight="normal")


def equal_axes(axes: Axes, x: str, y: str) -> None:
    """Label two axes in metres and give them one scale."""
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel(f"{x} (m)")
    axes.set_ylabel(f"{y} (m)")
