# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Which sensor of a rawlog is which stream."""

from __future__ import annotations

import shlex
from typing import TYPE_CHECKING, Final

from tumtools.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Collection
    from pathlib import Path

    from tumtools.formats.options import ReadOptions
    from tumtools.formats.rawlog.survey import Survey


_MOST: Final = 5
"""Sensors that a message lists; a rawlog may have thousands."""
_LONGEST: Final = 60


def _shown(label: str) -> str:
    return repr(label) if len(label) <= _LONGEST else f"{label[:_LONGEST]!r}..."


def _choice(stream: str, labels: Collection[str]) -> str:
    """Return an option that takes one of several labels, as a shell needs it."""
    named = next((label for label in labels if 0 < len(label) <= _LONGEST), "LABEL")
    text = f"--topic {shlex.quote(f'{stream}={named}')}"
    return f"{text}, or --topic {stream}= for the one without a label" if "" in labels else text


def choose_labels(path: Path, found: Survey, options: ReadOptions, warnings: list[str]) -> dict[str, str]:
    """Choose the sensor of each stream, by its label.

    Args:
        path: For messages.
        found: What is in the rawlog.
        options: With the sensors asked for.
        warnings: Streams that are left out, and choices without effect, are added.

    Raises:
        UsageError: Several fit a stream that is wanted, or the one that was asked for is not there.

    """
    chosen = {}
    candidates = found.candidates()
    for stream in sorted(options.topics.keys() - candidates.keys()):
        choice = f"--topic {stream}={options.topics[stream]}"
        warnings.append(f"{path}: {choice} has no effect: no sensor gives {stream}")
    for stream, labels in candidates.items():
        listed = ", ".join(f"{_shown(label)} ({count})" for label, count in [*labels.items()][:_MOST])
        listed += f" and {len(labels) - _MOST} more" if len(labels) > _MOST else ""
        asked = options.topics.get(stream)
        if asked is not None and asked not in labels:
            raise UsageError(f"no sensor {_shown(asked)} gives {stream}; there are {listed}", path=path)
        if asked is not None or len(labels) == 1:
            chosen[stream] = asked if asked is not None else next(iter(labels))
            continue
        text = f"several sensors give {stream}: {listed}"
        choice = _choice(stream, labels)
        if options.lenient:
            warnings.append(f"{path}: {text}; choose one: {choice}")
        elif options.wants(stream):
            raise UsageError(text, path=path, hint=f"choose one: {choice}")
    return chosen
