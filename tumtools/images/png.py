# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""PNG files: look at the header, check the chunks, decode any, encode fast.

Encoding uses one filter for the whole image (numpy) and ISA-L's deflate, several times faster than
libpng at a like size. Decoding is Pillow's, but for files with the filters that `encode` uses, which are
undone with numpy. All of it releases the GIL where the time goes.

Source: W3C PNG specification, sections 5 (datastream), 9 (filters) and 11.2 (chunks).
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Final

import numpy as np
import numpy.typing as npt
from isal import isal_zlib
from isal.igzip_lib import IsalError

from tumtools.errors import InputError, UnsupportedInputError
from tumtools.images.limits import check_size

SIGNATURE: Final = b"\x89PNG\r\n\x1a\n"
_DAMAGED_HINT: Final = "the file was damaged or cut off; get it again"
HEADER_SIZE: Final = 33
"""Signature and IHDR chunk: as much as `header` needs."""

_GREY, _RGB, _PALETTE, _GREY_ALPHA, _RGBA = 0, 2, 3, 4, 6
_CHANNELS: Final = {_GREY: 1, _RGB: 3, _PALETTE: 1, _GREY_ALPHA: 2, _RGBA: 4}
_BIT_DEPTHS: Final = {_GREY: {1, 2, 4, 8, 16}, _PALETTE: {1, 2, 4, 8}}
"""Of the colour types that have others than 8 and 16."""
_COLOUR_TYPE: Final = {1: _GREY, 3: _RGB, 4: _RGBA}
_NONE, _SUB, _UP = 0, 1, 2
_CHUNK_OVERHEAD: Final = 12
_CHUNK_HEAD: Final = struct.Struct(">I4s")
"""Length and kind."""
_IHDR: Final = struct.Struct(">IIBBBBB")
_BETWEEN_CHUNKS: Final = struct.Struct(">II4s")
"""CRC of a chunk, then length and kind of the next one."""
_MAX_DEFLATE_RATIO: Final = 1040
"""Deflate makes at most 1032 bytes of one; a header that promises more lies."""
_LEVEL: Final = 1
_BLOCK_ROWS: Final = 24

Pixels = npt.NDArray[np.uint8] | npt.NDArray[np.uint16]


@dataclass(frozen=True, slots=True)
class PngHeader:
    """The IHDR chunk.

    Attributes:
        width: Columns.
        height: Rows.
        bit_depth: 1, 2, 4, 8 or 16 bits a sample.
        colour_type: 0 grey, 2 RGB, 3 palette, 4 grey and alpha, 6 RGBA.
        interlaced: Whether the rows are in Adam7 order.
        transparent: Whether a tRNS chunk makes some colours transparent; known after `check`.

    """

    width: int
    height: int
    bit_depth: int
    colour_type: int
    interlaced: bool
    transparent: bool = False

    @property
    def is_grey16(self) -> bool:
        """Whether it can be depth."""
        return self.bit_depth == 16 and self.colour_type == _GREY  # noqa: PLR2004 - bits or bytes a sample

    @property
    def encoding(self) -> str:
        """Encoding of the decoded pixels, 16-bit grey taken for depth."""
        if self.bit_depth == 16:  # noqa: PLR2004 - bits or bytes a sample
            return "16UC1"
        if self.transparent:
            return "rgba8"
        return {_GREY: "mono8", _RGB: "rgb8", _PALETTE: "rgb8"}.get(self.colour_type, "rgba8")


def _shown(data: bytes) -> str:
    """Return bytes of a file for a message: as text, if they are, or else in hexadecimal digits."""
    text = data.decode("ascii", "replace")
    return (text if text.isascii() and text.isprintable() else data.hex(" ")) or "nothing"


def header(data: bytes | memoryview) -> PngHeader:
    """Read the header from the first `HEADER_SIZE` bytes.

    Raises:
        InputError: These are not the first bytes of a PNG file.

    """
    if data[:8] != SIGNATURE:
        raise InputError(f"not a PNG file: it begins with {_shown(bytes(data[:8]))}", location="offset 0")
    if len(data) < HEADER_SIZE or data[8:16] != b"\0\0\0\rIHDR":
        raise InputError("a PNG file whose header chunk is missing", location="offset 8")
    width, height, bit_depth, colour_type, compression, filtering, interlace = _IHDR.unpack_from(data, 16)
    if (
        not width
        or not height
        or colour_type not in _CHANNELS
        or bit_depth not in _BIT_DEPTHS.get(colour_type, {8, 16})
        or compression
        or filtering
        or interlace > 1
    ):
        raise InputError("a PNG header with impossible values", location="offset 16")
    check_size(width, height, "offset 16")
    return PngHeader(width, height, bit_depth, colour_type, bool(interlace))


