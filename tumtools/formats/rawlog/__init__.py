# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""MRPT's .rawlog, both ways (https://docs.mrpt.org/reference/latest/robotics_file_formats.html)."""
