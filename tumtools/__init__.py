# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Get, check, convert, measure and re-export RGB-D sequences in the layout of the TUM RGB-D benchmark."""

from __future__ import annotations

__version__ = "0.1.0"