def peek(data: bytes | memoryview) -> PngHeader:
    """Read the header and look for transparency, up to the first image data; no CRC is checked.

    Raises:
        InputError: These are not the first bytes of a PNG file.

    """
    found = header(data)
    position = HEADER_SIZE
    while position + _CHUNK_HEAD.size <= len(data):
        length, kind = _CHUNK_HEAD.unpack_from(data, position)
        if kind == b"tRNS":
            return replace(found, transparent=True)
        if kind == b"IDAT":
            break
        position += _CHUNK_OVERHEAD + length
    return found


def check(data: bytes | memoryview) -> PngHeader:
    """Check all chunks and their CRCs, without decoding.

    Raises:
        InputError: With the offset of the chunk that is damaged or missing.

    """
    return _chunks(memoryview(data))[0]


def _chunks(data: memoryview) -> tuple[PngHeader, list[memoryview]]:
    """Check the chunks; return the header, complete, and the parts of the image data."""
    found = header(data)
    chunks = _sound_chunks(data)
    if chunks is None:
        raise _damage(data)
    kinds = [kind for kind, _, _ in chunks]
    if disorder := _disorder(kinds):
        raise InputError(f"a PNG file {disorder}", location="offset 8", hint=_DAMAGED_HINT)
    if found.colour_type == _PALETTE and b"PLTE" not in kinds:
        raise InputError("a PNG file with a palette, but without its PLTE chunk", location="offset 33")
    parts = [data[begin:end] for kind, begin, end in chunks if kind == b"IDAT"]
    promised = _raw_size(found)
    if promised > _MAX_DEFLATE_RATIO * sum(map(len, parts)):
        raise InputError(
            f"the PNG header promises {found.width}x{found.height} pixels, the file is too short",
            location="offset 16",
        )
    return (replace(found, transparent=True) if b"tRNS" in kinds else found), parts


def _disorder(kinds: list[bytes]) -> str:
    """Return what is wrong with the order or the names of chunks; empty if nothing is."""
    if strange := next((kind for kind in set(kinds) if not kind.isalpha()), b""):
        return f"with a chunk whose kind, {_shown(strange)}, is no four letters"
    if kinds.count(b"IHDR") > 1:
        return "with two headers"
    if [kind for kind, _ in groupby(kinds)].count(b"IDAT") > 1:
        return "with another chunk between those of its image data"
    return ""


def _sound_chunks(data: memoryview) -> list[tuple[bytes, int, int]] | None:
    """Return kind, begin and end of the body of each chunk up to IEND; None if anything is wrong with them.

    The CRC of the whole file is held against the one that follows from those of its chunks: the published
    files have fifty each, and to compute them one by one is to give the GIL away and get it back for each.
    """
    crc32, combine, between = isal_zlib.crc32, isal_zlib.crc32_combine, _BETWEEN_CHUNKS.unpack_from
    position = len(SIGNATURE)
    length, kind = _CHUNK_HEAD.unpack_from(data, position)
    expected = crc32(data[: position + 4])
    begin, last = position + _CHUNK_HEAD.size, len(data) - 4
    chunks = []
    while (end := begin + length) <= last:
        chunks.append((kind, begin, end))
        if kind == b"IEND":
            of_chunk = int.from_bytes(data[end : end + 4], "big")
            expected = crc32(data[end : end + 4], combine(expected, of_chunk, length + 4))
            return chunks if crc32(data[: end + 4]) == expected else None
        begin = end + _BETWEEN_CHUNKS.size
        if begin > last:
            break
        of_chunk, following, kind = between(data, end)
        # The CRC of kind and body, then that CRC itself and the length of the next chunk.
        expected = crc32(data[end : end + 8], combine(expected, of_chunk, length + 4))
        length = following
    return None


