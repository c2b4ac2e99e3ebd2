# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Images that are left to Pillow. Imported where there is one: most sequences have none."""

from __future__ import annotations

import io
import struct
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

import numpy as np
from PIL import Image, UnidentifiedImageError

from tumtools.errors import InputError, UnsupportedInputError
from tumtools.images.limits import check_size

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy.typing as npt

_GREY16: Final = frozenset({"I", "I;16", "I;16L", "I;16B", "I;16N"})
_COLOUR: Final = frozenset({"RGB", "RGBA", "P", "PA", "LA"})
_MOST_16: Final = 2**16 - 1
_BITS: Final = 8
_MOST_8: Final = 2**_BITS - 1
_CODESTREAM: Final = b"\xff\x4f\xff\x51"
"""Begins a JPEG 2000 image; its size follows, then its samples, three bytes each."""
_SAMPLES_AT: Final = 42
_TIFF_BITS: Final = 258
_TIFF_SAMPLES: Final = 277


@contextmanager
def opened(data: bytes | memoryview, failure: str, *formats: str) -> Iterator[Image.Image]:
    """Open an image file; to be decoded within the context.

    Args:
        data: The file.
        failure: What to say if it cannot be opened or decoded.
        formats: As Pillow names them; any if there are none.

    Raises:
        InputError: It cannot be opened, or decoded.

    """
    try:
        with Image.open(io.BytesIO(data), formats=formats or None) as picture:
            check_size(*picture.size)
            yield picture
    except UnsupportedInputError:
        raise
    except UnidentifiedImageError as error:
        raise InputError(f"{failure}: it begins with {bytes(data[:12]).hex(' ') or 'nothing'}") from error
    except (OSError, SyntaxError, ValueError, struct.error, Image.DecompressionBombError) as error:
        raise InputError(f"{failure}: {error}") from error


def pixels_of_file(data: bytes | memoryview) -> tuple[npt.NDArray[np.generic], str]:
    """Decode an image file of any kind, no sample cut or dropped; return its pixels and their encoding.

    Raises:
        UnsupportedInputError: There is no encoding that holds its samples as they are.
        InputError: It cannot be opened, or decoded.

    """
    with opened(data, "not an image that can be read") as picture:
        scale = _scale_of(picture, data)
        mode = picture.mode
        if mode in _GREY16:
            values = np.asarray(picture)
            if scale is not None:
                values = np.rint(values * (scale / _MOST_16))
            if values.min() < 0 or values.max() > _MOST_16:
                raise _refused(picture, f"values from {values.min()} to {values.max()}")
            return values.astype("<u2"), "mono16"
        if mode in {"1", "L"} and not picture.has_transparency_data:
            return np.asarray(picture.convert("L")), "mono8"
        if mode not in _COLOUR and mode not in {"1", "L"}:
            raise _refused(picture)
        if picture.has_transparency_data:
            return np.asarray(picture.convert("RGBA")), "rgba8"
        return np.asarray(picture.convert("RGB")), "rgb8"


def _refused(picture: Image.Image, what: str = "") -> UnsupportedInputError:
    kind = f"{picture.format} images of mode {picture.mode}"
    return UnsupportedInputError(
        f"{kind}{f' with {what}' if what else ''} are not read: "
        "there is no encoding that holds their samples unchanged",
        hint="save it as a PNG file: RGB or RGBA of 8 bits, or grey of 8 or 16",
    )


def _scale_of(picture: Image.Image, data: bytes | memoryview) -> int | None:
    """Return the largest value of a PGM file of 16 bits, by which Pillow scales; call it before decoding.

    Raises:
        UnsupportedInputError: Pillow cuts samples of more than 8 bits to 8 or drops some, and tells nobody.

    """
    if (frames := getattr(picture, "n_frames", 1)) > 1:
        raise UnsupportedInputError(f"a {picture.format} file of {frames} images, where one is expected")
    grey16 = picture.mode in _GREY16
    for tile in getattr(picture, "tile", ()):
        args = tile[3] if isinstance(tile[3], tuple) else (tile[3],)
        if tile[0] in {"ppm", "ppm_plain"} and isinstance(args[-1], int) and args[-1] > _MOST_8:
            if grey16:
                return args[-1]
            raise _refused(picture, f"samples up to {args[-1]}")
        if not grey16 and any(isinstance(arg, str) and ";16" in arg for arg in args):
            raise _refused(picture, "samples of 16 bits")
    if picture.format == "TIFF":
        tags = getattr(picture, "tag_v2", {})
        bits, samples = max(tags.get(_TIFF_BITS, (1,))), tags.get(_TIFF_SAMPLES, 1)
        if (bits > _BITS and picture.mode != "F" and not grey16) or samples > len(picture.getbands()):
            raise _refused(picture, f"{samples} samples of {bits} bits")
    elif picture.format == "JPEG2000":
        at = bytes(data).find(_CODESTREAM)
        found = set(data[at + _SAMPLES_AT : at + _SAMPLES_AT + 3 * len(picture.getbands()) : 3])
        if found != {(2 * _BITS if grey16 else _BITS) - 1}:  # those of signed ones have the highest bit set
            raise _refused(picture, "samples of other than 8 bits, or 16 bits of grey")
    return None
