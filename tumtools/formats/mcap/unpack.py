# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Decompress chunks, with no more memory than their headers announce."""

from __future__ import annotations

from typing import Final

import lz4.frame
import zstandard

COMPRESSIONS: Final = frozenset({"", "zstd", "lz4"})
"""What is read; empty for none."""


def unpack(packed: memoryview, compression: str, size: int) -> memoryview:
    """Return the records of a chunk.

    Args:
        packed: As they are in the file.
        compression: One of `COMPRESSIONS`.
        size: Bytes by the chunk's header.

    Raises:
        ValueError: They are damaged, or have another size.

    """
    if not compression:
        return packed
    try:
        if compression == "lz4":
            return memoryview(lz4.frame.LZ4FrameDecompressor().decompress(packed, max_length=size + 1))
        promised = zstandard.frame_content_size(packed)
        if promised in {-1, size}:
            # A size that the frame itself gives would be allocated whatever the limit is.
            return memoryview(zstandard.ZstdDecompressor().decompress(packed, max_output_size=size + 1))
    except (zstandard.ZstdError, RuntimeError, ValueError, EOFError) as error:
        raise ValueError(f"the chunk cannot be decompressed: {error}") from error
    raise ValueError(f"the chunk's data says it has {promised} bytes, its header says {size}")
