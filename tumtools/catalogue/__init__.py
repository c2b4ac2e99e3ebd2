# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The catalogue of sequences: names, files, sizes, checksums, statistics and errata."""

from __future__ import annotations

from tumtools.catalogue.catalogue import (
    Catalogue,
    UnknownNameError,
    load_catalogue,
    packaged_catalogue,
)
from tumtools.catalogue.entry import Entry, GroundTruthFacts, InnerFile, RemoteFile
from tumtools.catalogue.errata import errata

__all__ = [
    "Catalogue",
    "Entry",
    "GroundTruthFacts",
    "InnerFile",
    "RemoteFile",
    "UnknownNameError",
    "errata",
    "load_catalogue",
    "packaged_catalogue",
]
