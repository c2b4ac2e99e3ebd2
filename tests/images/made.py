# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""PNG files of every kind, made chunk by chunk; deliberately slow and simple."""

from __future__ import annotations

import struct
import zlib
from typing import Final

import numpy as np
import numpy.typing as npt

CHANNELS: Final = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
KINDS: Final = [
    (colour_type, bits)
    for colour_type, depths in {
        0: (1, 2, 4, 8, 16),
        2: (8, 16),
        3: (1, 2, 4, 8),
        4: (8, 16),
        6: (8, 16),
    }.items()
    for bits in depths
]
"""Colour types and their bit depths (specification, table 11.1)."""
_PASSES: Final = (
    (0, 0, 8, 8),
    (4, 0, 8, 8),
    (0, 4, 4, 8),
    (2, 0, 4, 4),
    (0, 2, 2, 4),
    (1, 0, 2, 2),
    (0, 1, 1, 2),
)
"""Adam7: first column, first row, column step, row step."""


def chunk(kind: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def offsets(data: bytes) -> list[int]:
    """Return where the chunks of a file begin, and where it ends."""
    found = [8]
    while found[-1] < len(data):
        found.append(found[-1] + 12 + int.from_bytes(data[found[-1] : found[-1] + 4]))
    return found


def make(
    samples: npt.NDArray[np.uint16],
    colour_type: int,
    bits: int,
    *,
    filters: tuple[int, ...] = (0,),
    interlaced: bool = False,
    palette: bytes = b"",
    transparency: bytes = b"",
    parts: int = 1,
) -> bytes:
    """Write samples, shape [h, w, channels].

    Args:
        samples: Each less than 2**bits.
        colour_type: As in the header.
        bits: A sample.
        filters: Of the rows, in turn.
        interlaced: Use Adam7.
        palette: The PLTE chunk, if any.
        transparency: The tRNS chunk, if any.
        parts: How many IDAT chunks.

    """
    height, width = samples.shape[:2]
    passes = [samples[y::dy, x::dx] for x, y, dx, dy in _PASSES] if interlaced else [samples]
    raw = b"".join(_filtered(part, bits, filters) for part in passes if part.size)
    body = zlib.compress(raw)
    step = -(-len(body) // parts)
    head = struct.pack(">IIBBBBB", width, height, bits, colour_type, 0, 0, interlaced)
    return b"".join(
        [
            b"\x89PNG\r\n\x1a\n",
            chunk(b"IHDR", head),
            chunk(b"PLTE", palette) if palette else b"",
            chunk(b"tRNS", transparency) if transparency else b"",
            *(chunk(b"IDAT", body[start : start + step]) for start in range(0, len(body), step)),
            chunk(b"IEND", b""),
        ]
    )


def _filtered(samples: npt.NDArray[np.uint16], bits: int, filters: tuple[int, ...]) -> bytes:
    height = samples.shape[0]
    flat = samples.reshape(height, -1)
    if bits == 16:
        rows = flat.astype(">u2").view(np.uint8)
    else:
        unpacked = np.unpackbits(flat.astype(np.uint8)[:, :, None], axis=2)[:, :, 8 - bits :]
        rows = np.packbits(unpacked.reshape(height, -1), axis=1)
    distance = max(1, samples.shape[2] * bits // 8)
    result = bytearray()
    above = [0] * rows.shape[1]
    for number, row in enumerate(rows.tolist()):
        kind = filters[number % len(filters)]
        result.append(kind)
        for column, value in enumerate(row):
            left = row[column - distance] if column >= distance else 0
            corner = above[column - distance] if column >= distance else 0
            predicted = (
                0,
                left,
                above[column],
                (left + above[column]) // 2,
                _paeth(left, above[column], corner),
            )
            result.append((value - predicted[kind]) % 256)
        above = row
    return bytes(result)


def _paeth(left: int, above: int, corner: int) -> int:
    estimate = left + above - corner
    return min((left, above, corner), key=lambda value: abs(estimate - value))