def _damage(data: memoryview) -> InputError:
    """Return what is wrong with the first chunk that is damaged."""
    position, end = len(SIGNATURE), len(data)
    while position + _CHUNK_OVERHEAD <= end:
        length, kind = _CHUNK_HEAD.unpack_from(data, position)
        following = position + _CHUNK_OVERHEAD + length
        if following > end:
            what = f"the PNG chunk {_shown(kind)} needs {length} bytes, {end - position - 8} are left"
            return InputError(what, location=f"offset {position}", hint=_DAMAGED_HINT)
        of_chunk = int.from_bytes(data[following - 4 : following], "big")
        if isal_zlib.crc32(data[position + 4 : following - 4]) != of_chunk:
            what = f"the CRC of the PNG chunk {_shown(kind)} is wrong"
            return InputError(what, location=f"offset {position}", hint=_DAMAGED_HINT)
        position = following
    what = "the PNG file is cut off: no IEND chunk"
    return InputError(what, location=f"offset {position}", hint=_DAMAGED_HINT)


def _raw_size(found: PngHeader) -> int:
    bits = found.width * _CHANNELS[found.colour_type] * found.bit_depth
    return found.height * (1 + (bits + 7) // 8)


def decode(data: bytes | memoryview) -> Pixels:
    """Decode any PNG whose pixels fit the model.

    Returns:
        uint8 [h, w] for grey, [h, w, 3] for RGB and palette, [h, w, 4] with alpha; uint16 [h, w] for
        16-bit grey.

    Raises:
        InputError: The file is damaged.
        UnsupportedInputError: 16 bits a sample with more than one channel, or too large.

    """
    found, parts = _chunks(memoryview(data))
    if found.bit_depth == 16 and found.colour_type != _GREY:  # noqa: PLR2004 - bits or bytes a sample
        raise UnsupportedInputError("a PNG with 16 bits a sample and colour or alpha is not supported")
    whole_bytes = found.bit_depth >= 8 and found.colour_type in _COLOUR_TYPE.values()  # noqa: PLR2004 - bits or bytes a sample
    if whole_bytes and not found.interlaced and not found.transparent:
        pixels = _decode_plain(found, parts)
        if pixels is not None:
            return pixels
    return _decode_pillow(data, found)


def _decode_plain(found: PngHeader, parts: list[memoryview]) -> Pixels | None:
    """Decode when all rows have the one filter that `encode` uses, else None."""
    compressed = parts[0] if len(parts) == 1 else b"".join(parts)
    size = _raw_size(found)
    stride = size // found.height
    try:
        # The filter of the first rows tells whether it is worth while to go on. For so little, zlib is five
        # times as fast as ISA-L, which makes larger tables first.
        start = zlib.decompressobj().decompress(compressed[: 4 * stride], 2 * stride)
        kinds = set(start[::stride])
        if len(kinds) != 1 or kinds - {_SUB, _UP, _NONE}:
            return None
        raw = isal_zlib.decompressobj().decompress(compressed, size + 1)
        if len(raw) != size:
            raise InputError(
                f"the image data of the PNG file inflates to {len(raw)} bytes, {size} are needed"
            )
    except (zlib.error, IsalError) as error:  # type: ignore[misc]  # its stub declares the class as an instance
        raise InputError(f"the image data of the PNG file is damaged: {error}") from error
    rows = np.frombuffer(raw, np.uint8).reshape(found.height, stride)
    filters = rows[:, 0]
    kind = int(filters[0])
    if not (filters == kind).all():
        return None
    channels = _CHANNELS[found.colour_type]
    sample = found.bit_depth // 8
    filtered = rows[:, 1:].reshape(found.height, found.width, channels * sample)
    if kind == _SUB:
        pixels = _sum_along(rows[:, 1:], channels * sample).reshape(filtered.shape)
    elif kind == _UP:
        pixels = _sum_down(rows[:, 1:])
    else:
        pixels = filtered
    if sample == 2:  # noqa: PLR2004 - bits or bytes a sample
        return np.ascontiguousarray(pixels).view(">u2").astype(np.uint16).reshape(found.height, found.width)
    return pixels.reshape((found.height, found.width) if channels == 1 else filtered.shape)


def _sum_along(rows: npt.NDArray[np.uint8], step: int) -> npt.NDArray[np.uint8]:
    """Return each byte plus all that are a multiple of `step` before it in its row, modulo 256.

    Sums of two neighbours, then of four, and so on, ten passes for 640 pixels. Each goes over all rows as
    over one, since numpy is three times as slow on rows that do not touch each other; what comes in from
    the row before is put right. Five times as fast as `np.add.accumulate`, which waits for each single sum.
    """
    sums = rows.copy()
    spare = np.empty_like(sums)
    reach = step
    while reach < sums.shape[1]:
        np.add(sums.reshape(-1)[reach:], sums.reshape(-1)[:-reach], out=spare.reshape(-1)[reach:])
        spare[:, :reach] = sums[:, :reach]
        sums, spare = spare, sums
        reach *= 2
    return sums


def _sum_down(rows: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Return each row plus all rows above it, modulo 256.

    A few rows of all blocks at a time, then block upon block: eight times as fast as `np.add.accumulate`.
    """
    sums = np.ascontiguousarray(rows)
    sums = sums.copy() if sums is rows else sums
    height, width = sums.shape
    count = height // _BLOCK_ROWS
    blocks = sums[: count * _BLOCK_ROWS].reshape(count, _BLOCK_ROWS, width)
    for row in range(1, _BLOCK_ROWS):
        blocks[:, row] += blocks[:, row - 1]
    for block in range(1, count):
        blocks[block] += blocks[block - 1, -1]
    for row in range(max(count * _BLOCK_ROWS, 1), height):
        sums[row] += sums[row - 1]
    return sums


def _decode_pillow(data: bytes | memoryview, found: PngHeader) -> Pixels:
    from tumtools.images.pillow import opened  # noqa: PLC0415 - brings Pillow

    with opened(data, "the PNG file cannot be decoded", "PNG") as picture:
        picture.load()
        if found.bit_depth == 16:  # noqa: PLR2004 - bits or bytes a sample
            return np.asarray(picture).astype(np.uint16, copy=False)
        mode = {"mono8": "L", "rgb8": "RGB", "rgba8": "RGBA"}[found.encoding]
        return np.asarray(picture if picture.mode == mode else picture.convert(mode))


def encode(pixels: npt.NDArray[np.generic]) -> bytes:
    """Encode as PNG; the same pixels give the same bytes.

    Colour gets the Sub filter, grey the Up filter, which suit them best.

    Args:
        pixels: uint8 [h, w], [h, w, 3] or [h, w, 4], or uint16 [h, w].

    Raises:
        ValueError: Another shape or type.

    """
    channels = {2: 1, 3: pixels.shape[-1]}.get(pixels.ndim, 0)
    if pixels.dtype.newbyteorder("=") not in (np.uint8, np.uint16) or channels not in _COLOUR_TYPE:
        raise ValueError(f"cannot write {pixels.dtype} {pixels.shape} as PNG")
    if pixels.dtype.itemsize == 2 and channels != 1:  # noqa: PLR2004 - bits or bytes a sample
        raise ValueError("16-bit PNG is written for grey only")
    height, width = pixels.shape[:2]
    if not height or not width:
        raise ValueError("a PNG has at least one pixel")
    if pixels.dtype.itemsize == 2:  # noqa: PLR2004 - bits or bytes a sample
        samples = pixels.astype(">u2", order="C").view(np.uint8).reshape(height, 2 * width)
    else:
        samples = np.ascontiguousarray(pixels).view(np.uint8).reshape(height, channels * width)
    filtered = np.empty((height, samples.shape[1] + 1), np.uint8)
    if channels == 1:
        filtered[:, 0] = _UP
        filtered[0, 1:] = samples[0]
        np.subtract(samples[1:], samples[:-1], out=filtered[1:, 1:])
    else:
        filtered[:, 0] = _SUB
        filtered[:, 1 : channels + 1] = samples[:, :channels]
        np.subtract(samples[:, channels:], samples[:, :-channels], out=filtered[:, channels + 1 :])
    bits = 8 * pixels.dtype.itemsize
    head = struct.pack(">IIBBBBB", width, height, bits, _COLOUR_TYPE[channels], 0, 0, 0)
    # isal's compress() needs `bytes`-like contiguous memory; the array is handed over without a copy.
    body = isal_zlib.compress(filtered.data, _LEVEL)
    return b"".join([SIGNATURE, *_chunk(b"IHDR", head), *_chunk(b"IDAT", body), *_chunk(b"IEND", b"")])


def _chunk(kind: bytes, body: bytes) -> tuple[bytes, bytes, bytes]:
    crc = isal_zlib.crc32(body, isal_zlib.crc32(kind))
    return struct.pack(">I4s", len(body), kind), body, struct.pack(">I", crc)
