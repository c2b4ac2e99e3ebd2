# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Decompress chunks, with no more memory than their headers announce."""

from __future__ import annotations

from typing import Final

import lz4.frame
import zstandard

from tumtools.errors import InputError, UnsupportedInputError
from tumtools.formats.mcap.records import CHUNK_HEADER, RECORD_HEADER, Fields

_COMPRESSIONS: Final = frozenset({"", "zstd", "lz4"})
"""What is read; empty for none."""
_MAX_CHUNK_BYTES: Final = 1 << 28
"""A chunk that says it is larger than 256 MiB is taken for damaged; writers make them of a few MB."""
DAMAGED: Final = "the file is damaged; get it again, or leave this chunk out with --salvage"


def records_of_chunk(content: memoryview, offset: int, path: str) -> tuple[memoryview, int]:
    """Return the records of a chunk, uncompressed, and their CRC by its header.

    Args:
        content: Of the chunk's record.
        offset: Where it is in the file, for messages.
        path: The file, for messages.

    Raises:
        InputError: The chunk is damaged.
        UnsupportedInputError: A compression that is not known.

    """
    fields, place = Fields(content, offset + RECORD_HEADER.size, path), f"offset {offset}"
    _, _, size, crc = fields.unpack(CHUNK_HEADER)
    compression = fields.string()
    packed = fields.take(fields.number("Q"))
    if size > _MAX_CHUNK_BYTES:
        message = f"the chunk says it has {size} bytes; none has more than {_MAX_CHUNK_BYTES}"
        raise InputError(message, path=path, location=place)
    if compression not in _COMPRESSIONS:
        raise UnsupportedInputError(f"chunks compressed with {compression!r}", path=path, location=place)
    try:
        records = _unpack(packed, compression, size)
    except ValueError as error:
        raise InputError(str(error), path=path, location=place, hint=DAMAGED) from error
    if len(records) != size:
        message = f"the chunk has {len(records)} bytes, its header says {size}"
        raise InputError(message, path=path, location=place)
    return records, crc


def _unpack(packed: memoryview, compression: str, size: int) -> memoryview:
    """Return the records of a chunk.

    Args:
        packed: As they are in the file.
        compression: One of `_COMPRESSIONS`.
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
