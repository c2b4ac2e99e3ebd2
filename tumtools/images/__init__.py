# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Pixels: PNG, depth scaling, and an ordered parallel map. The hot code."""
