# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""rosbag2: a folder with `metadata.yaml` and one or more sqlite3 or MCAP files."""
