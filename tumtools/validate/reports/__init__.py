# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The outputs of validate, a module each."""

from __future__ import annotations
