# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Pictures of trajectories, errors and streams. Needs the extra `plot` (matplotlib)."""
