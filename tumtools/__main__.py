# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Entry point of the `tumtools` program."""

from __future__ import annotations

from tumtools.cli.main import main

if __name__ == "__main__":
    main()
