# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The layout of the TUM RGB-D benchmark: text files and PNG images in a folder or an archive."""
