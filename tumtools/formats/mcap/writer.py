# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Write a sequence as MCAP."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from tumtools.formats.mcap.container import Packing, write_mcap
from tumtools.formats.registry import FORMATS
from tumtools.formats.ros.outgoing import outgoing, style_plan
from tumtools.formats.ros.style import Style, make_style, style_needs

if TYPE_CHECKING:
    from pathlib import Path

    from tumtools.formats.options import Needs, Plan, Progress, WriteOptions
    from tumtools.formats.ros.recording import MessageEncoding
    from tumtools.model.sequence import Loss, Sequence

_ENCODINGS: Final[dict[str, MessageEncoding]] = {"ros2": "cdr", "ros1": "ros1"}


def write(sequence: Sequence, target: Path, options: WriteOptions, progress: Progress) -> tuple[Loss, ...]:
    """Write a MCAP file; returns no losses, since what it cannot hold is taken out before (`needs`).

    Raises:
        InputError: An image of the sequence is damaged.
        OutputError: A stamp does not fit into the messages.

    """
    style = _style(options)
    out = outgoing(sequence, style)
    write_mcap(
        target,
        out.channels,
        out.images(),
        out.metadata,
        rows=out.rows(),
        digest=out.digest,
        packing=Packing(
            style.encoding, out.compressed_channels, FORMATS["mcap"].option(options, "compression")
        ),
        jobs=options.jobs,
        progress=progress,
    )
    return ()


def needs(options: WriteOptions) -> Needs:
    """Return what the writer must be given."""
    return style_needs(_style(options))


def plan(sequence: Sequence, target: Path, options: WriteOptions) -> Plan:
    """Return the estimated size, and what is assumed."""
    del target
    compressed = FORMATS["mcap"].option(options, "compression") != "none"
    return style_plan(sequence, _style(options), compressed=compressed)


def _style(options: WriteOptions) -> Style:
    entry = FORMATS["mcap"]
    encoding = _ENCODINGS[entry.option(options, "profile")]
    return make_style(encoding, entry, options)
