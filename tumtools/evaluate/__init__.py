# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Association, trajectory errors and statistics, as the benchmark defines them."""
