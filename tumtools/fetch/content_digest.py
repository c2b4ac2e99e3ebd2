# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The content digest of an unpacked sequence, from the checksums of its files: nothing is decoded for it.

It is the digest that a conversion with `--archive` keeps in its target (docs/reference/digest.md, "Kept in
files"), so that an archive can be followed to the download that it was made of.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from tumtools.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from tumtools.model.digest import KeptDigest


def content_digest(folder: Path, sha256: Mapping[str, str]) -> dict[str, KeptDigest]:
    """Return the digest of each stream, without those that cannot be read or lack an image.

    Args:
        folder: The unpacked sequence.
        sha256: Checksums of its files by relative name.

    """
    # Brings numpy, which downloads do without.
    from tumtools.formats.tum.reader import TumSequence, open_tolerant  # noqa: PLC0415 - see above
    from tumtools.model.digest import KeptDigest, digest_of_images, digest_of_rows  # noqa: PLC0415 - see above

    found: dict[str, KeptDigest] = {}
    try:
        sequence = open_tolerant(folder)
    except InputError:
        return found
    with sequence:
        if not isinstance(sequence, TumSequence):
            return found
        readable = {
            stream
            for stream, table in sequence.tables.items()
            if stream not in sequence.damaged and not table.problems
        }
        for stream, names in sequence.names.items():
            if stream in readable and all(name in sha256 for name in names):
                files = (bytes.fromhex(sha256[name]) for name in names)
                value = digest_of_images(zip(sequence.image_stamps(stream).tolist(), files, strict=True))
                found[stream] = KeptDigest(len(names), "files", value)
        for name, signal in (
            ("accelerometer", sequence.accelerometer),
            ("groundtruth", sequence.groundtruth),
        ):
            if signal is not None and name in readable:
                value = digest_of_rows(signal.stamps, signal.values)
                found[name] = KeptDigest(len(signal), "rows", value)
    return found
