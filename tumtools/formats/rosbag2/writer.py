# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Write a sequence as a rosbag2 folder."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Final

from tumtools.errors import UsageError
from tumtools.formats.mcap.container import Packing, write_mcap
from tumtools.formats.metadata import DIGEST_RECORD
from tumtools.formats.registry import FORMATS
from tumtools.formats.ros.outgoing import outgoing, style_plan
from tumtools.formats.ros.style import Style, make_style, style_needs
from tumtools.formats.rosbag2.bag_info import DISTRO_VERSIONS, FILE_NAME, Tally, format_bag_info
from tumtools.formats.rosbag2.sqlite_writer import write_sqlite

if TYPE_CHECKING:
    from pathlib import Path

    from tumtools.formats.options import Needs, Plan, Progress, WriteOptions
    from tumtools.model.sequence import Loss, Sequence

_SUFFIXES: Final = {"sqlite3": ".db3", "mcap": ".mcap"}


def write(sequence: Sequence, target: Path, options: WriteOptions, progress: Progress) -> tuple[Loss, ...]:
    """Write a recording; returns no losses, since what it cannot hold is taken out before (`needs`).

    Raises:
        InputError: An image of the sequence is damaged.
        OutputError: A stamp does not fit into the messages, or the disk is full.

    """
    entry = FORMATS["rosbag2"]
    storage, distro = entry.option(options, "storage"), entry.option(options, "ros_distro")
    out = outgoing(sequence, _style(options))
    tally = Tally(out.channels)
    target.mkdir()
    file = target / f"{target.name}_0{_SUFFIXES[storage]}"

    def describe() -> tuple[str, str]:
        summary = tally.summary(file.name)
        custom = dict(out.metadata)
        if digest := out.digest():
            custom[DIGEST_RECORD] = json.dumps(digest, sort_keys=True, separators=(",", ":"))
        return format_bag_info(summary, storage=storage, ros_distro=distro, custom_data=custom)

    if storage == "mcap":
        packing = Packing("cdr", out.compressed_channels, _compression(options))
        write_mcap(
            file,
            out.channels,
            tally.watch(out.messages()),
            out.metadata,
            digest=out.digest,
            packing=packing,
            jobs=options.jobs,
            progress=progress,
        )
    else:
        write_sqlite(
            file,
            out.channels,
            tally.watch(out.messages()),
            describe=lambda: (DISTRO_VERSIONS[distro], describe()[1]),
            ros_distro=distro,
            progress=progress,
        )
    (target / FILE_NAME).write_text(describe()[0], encoding="ascii")
    return ()


def needs(options: WriteOptions) -> Needs:
    """Return what the writer must be given."""
    return style_needs(_style(options))


def plan(sequence: Sequence, target: Path, options: WriteOptions) -> Plan:
    """Return the estimated size, and what is assumed."""
    del target
    return style_plan(sequence, _style(options), compressed=_compression(options) != "none")


def _compression(options: WriteOptions) -> str:
    """Return the compression of chunks; sqlite3 has none."""
    if FORMATS["rosbag2"].option(options, "storage") == "mcap":
        return options.compression or "zstd"
    if options.compression not in {None, "none"}:
        raise UsageError(
            f"--compression {options.compression} is not possible with sqlite3 storage",
            hint="use --storage mcap, which compresses its chunks",
        )
    return "none"


def _style(options: WriteOptions) -> Style:
    _compression(options)
    return make_style("cdr", FORMATS["rosbag2"], options)
