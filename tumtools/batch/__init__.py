# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Many conversions from one manifest: planned, run by an engine, noted in a ledger, never done twice."""
