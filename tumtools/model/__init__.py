# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""What a sequence is. Imports nothing else of tumtools and does no input or output."""
