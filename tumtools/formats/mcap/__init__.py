# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""MCAP files. Written and read without the reference library, which copies each payload several times."""
