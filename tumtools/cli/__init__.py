# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The command line: one module per command. click, printing and progress bars live only here."""
