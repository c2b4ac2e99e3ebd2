# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A physically consistent synthetic sequence, to try the tool and to test it."""

from __future__ import annotations

from tumtools.synthetic.sequence import DEFAULT_STREAMS, synthesize

__all__ = ["DEFAULT_STREAMS", "synthesize"]
