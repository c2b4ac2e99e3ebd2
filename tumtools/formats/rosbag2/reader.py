# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Read a sequence from a rosbag2 folder or one of its sqlite3 files."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tumtools.formats.ros.incoming import RosSequence
from tumtools.formats.rosbag2.recording import Rosbag2Recording

if TYPE_CHECKING:
    from pathlib import Path

    from tumtools.formats.options import ReadOptions
    from tumtools.model.sequence import Sequence


def open(path: Path, options: ReadOptions) -> Sequence:  # noqa: A001 - the verb of every format
    """Open a recording.

    Raises:
        InputError: It is damaged.
        UsageError: The topics asked for do not fit, or several could be meant.

    """
    recording = Rosbag2Recording(path, salvage=options.salvage)
    try:
        return RosSequence(recording, path.stem, options)
    except BaseException:
        recording.close()
        raise
