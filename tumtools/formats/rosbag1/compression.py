# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Compression of chunks: none, bz2 and lz4. All of it runs in C without the GIL."""

from __future__ import annotations

import bz2
from typing import Final

import lz4.frame

COMPRESSIONS: Final = ("none", "bz2", "lz4")

MAX_CHUNK_SIZE: Final = 128 * 2**20
"""Uncompressed size up to which compressed chunks are read; recorders make chunks of about 1 MB."""


def compress(data: bytes, compression: str) -> bytes:
    """Compress the content of a chunk.

    ROS itself refuses LZ4 frames other than with independent blocks, without the content's size and with
    a checksum of the content (roslz4 of ros_comm: frame descriptor byte 0x64).
    """
    if compression == "bz2":
        return bz2.compress(data)
    if compression == "lz4":
        compressed: bytes = lz4.frame.compress(
            data, block_linked=False, content_checksum=True, store_size=False
        )
        return compressed
    return data


def decompress(data: bytes | memoryview, compression: str, size: int) -> bytes:
    """Decompress the content of a chunk.

    Args:
        data: The compressed bytes.
        compression: `bz2` or `lz4`.
        size: Uncompressed size by the chunk's header; never more memory than this is taken.

    Raises:
        ValueError: The bytes are damaged, or have another size when uncompressed.

    """
    decompressor = bz2.BZ2Decompressor() if compression == "bz2" else lz4.frame.LZ4FrameDecompressor()
    try:
        content: bytes = decompressor.decompress(data, max_length=size + 1)
    except (OSError, RuntimeError, EOFError) as error:
        message = f"{compression} data is damaged: {error}"
        raise ValueError(message) from error
    if len(content) != size:
        less = "more" if len(content) > size else f"only {len(content)}"
        message = f"{compression} data holds {less} bytes where the chunk's header says {size}"
        raise ValueError(message)
    # The checksum stands at the end of the data and is read only when everything before it has been.
    if not decompressor.eof:
        try:
            rest: bytes = decompressor.decompress(b"", max_length=1)
        except (OSError, RuntimeError, EOFError) as error:
            message = f"{compression} data is damaged: {error}"
            raise ValueError(message) from error
        if rest or not decompressor.eof:
            message = f"{compression} data ends early"
            raise ValueError(message)
    return content
