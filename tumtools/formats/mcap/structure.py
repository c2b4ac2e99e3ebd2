# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What a MCAP file is made of: message types, topics, and where its chunks are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping


@dataclass(frozen=True, slots=True)
class Schema:
    """A message type."""

    name: str
    encoding: str
    definition: str


@dataclass(frozen=True, slots=True)
class RawChannel:
    """A topic; `schema` is the number of its schema, 0 for none."""

    schema: int
    topic: str
    encoding: str
    extra: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class ChunkPlace:
    """Where a chunk is.

    Attributes:
        offset: Of its record.
        index: Channel -> offset of its message index; empty if the chunk has none.

    """

    offset: int
    index: Mapping[int, int]
