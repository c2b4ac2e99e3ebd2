# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""How the text file of a stream is written down, apart from its values.

Byte-identical text is part of losslessness. A layout travels with the data through every format, so
that the file can be written again as it was; it is plain data and says nothing about the values.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

SHORTEST: Final = "%r"
"""Value format: the shortest text that reads back as the same float64."""


@dataclass(frozen=True, slots=True)
class TextLayout:
    """The look of a text file of the benchmark.

    A row is rendered as its stamp with `stamp_decimals`, then its values with `value_format`, joined
    by `separator`. Rows that this does not reproduce are kept literally in `overrides`.

    Attributes:
        head: All text before the first row, header lines included, with line ends.
        stamp_decimals: 0 .. 9.
        value_format: printf format of each value (`%.4f`), or `SHORTEST`. Not used by image lists.
        separator: Between fields.
        newline: Line end of the rows.
        overrides: Row number (0 = first row) -> its literal text up to the final line feed (a carriage
            return before that is part of it); it may begin with comment or blank lines that stand before
            the row.
        tail: All text after the last row's line end.
        final_newline: False when the file ends with the last row and no line end.

    """

    head: str = ""
    stamp_decimals: int = 6
    value_format: str = "%.6f"
    separator: str = " "
    newline: str = "\n"
    overrides: Mapping[int, str] = field(default_factory=dict)
    tail: str = ""
    final_newline: bool = True

    def select(self, rows: Sequence[int]) -> TextLayout:
        """Return the layout for a choice of rows, given by their old row numbers in file order."""
        overrides = {new: self.overrides[old] for new, old in enumerate(rows) if old in self.overrides}
        return replace(self, overrides=overrides)


TITLES: Final[dict[str, tuple[str, str]]] = {
    "rgb": ("# color images", "# timestamp filename"),
    "depth": ("# depth maps", "# timestamp filename"),
    "ir": ("# ir (infrared) images", "# timestamp filename"),
    "groundtruth": ("# ground truth trajectory", "# timestamp tx ty tz qx qy qz qw"),
    "accelerometer": ("# accelerometer data", "# timestamp ax ay az"),
}
"""First and third header line of each file, as published."""


def default_layout(stream: str, name: str | None) -> TextLayout:
    """Return the layout of the published files, for a sequence that brings none of its own."""
    title, columns = TITLES[stream]
    file_line = f"# file: '{name}.bag'\n" if name and name.isprintable() else ""
    decimals = 4 if stream == "groundtruth" else 6
    return TextLayout(
        head=f"{title}\n{file_line}{columns}\n", stamp_decimals=decimals, value_format=f"%.{decimals}f"
    )
