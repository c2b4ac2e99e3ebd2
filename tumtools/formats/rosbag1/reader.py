# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Read a sequence from a ROS 1 bag."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tumtools.formats.ros.incoming import RosSequence
from tumtools.formats.rosbag1.recording import BagRecording

if TYPE_CHECKING:
    from pathlib import Path

    from tumtools.formats.options import ReadOptions
    from tumtools.model.sequence import Sequence


def open(path: Path, options: ReadOptions) -> Sequence:  # noqa: A001 - the verb of every format
    """Open a bag.

    Raises:
        InputError: It is damaged.
        UsageError: The topics asked for do not fit, or several could be meant.

    """
    return RosSequence(BagRecording(path, salvage=options.salvage), path.stem, options)
