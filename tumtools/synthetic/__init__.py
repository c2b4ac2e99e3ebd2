# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""A physically consistent synthetic sequence, to try the tool and to test it."""
