# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Images that are left to Pillow. Imported where there is one: most sequences have none."""

from __future__ import annotations

import io
import struct
from contextlib import contextmanager
from typing import TYPE_CHECKING

from PIL import Image, UnidentifiedImageError

from tumtools.errors import InputError, UnsupportedInputError
from tumtools.images.limits import check_size

if TYPE_CHECKING:
    from collections.abc import Iterator


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
