# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Statistics of sequences as tables: for people, Markdown, LaTeX and CSV."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from tumtools.evaluate.summary import Summary


@dataclass(frozen=True, slots=True)
class Column:
    """A column of the table.

    Attributes:
        title: Head of the column, with the unit.
        key: Name in CSV.
        text: The cell of a sequence; empty where the sequence does not have it.

    """

    title: str
    key: str
    text: Callable[[Summary], str]


def _moved(name: str, form: str) -> Callable[[Summary], str]:
    def text(summary: Summary) -> str:
        value = getattr(summary.motion, name, None)
        return "" if value is None else format(value, form)

    return text


def _dimensions(summary: Summary) -> str:
    return "" if summary.motion is None else " x ".join(f"{size:.2f}" for size in summary.motion.dimensions)


def _stream(stream: str, name: str, form: str) -> Callable[[Summary], str]:
    def text(summary: Summary) -> str:
        value = getattr(summary.streams.get(stream), name, None)
        return "" if value is None else format(value, form)

    return text


def _coverage(summary: Summary) -> str:
    rgb = summary.streams.get("rgb")
    if rgb is None or rgb.with_groundtruth is None:
        return ""
    return f"{100.0 * rgb.with_groundtruth / rgb.count:.1f}"


COLUMNS: Final = (
    Column("sequence", "sequence", lambda summary: summary.name),
    Column("duration (s)", "duration_s", _moved("duration", ".2f")),
    Column("with poses (s)", "duration_with_poses_s", _moved("duration_with_poses", ".2f")),
    Column("avg. trans. vel. (m/s)", "avg_trans_vel_m_s", _moved("translational_velocity", ".3f")),
    Column("avg. rot. vel. (deg/s)", "avg_rot_vel_deg_s", _moved("rotational_velocity", ".3f")),
    Column("dimensions (m)", "dimensions_m", _dimensions),
    Column("page's length (m)", "page_length_m", _moved("page_length", ".3f")),
    Column("path length (m)", "path_length_m", _moved("path_length", ".3f")),
    Column("colour", "rgb_count", _stream("rgb", "count", "d")),
    Column("depth", "depth_count", _stream("depth", "count", "d")),
    Column("dropped colour", "rgb_dropped", _stream("rgb", "dropped", "d")),
    Column("pairs", "pairs", lambda summary: "" if summary.pairs is None else str(summary.pairs)),
    Column("with ground truth (%)", "rgb_with_groundtruth_percent", _coverage),
)


def cells(summaries: Iterable[Summary]) -> tuple[list[str], list[list[str]]]:
    """Return head and rows of the table, without columns that are empty for all."""
    rows = list(summaries)
    columns = [column for column in COLUMNS if any(column.text(row) for row in rows)]
    return [column.title for column in columns], [
        [column.text(row) or "-" for column in columns] for row in rows
    ]


def markdown(summaries: Iterable[Summary]) -> str:
    """Return a Markdown table."""
    head, rows = cells(summaries)
    rule = ["---", *["--:"] * (len(head) - 1)]
    return "\n".join("| " + " | ".join(row) + " |" for row in [head, rule, *rows])


def latex(summaries: Iterable[Summary]) -> str:
    """Return a LaTeX table, for the package booktabs."""
    head, rows = cells(summaries)
    lines = [_latex_row(row) for row in rows]
    return "\n".join(
        [
            r"\begin{tabular}{l" + "r" * (len(head) - 1) + "}",
            r"\toprule",
            _latex_row(head),
            r"\midrule",
            *lines,
            r"\bottomrule",
            r"\end{tabular}",
        ]
    )


def _latex_row(row: Sequence[str]) -> str:
    escaped = [
        cell.replace("_", r"\_").replace("%", r"\%").replace(" x ", r" $\times$ ") if cell != "-" else "--"
        for cell in row
    ]
    return " & ".join(escaped) + r" \\"


def as_csv(summaries: Iterable[Summary]) -> str:
    """Return comma-separated values with all columns; empty where a sequence has no such value."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([column.key for column in COLUMNS])
    writer.writerows([column.text(summary) for column in COLUMNS] for summary in summaries)
    return text.getvalue().rstrip("\n")
